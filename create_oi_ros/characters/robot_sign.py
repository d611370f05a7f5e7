# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A robot on a map of characters: an arrow, and its hull in scale where there is room. Pure."""

from math import tau

from .dots import Dots

CELL_SHAPE = 2.0
"""Height of a character over its width."""
ARROWS, PLAIN_ARROWS = '→↗↑↖←↙↓↘', '>/^\\</v\\'
"""Counter-clockwise from x, in eighths of a turn."""
SMALLEST_HULL = 0.75
"""Cells: radius of the smallest hull that is drawn."""


def arrow(yaw: float, *, plain: bool) -> str:
    """Return the arrow that points in a direction, rad."""
    return (PLAIN_ARROWS if plain else ARROWS)[round(yaw / (tau / 8)) % 8]


def hull(row: float, column: float, radius: float, *, plain: bool) -> Dots:
    """Return a ring around a place, its radius in widths of a cell; none where it is too small."""
    dots = Dots()
    if radius >= SMALLEST_HULL and not plain:
        dots.ring(row, column, radius / CELL_SHAPE, radius)
    return dots
