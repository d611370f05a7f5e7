# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Chooses the points of a long curve that a chart needs. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan


def kept(columns: Sequence[Sequence[float]], most: int) -> list[int]:
    """
    Return the indices of at most `most` points.

    The curve is cut into equal pieces. Of each piece its first point stays, and of each column the
    points with the least and the greatest value, so no peak is lost. All stay if there are few.
    """
    count = len(columns[0])
    if count <= most:
        return list(range(count))
    pieces = max(1, (most - 1) // (2 * len(columns) + 1))
    chosen = {count - 1}
    for piece in range(pieces):
        first, end = piece * count // pieces, (piece + 1) * count // pieces
        chosen.add(first)
        for column in columns:
            known = [place for place in range(first, end) if not isnan(column[place])]
            if known:
                chosen |= {min(known, key=column.__getitem__), max(known, key=column.__getitem__)}
    return sorted(chosen)
