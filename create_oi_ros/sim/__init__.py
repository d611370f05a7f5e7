# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A simulated Create: the robot's side of the Open Interface.

`world` is the room, `body` the robot's mechanics and battery in it, `firmware` what the robot
does with each byte, `server` the pty or TCP port that other programs open. All but `server` are
pure: time is an argument, random numbers come from a seed, and nothing is read or written. What
several of them use is here.
"""

import math

LONGEST = 40
"""Characters of a wrong word that an error repeats: a file may hold anything."""
FARTHEST = 1e6
"""Largest number that a file or a line may have: squares of larger ones may be infinite."""
TOLERANCE = 1e-6
"""Seconds by which a sum of floats may fall short of the time it stands for."""


def number(text: str) -> float:
    """Return the finite number that a text is; ValueError for any other text."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f'{text[:LONGEST]!r} is not a number')
    if abs(value) > FARTHEST:
        raise ValueError(f'{text[:LONGEST]!r}; allowed: {-FARTHEST:.0f} to {FARTHEST:.0f}')
    return value
