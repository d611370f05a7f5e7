# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Braille dots: two by four to a cell, for tracks and circles. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, cos, floor, hypot, sin, tau

ACROSS, DOWN = 2, 4
"""Dots of a cell."""
BRAILLE = 0x2800
BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""Bits of a Braille character, by row and column."""


class Dots:
    """Dots on a grid of cells."""

    def __init__(self) -> None:
        self._patterns: dict[tuple[int, int], int] = {}

    def add(self, row: float, column: float) -> None:
        """Add a dot at a place in cells; its fractions choose the dot."""
        down, across = floor(row * DOWN), floor(column * ACROSS)
        cell = down // DOWN, across // ACROSS
        bit = BITS[down % DOWN][across % ACROSS]
        self._patterns[cell] = self._patterns.get(cell, 0) | bit

    def ring(self, row: float, column: float, height: float, width: float) -> None:
        """Add a ring around a place; height and width are its radii in cells."""
        steps = max(8, ceil(tau * hypot(height * DOWN, width * ACROSS)))
        for step in range(steps):
            turn = tau * step / steps
            self.add(row + height * sin(turn), column + width * cos(turn))

    def characters(self, *, plain: bool = False) -> Iterator[tuple[tuple[int, int], str]]:
        """Yield each cell, row and column, with its character."""
        for cell, bits in self._patterns.items():
            yield cell, '.' if plain else chr(BRAILLE + bits)
