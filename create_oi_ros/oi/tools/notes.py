"""
Names of the notes of a song, both ways (manual: Song, Note Durations).

The manual names notes without their octave; here the octave is that of scientific pitch, in which
middle C, number 60 at 261.6 Hz, is C4 and the lowest note that sounds, number 31, is G1.
"""

import re

from ..commands import SOUNDING

PITCHES = ('C', 'C#', 'D', 'D#', 'E', 'F', 'F#', 'G', 'G#', 'A', 'A#', 'B')
"""The manual's names of the notes of an octave, upwards from C."""
MIDDLE_C = 60
CONCERT_A = 69
_NAME = re.compile(r'([A-G])(#|b?)(\d)', re.IGNORECASE)


def note_name(number: int) -> str:
    """Return the name of a note that sounds, such as 'C#4' for 61; ValueError beyond 31 to 127."""
    if number not in SOUNDING:
        raise ValueError(f'note {number} makes no sound; {_described()} do')
    octave, pitch = divmod(number - MIDDLE_C, len(PITCHES))
    return f'{PITCHES[pitch]}{4 + octave}'


def note_number(name: str) -> int:
    """
    Return the number of a note that sounds, such as 61 for 'C#4' or 'Db4', in any case.

    ValueError where there is no such note, or where it would make no sound.
    """
    match = _NAME.fullmatch(name)
    if match is None:
        raise ValueError(f'{name!r} is no note such as C4, C#4 or Db4')
    letter, accidental, octave = match.groups()
    number = MIDDLE_C + len(PITCHES) * (int(octave) - 4) + PITCHES.index(letter.upper())
    number += {'#': 1, '': 0}.get(accidental, -1)
    if number not in SOUNDING:
        raise ValueError(f'{name} makes no sound; {_described()} do')
    return number


def note_frequency(number: int) -> float:
    """Return the frequency of a note number in Hz, as the manual's table has it."""
    return float(440 * 2 ** ((number - CONCERT_A) / len(PITCHES)))


def _described() -> str:
    low, high = SOUNDING[0], SOUNDING[-1]
    return f'{low} ({note_name(low)}) to {high} ({note_name(high)})'
