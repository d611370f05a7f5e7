# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Decodes the bytes of a terminal to keys, and maps keys to actions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from math import inf, pi

from ...driver.goals.wall_following import RIGHT
from ...oi import Mode
from ...oi.commands import SONG_NUMBER

ESCAPE = '\x1b'
ARROWS = {'A': 'up', 'B': 'down', 'C': 'right', 'D': 'left'}
FINAL = range(0x40, 0x7f)
"""Characters that end an escape sequence."""
CONFIRM = 1.0
"""Seconds in which a key that asks must be pressed again."""
SONG = SONG_NUMBER.high
"""Song number of our tune: the last one, which others use least."""


@dataclass(frozen=True)
class DriveKey:
    """A key that drives: 1 or -1 forward or counter-clockwise; 0: that axis is unchanged."""

    forward: int = 0
    turn: int = 0


@dataclass(frozen=True)
class ServiceCall:
    """A service to call, with the fields of its request."""

    service: str
    fields: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class GoalCall:
    """A goal of an action to send, with its fields."""

    name: str
    fields: Mapping[str, object] = field(default_factory=dict)


class ViewCommand(Enum):
    """What the view itself does."""

    STOP = 'stop'
    FASTER = 'faster'
    SLOWER = 'slower'
    CLEAR = 'clear'
    REDRAW = 'redraw'
    HELP = 'help'
    SUSPEND = 'suspend'
    QUIT = 'quit'


Action = DriveKey | ServiceCall | GoalCall | ViewCommand


@dataclass(frozen=True)
class Binding:
    """Keys, their action, and their line on the help page; none if the line before names them."""

    keys: tuple[str, ...]
    action: Action
    shown: str = ''
    about: str = ''


def _mode(mode: Mode) -> ServiceCall:
    return ServiceCall('set_mode', {'mode': mode.value})


TUNE: dict[str, object] = {
    'number': SONG, 'pitches': [67, 72, 76, 79], 'seconds': [0.15, 0.15, 0.15, 0.3], 'play': True}
STOP = ServiceCall('stop')
"""Called when space is pressed, after the keys are released."""
MOVING = ('dock', 'start_demo', 'undock', 'wall_follow')
"""Services and actions in which the robot finds its own way: their keys count when pressed
twice."""
STEP, QUARTER = 0.3, pi / 2
"""Metres and radians of the keys that drive a set way."""
BINDINGS = (
    Binding(('up', 'w'), DriveKey(forward=1), 'up w', 'forward, as long as it is held'),
    Binding(('down', 's'), DriveKey(forward=-1), 'down s', 'backward'),
    Binding(('left', 'a'), DriveKey(turn=1), 'left a', 'turn left; with up: a curve'),
    Binding(('right', 'd'), DriveKey(turn=-1), 'right d', 'turn right'),
    Binding((' ',), ViewCommand.STOP, 'space', 'stop wheels and demos at once'),
    Binding(('+', '='), ViewCommand.FASTER, '+ -', 'drive faster, slower'),
    Binding(('-', '_'), ViewCommand.SLOWER),
    Binding(('1',), _mode(Mode.PASSIVE), '1 2 3', 'Passive, Safe, Full'),
    Binding(('2',), _mode(Mode.SAFE)),
    Binding(('3',), _mode(Mode.FULL)),
    Binding(('p',), ServiceCall('define_song', TUNE), 'p', f'play a tune (stored as song {SONG})'),
    Binding(('i',), GoalCall('drive_distance', {'distance': STEP}), 'i k',
            '30 cm forward, backward'),
    Binding(('k',), GoalCall('drive_distance', {'distance': -STEP})),
    Binding(('j',), GoalCall('rotate_angle', {'angle': QUARTER}), 'j l',
            '90 degrees left, right'),
    Binding(('l',), GoalCall('rotate_angle', {'angle': -QUARTER})),
    Binding(('f',), GoalCall('wall_follow', {'follow_side': RIGHT}), 'f f',
            'follow a wall: press twice'),
    Binding(('g',), GoalCall('dock'), 'g g', 'go to the Home Base: press twice'),
    Binding(('u',), GoalCall('undock'), 'u u', 'leave the Home Base: press twice'),
    Binding(('r',), ServiceCall('reset_odometry'), 'r', 'reset the odometry'),
    Binding(('c',), ViewCommand.CLEAR, 'c', 'clear the map'),
    Binding(('\x0c',), ViewCommand.REDRAW, '^L', 'draw the screen again'),
    Binding(('h', '?'), ViewCommand.HELP, 'h ?', 'show or hide this'),
    Binding(('\x1a',), ViewCommand.SUSPEND, '^Z', 'stop and suspend; fg continues'),
    Binding(('q', '\x03', '\x04'), ViewCommand.QUIT, 'q', 'stop and end'),
)
ACTIONS: dict[str, Action] = {key: each.action for each in BINDINGS for key in each.keys}


def action_of(key: str) -> Action | None:
    """Return the action of a key, None if it has none; upper case counts as lower case."""
    return ACTIONS.get(key.lower() if len(key) == 1 else key)


def moves_by_itself(action: Action) -> bool:
    """Tell whether the robot finds its own way in this action."""
    match action:
        case ServiceCall(service=name) | GoalCall(name=name):
            return name in MOVING
    return False


class Confirmation:
    """Asks for the second press of a key whose action moves the robot by itself."""

    def __init__(self) -> None:
        self._asked: Action | None = None
        self._until = -inf

    def confirmed(self, action: Action, now: float) -> bool:
        """Take a key's action; return whether to do it, False: ask for the same key again."""
        second = action == self._asked and now <= self._until
        self._asked = None
        if second or not moves_by_itself(action):
            return True
        self._asked, self._until = action, now + CONFIRM
        return False


class KeyDecoder:
    """Splits the bytes of a terminal into keys; a sequence may arrive in pieces."""

    def __init__(self) -> None:
        self._sequence = ''
        """The beginning of an escape sequence that is not complete yet."""

    def decode(self, received: bytes) -> Iterator[str]:
        """Yield each key: a character, the name of an arrow, or '' for any other key."""
        for character in received.decode('latin-1'):
            if not self._sequence and character != ESCAPE:
                yield character
            elif character == ESCAPE:
                # Escape alone, or a sequence that was cut off: ignored.
                self._sequence = ESCAPE
            else:
                yield from self._continue(character)

    def _continue(self, character: str) -> Iterator[str]:
        self._sequence += character
        if len(self._sequence) == 2:
            if character not in '[O':
                # Alt with a key, or Escape and then a key, counts as the key alone.
                self._sequence = ''
                yield character
        elif ord(character) in FINAL:
            # Shift and Ctrl add digits before the last character: still the same arrow.
            self._sequence = ''
            yield ARROWS.get(character, '')
