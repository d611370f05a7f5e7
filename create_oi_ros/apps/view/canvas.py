"""A sheet of characters of a fixed size; nothing that is put on it leaves it or its cell."""

from __future__ import annotations

from itertools import groupby
from unicodedata import category, east_asian_width

UNKNOWN = '?'
"""Stands for what would not fill one cell: control characters, wide or combining ones."""


def one_cell(character: str, *, plain: bool) -> str:
    """Return the character, or the sign for one that a terminal might obey or draw wider."""
    if plain:
        return character if ' ' <= character <= '~' else UNKNOWN
    fits = (character.isprintable() and not category(character).startswith('M')
            and east_asian_width(character) not in 'WF')
    return character if fits else UNKNOWN


class Canvas:
    """Rows and columns from 0; `plain`: ASCII only."""

    def __init__(self, columns: int, rows: int, *, plain: bool = False) -> None:
        self.columns, self.rows, self.plain = columns, rows, plain
        self._cells = [[(' ', False)] * columns for _ in range(rows)]

    def put(
        self, row: int, column: int, text: str, *, loud: bool = False, width: int | None = None,
    ) -> int:
        """Write a text, cut to `width` and to the sheet; return the column behind it."""
        for character in text[:width]:
            if 0 <= row < self.rows and 0 <= column < self.columns:
                self._cells[row][column] = one_cell(character, plain=self.plain), loud
            column += 1
        return column

    def lines(self) -> list[str]:
        """Return the text, row by row, each exactly as long as the sheet is wide."""
        return [''.join(character for character, _ in row) for row in self._cells]

    def runs(self) -> list[list[tuple[str, bool]]]:
        """Return each row as pieces of text, and whether they are to be seen at once."""
        return [[(''.join(character for character, _ in piece), loud)
                 for loud, piece in groupby(row, lambda cell: cell[1])] for row in self._cells]
