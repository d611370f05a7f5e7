# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of a terminal. A colour is never the only sign: what it says stands in words, too."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import NamedTuple

RESET, REVERSE = '\x1b[0m', '7'


class Ink(Enum):
    """What a text is; the value is its colour for the escape sequence SGR, '' for none."""

    PLAIN = ''
    FAINT = '2'
    GOOD = '32'
    WARN = '33'
    BAD = '31'
    TRACK = '36'
    ROBOT = '1'
    SIGNAL = '35'


class InkedText(NamedTuple):
    """Characters beside each other that look alike."""

    text: str
    highlighted: bool = False
    ink: Ink = Ink.PLAIN


def has_colors(environment: Mapping[str, str]) -> bool:
    """Return whether to write colours: NO_COLOR, if it is set to anything, means no."""
    return not environment.get('NO_COLOR') and environment.get('TERM', 'dumb') != 'dumb'


def encoded(row: Iterable[InkedText], *, colors: bool) -> str:
    """
    Return a row with its escape sequences.

    Fonts draw some characters wider or narrower than a cell. So after a run with any that is not
    ASCII, the cursor is put where the next run belongs, and what is below each other stays so.
    """
    parts, column, moved = [], 1, False
    for text, highlighted, ink in row:
        if moved:
            parts.append(f'\x1b[{column}G')
        codes = [REVERSE] * highlighted + [ink.value] * (colors and ink is not Ink.PLAIN)
        parts.append(f'\x1b[{";".join(codes)}m{text}{RESET}' if codes else text)
        column += len(text)
        moved = not text.isascii()
    return ''.join(parts)
