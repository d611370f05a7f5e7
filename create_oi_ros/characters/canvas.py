# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A grid of characters of fixed size; text outside it is cut off."""

from __future__ import annotations

from itertools import groupby
from unicodedata import category, east_asian_width

from .ink import Ink, InkedText

UNKNOWN = '?'
"""Replaces every character that does not fill exactly one cell: control, wide, combining."""


def one_cell(character: str, *, plain: bool) -> str:
    """Return the character, or UNKNOWN if a terminal might obey it or draw it wider."""
    if plain:
        return character if ' ' <= character <= '~' else UNKNOWN
    fits = (character.isprintable() and not category(character).startswith('M')
            and east_asian_width(character) not in 'WF')
    return character if fits else UNKNOWN


class Canvas:
    """Rows and columns from 0; `plain`: ASCII only."""

    def __init__(self, columns: int, rows: int, *, plain: bool = False) -> None:
        self.columns, self.rows, self.plain = columns, rows, plain
        self._cells = [[InkedText(' ')] * columns for _ in range(rows)]

    def put(
        self, row: int, column: int, text: str, *, highlighted: bool = False,
        ink: Ink = Ink.PLAIN, width: int | None = None,
    ) -> int:
        """Write a text, cut to `width` and to the canvas; return the column after it."""
        for character in text[:width]:
            if 0 <= row < self.rows and 0 <= column < self.columns:
                self._cells[row][column] = InkedText(
                    one_cell(character, plain=self.plain), highlighted, ink)
            column += 1
        return column

    def lines(self) -> list[str]:
        """Return the text of each row, exactly `columns` characters long."""
        return [''.join(cell.text for cell in row) for row in self._cells]

    def runs(self) -> list[list[InkedText]]:
        """Return each row as runs of characters that look alike."""
        return [[InkedText(''.join(cell.text for cell in cells), *look)
                 for look, cells in groupby(row, lambda cell: cell[1:])]
                for row in self._cells]
