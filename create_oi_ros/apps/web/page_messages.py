# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a page may send: each message, its fields, and what they may be. Pure."""

from __future__ import annotations

from collections.abc import Mapping
import json
from typing import Any, NamedTuple

from ...driver.outputs import LONGEST_NOTE
from ...oi import Mode, Song, SOUNDING
from ...robot import TOP_SPEED
from .driver_seat import TOP_TURN
from .page_checks import FieldCheck, FLAG, number, one_of, whole
from .page_goals import GOALS

assert Song.tail is not None
LONGEST_SONG = Song.tail.counted.high
"""Notes."""
LOWEST_NOTE, HIGHEST_NOTE = SOUNDING[0], SOUNDING[-1]


class MessageError(ValueError):
    """A message is wrong; the text says what is wrong and what is allowed."""


def _is_note(note: Any) -> bool:
    return (isinstance(note, list) and len(note) == 2
            and whole(LOWEST_NOTE, HIGHEST_NOTE).passes(note[0])
            and number(0, LONGEST_NOTE).passes(note[1]))


NOTES = FieldCheck(
    lambda value: isinstance(value, list) and 0 < len(value) <= LONGEST_SONG
    and all(map(_is_note, value)),
    f'1 to {LONGEST_SONG} pairs of a note from {LOWEST_NOTE} to {HIGHEST_NOTE} and its seconds')
MESSAGES: Mapping[str, Mapping[str, FieldCheck]] = {
    'drive': {'linear': number(-TOP_SPEED, TOP_SPEED), 'angular': number(-TOP_TURN, TOP_TURN),
              'seen': number(0, 1e12)},
    'release': {},
    'stop': {},
    'take_over': {},
    'leave': {},
    'mode': {'mode': one_of(*(mode.name.lower() for mode in Mode if mode is not Mode.OFF))},
    'song': {'notes': NOTES},
    'leds': {'play': FLAG, 'advance': FLAG, 'color': whole(0, 255), 'intensity': whole(0, 255)},
    'reset_odometry': {},
    'cancel': {},
    'ping': {},
    'record': {'on': FLAG},
    **{name: goal.checks for name, goal in GOALS.items()},
}
"""Each message by its `type`, with the checks of its fields."""


class PageMessage(NamedTuple):
    """A message that is as it should be."""

    type: str
    fields: Mapping[str, Any]


def read(text: str) -> PageMessage:
    """Read a message; MessageError says what is wrong."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):  # numbers of thousands of digits, lists in lists
        raise MessageError('this is no JSON') from None
    if not isinstance(found, dict):
        raise MessageError('allowed is a JSON object with a "type"')
    type_ = found.pop('type', None)
    if not isinstance(type_, str) or type_ not in MESSAGES:
        raise MessageError(f'unknown type; allowed: {", ".join(MESSAGES)}')
    checks = MESSAGES[type_]
    if found.keys() != checks.keys():
        raise MessageError(f'{type_}: allowed fields: {", ".join(checks) or "none"}')
    for name, check in checks.items():
        if not check.passes(found[name]):
            raise MessageError(f'{type_}: {name} is not allowed; allowed: {check.allowed}')
    return PageMessage(type_, found)
