"""From bytes of a terminal to keys, and from keys to what they are for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum

from ...oi import Mode

ESCAPE = '\x1b'
ARROWS = {'A': 'up', 'B': 'down', 'C': 'right', 'D': 'left'}
FINAL = range(0x40, 0x7f)
"""Characters that end a control sequence."""
SONG = 15
"""Number under which our tune is stored: the last, which others use least."""


@dataclass(frozen=True)
class Drive:
    """Drive this way: 1 or -1 along an axis, forward or counter-clockwise; 0: leave it."""

    forward: int = 0
    turn: int = 0


@dataclass(frozen=True)
class Ask:
    """Call a service."""

    service: str
    fields: Mapping[str, object] = field(default_factory=dict)


class Own(Enum):
    """What the view does by itself."""

    STOP = 'stop'
    FASTER = 'faster'
    SLOWER = 'slower'
    CLEAR = 'clear'
    REDRAW = 'redraw'
    HELP = 'help'
    QUIT = 'quit'


Action = Drive | Ask | Own


@dataclass(frozen=True)
class Binding:
    """Keys, what they do, and how the help page says it."""

    keys: tuple[str, ...]
    action: Action
    shown: str
    about: str


def _mode(mode: Mode) -> Ask:
    return Ask('set_mode', {'mode': mode.value})


TUNE: dict[str, object] = {
    'number': SONG, 'pitches': [67, 72, 76, 79], 'seconds': [0.15, 0.15, 0.15, 0.3], 'play': True}
STOP = Ask('stop')
"""What a pressed space asks for, besides letting go of the keys."""
BINDINGS = (
    Binding(('up', 'w'), Drive(forward=1), 'up w', 'forward, as long as it is held'),
    Binding(('down', 's'), Drive(forward=-1), 'down s', 'backward'),
    Binding(('left', 'a'), Drive(turn=1), 'left a', 'turn left; with up: a curve'),
    Binding(('right', 'd'), Drive(turn=-1), 'right d', 'turn right'),
    Binding((' ',), Own.STOP, 'space', 'stop wheels and demos at once'),
    Binding(('+', '='), Own.FASTER, '+', 'drive faster from now on'),
    Binding(('-', '_'), Own.SLOWER, '-', 'drive slower'),
    Binding(('1',), _mode(Mode.PASSIVE), '1', 'Passive: it rests, and charges'),
    Binding(('2',), _mode(Mode.SAFE), '2', 'Safe: it drives'),
    Binding(('3',), _mode(Mode.FULL), '3', 'Full: it drives off tables, too'),
    Binding(('p',), Ask('define_song', TUNE), 'p', f'play a tune (stored as song {SONG})'),
    Binding(('g',), Ask('dock'), 'g', 'go to the Home Base'),
    Binding(('r',), Ask('reset_odometry'), 'r', 'begin the odometry again here'),
    Binding(('c',), Own.CLEAR, 'c', 'clear the track'),
    Binding(('\x0c',), Own.REDRAW, '^L', 'draw the screen again'),
    Binding(('h', '?'), Own.HELP, 'h ?', 'show or hide this'),
    Binding(('q', '\x03', '\x04'), Own.QUIT, 'q', 'stop and end'),
)
ACTIONS: dict[str, Action] = {key: each.action for each in BINDINGS for key in each.keys}


def action_of(key: str) -> Action | None:
    """Return what a key is for; Caps Lock changes nothing."""
    return ACTIONS.get(key.lower() if len(key) == 1 else key)


class Keyboard:
    """Cuts what a terminal sends into keys, however it arrives."""

    def __init__(self) -> None:
        self._begun = ''
        """An escape sequence whose end has not come."""

    def keys(self, received: bytes) -> Iterator[str]:
        """Yield the keys of some bytes: a character or the name of an arrow, '' for others."""
        for character in received.decode('latin-1'):
            if not self._begun and character != ESCAPE:
                yield character
            elif character == ESCAPE:
                # A sequence that breaks off, or Escape by itself: nothing to us.
                self._begun = ESCAPE
            else:
                yield from self._go_on(character)

    def _go_on(self, character: str) -> Iterator[str]:
        self._begun += character
        if len(self._begun) == 2:
            if character not in '[O':
                # Alt and a key, or Escape and then a key: the key.
                self._begun = ''
                yield character
        elif ord(character) in FINAL:
            # Shift and Ctrl come as figures between: an arrow is one all the same.
            self._begun = ''
            yield ARROWS.get(character, '')
