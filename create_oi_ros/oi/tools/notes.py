# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Names of the notes of a song from their numbers, and back (manual: Song, Note Durations).

The manual names notes without an octave. Here the octave is that of scientific pitch: middle C,
number 60 at 261.6 Hz, is C4, and the lowest note that sounds, number 31, is G1.
"""

import re

from ..commands import SOUNDING

PITCHES = ('C', 'C#', 'D', 'D#', 'E', 'F', 'F#', 'G', 'G#', 'A', 'A#', 'B')
"""The manual's names of the notes in an octave."""
MIDDLE_C = 60
NOTE_NAME = re.compile(r'([A-G])(#|b?)(\d)', re.IGNORECASE)


def note_name(number: int) -> str:
    """Return the name of a note that sounds, such as 'C#4' for 61; ValueError for others."""
    if number not in SOUNDING:
        raise ValueError(f'note {number} makes no sound; allowed: {_described()}')
    octave, pitch = divmod(number - MIDDLE_C, len(PITCHES))
    return f'{PITCHES[pitch]}{4 + octave}'


def note_number(name: str) -> int:
    """
    Return the number of a note that sounds, such as 61 for 'C#4', 'c#4' or 'Db4'.

    ValueError if there is no such note or it makes no sound.
    """
    match = NOTE_NAME.fullmatch(name)
    if match is None:
        raise ValueError(f'{name!r} is not a note; allowed: names such as C4, C#4 or Db4')
    letter, accidental, octave = match.groups()
    number = MIDDLE_C + len(PITCHES) * (int(octave) - 4) + PITCHES.index(letter.upper())
    number += {'#': 1, '': 0}.get(accidental, -1)
    if number not in SOUNDING:
        raise ValueError(f'{name} makes no sound; allowed: {_described()}')
    return number


def _described() -> str:
    low, high = SOUNDING[0], SOUNDING[-1]
    return f'{low} ({note_name(low)}) to {high} ({note_name(high)})'
