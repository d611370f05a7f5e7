# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Logs of real wheels: encoder counts over time."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from itertools import pairwise

C2_TICK = 0.0004446
"""Metres a count of a Create 2."""
COUNTS = 65536


@dataclass(frozen=True, slots=True)
class WheelLog:
    """Metres that each wheel has travelled at each moment, seconds."""

    times: tuple[float, ...]
    right: tuple[float, ...]
    left: tuple[float, ...]

    @classmethod
    def parse(cls, text: str, tick: float = C2_TICK) -> WheelLog:
        """Read a CSV with the columns time_s, encoder_left and encoder_right (16 bits)."""
        rows = list(csv.DictReader(text.splitlines()))
        if len(rows) < 2:
            raise ValueError('a recording has two rows or more')
        return cls(tuple(float(row['time_s']) for row in rows),
                   _unwrapped([int(row['encoder_right']) for row in rows], tick),
                   _unwrapped([int(row['encoder_left']) for row in rows], tick))


def _unwrapped(counts: list[int], tick: float) -> tuple[float, ...]:
    """Return metres since the first count, from counts that wrap at 16 bits."""
    total, metres = 0, [0.0]
    for a, b in pairwise(counts):
        total += (b - a + COUNTS // 2) % COUNTS - COUNTS // 2
        metres.append(total * tick)
    return tuple(metres)
