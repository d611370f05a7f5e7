# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Names of notes; tunes as people write them: notes with their lengths, or a ring tone (RTTTL).

The manual names notes without an octave (Song, Note Durations). Here the octave is that of
scientific pitch: middle C, number 60 at 261.6 Hz, is C4; the lowest note that sounds, 31, is G1.

Notes are `C4:1/4 rest:0.5 60:1/8`, separated by spaces or commas: a name, `rest`, or a MIDI
number, and a length in seconds. A ring tone is `name:d=4,o=5,b=160:8e6,8d6,f#,p,16a#.`: its
defaults (note value, octave, quarter notes a minute), then notes as [value]name[octave][.]. Ring
tones that people have differ from that, and are read: with the dot before name or octave, flats
(`b_`, `bb`), h for b, 64ths and triplets, defaults without `=` or among the notes, and those of
style and loop (`s`, `l`), which mean nothing here.
"""

from collections.abc import Iterator
from fractions import Fraction
from math import ceil, floor
import re

from ..commands import Note, NOTE_TIME, NOTES_PER_SECOND, REST, SOUNDING

PITCHES = ('C', 'C#', 'D', 'D#', 'E', 'F', 'F#', 'G', 'G#', 'A', 'A#', 'B')
"""The manual's names of the notes in an octave."""
MIDDLE_C = 60
NOTE_NUMBER = re.compile(r'\d{1,9}')
"""Longer ones mean nothing, and Python refuses to read them."""
NOTE_NAME = re.compile(r'([A-G])(#|b?)(\d)', re.IGNORECASE)
SHORTEST, LONGEST = Fraction(1, NOTES_PER_SECOND), 60
"""Seconds that a note of a tune can last."""
PART = Fraction(NOTE_TIME.high, NOTES_PER_SECOND)
"""Seconds that a note of the robot can last: a longer one is played as several."""
LENGTH = re.compile(r'\d{1,6}(/[1-9]\d{0,5})?|\d{0,6}\.\d{1,6}', re.ASCII)
VALUES = range(1, 64 + 1)
"""Note values of a ring tone: 4 is a quarter note, 12 a triplet of eighths."""
DEFAULTS = {'d': 4, 'o': 6, 'b': 63}
"""What a ring tone leaves out: note value, octave, quarter notes a minute."""
WITHOUT_MEANING = 'sl'
"""Defaults that are not for a robot: style and loop."""
DEFAULT = re.compile(r'([a-z])=?(\w{1,9})', re.ASCII | re.IGNORECASE)
RING_NOTE = re.compile(r'(\d{0,9})\.?(p|[a-h][#b_]?)\.?(\d?)\.?', re.ASCII | re.IGNORECASE)


def note_name(number: int) -> str:
    """Return the name of a note that sounds, such as 'C#4' for 61; ValueError for others."""
    if number not in SOUNDING:
        raise ValueError(f'note {number} makes no sound; allowed: {_described()}')
    octave, pitch = divmod(number - MIDDLE_C, len(PITCHES))
    return f'{PITCHES[pitch]}{4 + octave}'


def note_text(number: int) -> str:
    """Return the name of a note, 'rest', or the number of another one that makes no sound."""
    if number in SOUNDING:
        return note_name(number)
    return 'rest' if number == REST else str(number)


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


def parse_tune(text: str) -> tuple[Note, ...]:
    """
    Return the notes of a tune, in the robot's units; ValueError says what is wrong.

    The end of each note is rounded to 1/64 s, so that the tune keeps its speed.
    """
    defaults, tones = ['', *text.rsplit(':', 2)][-2:]
    # Between two colons of a list, a length comes first.
    ring_tone = '=' in defaults or text.count(':') > 1 and not LENGTH.match(defaults)
    notes, end, ticks = [], Fraction(0), 0
    for word, number, seconds in _ring_tone(defaults, tones) if ring_tone else _listed(text):
        if not SHORTEST <= seconds <= LONGEST:
            raise ValueError(f'{word!r} lasts {float(seconds):g} s; allowed: {SHORTEST} to '
                             f'{LONGEST} s')
        parts = ceil(seconds / PART)
        for _ in range(parts):
            end += seconds / parts
            until = floor(end * NOTES_PER_SECOND + Fraction(1, 2))
            notes.append(Note(number, until - ticks))
            ticks = until
    if not notes:
        raise ValueError('a tune needs a note, such as C4:1/4')
    return tuple(notes)


def _listed(text: str) -> Iterator[tuple[str, int, Fraction]]:
    """Yield each note of a list: its text, number and seconds."""
    for word in text.replace(',', ' ').split():
        name, _, length = word.partition(':')
        if not LENGTH.fullmatch(length):
            raise ValueError(f'{word!r}: a note has a length in seconds, such as C4:1/4, C4:0.25')
        yield word, _number(name), Fraction(length)


def _number(name: str) -> int:
    if name.lower() == 'rest':
        return REST
    if not NOTE_NUMBER.fullmatch(name):
        return note_number(name)
    if int(name) not in SOUNDING:
        raise ValueError(f"note {name} makes no sound; allowed: {SOUNDING[0]} to {SOUNDING[-1]}, "
                         "names such as C4, and 'rest'")
    return int(name)


def _ring_tone(defaults: str, tones: str) -> Iterator[tuple[str, int, Fraction]]:
    """Yield each note of a ring tone: its text, number and seconds."""
    usual = dict(DEFAULTS)
    for word in _words(defaults):
        _set_default(usual, word)
    for word in _words(tones):
        if '=' in word:
            _set_default(usual, word)
            continue
        match = RING_NOTE.fullmatch(word)
        if match is None or word.count('.') > 1:
            raise ValueError(f'{word!r} is no note of a ring tone; allowed: 8c, 4f#5, 16a. or 2p')
        length, name, octave = match.groups()
        value = int(length or usual['d'])
        if value not in VALUES:
            raise ValueError(f'{word!r} is a note of 1/{value}; allowed: 1 to {VALUES[-1]}')
        seconds = Fraction(4 * 60, usual['b'] * value)
        if '.' in word:
            seconds *= Fraction(3, 2)
        name = name.lower().replace('_', 'b').replace('h', 'b')
        number = REST if name == 'p' else note_number(f'{name}{octave or usual["o"]}')
        yield word, number, seconds


def _words(text: str) -> Iterator[str]:
    """Yield what stands between commas, without its spaces."""
    return filter(None, (''.join(each.split()) for each in re.split('[,;]', text)))


def _set_default(usual: dict[str, int], word: str) -> None:
    """Take over what the notes of a ring tone leave out."""
    match = DEFAULT.fullmatch(word.lower())
    name, amount = match.groups() if match else ('', '')
    if name in WITHOUT_MEANING and match:
        return
    if name not in usual or not amount.isdecimal() or not int(amount):
        raise ValueError(f'{word!r} is no default of a ring tone; allowed: d=4, o=6, b=63')
    usual[name] = int(amount)
