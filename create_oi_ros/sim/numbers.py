# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers that people write: in world files, in guesses, on the control socket."""

import math

LONGEST = 40
"""Characters of a wrong word that an error repeats: a file may hold anything."""


def number(text: str) -> float:
    """Return the finite number that a text is; ValueError for any other text."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f'{text[:LONGEST]!r} is not a number')
    return value


TOLERANCE = 1e-6
"""Seconds by which a sum of floats may fall short of the time it stands for."""
