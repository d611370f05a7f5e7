# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Lines of box characters: what meets in a cell is joined. Pure."""

from __future__ import annotations

from collections.abc import Iterator

UP, RIGHT, DOWN, LEFT = 1, 2, 4, 8
BOXES = ' ╵╶└╷│┌├╴┘─┴┐┤┬┼'
"""Each character at the sum of the sides to which it leads."""
PLAIN = {UP: '|', DOWN: '|', UP | DOWN: '|', LEFT: '-', RIGHT: '-', LEFT | RIGHT: '-'}
Cell = tuple[int, int]
"""Row and column."""


def cells_between(start: Cell, end: Cell) -> Iterator[Cell]:
    """Yield cells from start to end, each beside or above the one before."""
    (row, column), (rows, columns) = start, (end[0] - start[0], end[1] - start[1])
    down, right = (rows > 0) - (rows < 0), (columns > 0) - (columns < 0)
    yield row, column
    gone_rows = gone_columns = 0
    while (gone_rows, gone_columns) != (abs(rows), abs(columns)):
        # Go along whichever side is further behind.
        if gone_columns * abs(rows) <= gone_rows * abs(columns) and gone_columns < abs(columns):
            gone_columns += 1
        elif gone_rows < abs(rows):
            gone_rows += 1
        else:
            gone_columns += 1
        yield row + down * gone_rows, column + right * gone_columns


class BoxLines:
    """Lines on a grid."""

    def __init__(self) -> None:
        self._sides: dict[Cell, int] = {}

    def add(self, start: Cell, end: Cell) -> None:
        """Add a line."""
        before: Cell | None = None
        for cell in cells_between(start, end):
            self._sides.setdefault(cell, 0)
            if before is not None:
                there, back = SIDES[cell[0] - before[0], cell[1] - before[1]]
                self._sides[before] |= there
                self._sides[cell] |= back
            before = cell

    def characters(self, *, plain: bool = False) -> Iterator[tuple[Cell, str]]:
        """Yield each cell with its character."""
        for cell, sides in self._sides.items():
            if plain:
                yield cell, PLAIN.get(sides, '+')
            else:
                yield cell, BOXES[sides] if sides else '·'


SIDES = {(-1, 0): (UP, DOWN), (1, 0): (DOWN, UP), (0, 1): (RIGHT, LEFT), (0, -1): (LEFT, RIGHT)}
"""Side of a cell, and of its neighbour, by the step from one to the other."""
