"""
A terminal that shows whole screens and hears single keys, and is left as it was found.

It writes to a descriptor of its own that never waits: a terminal that has stalled (a slow line,
ssh that hangs) loses pictures, but neither the keys nor the end wait for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import locale
import os
import select
import sys
import tempfile
import termios
from typing import Any, IO

ENTER = '\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[2J'
"""Another screen, no cursor, no wrapping at the right edge, empty."""
LEAVE = '\x1b[0m\x1b[?7h\x1b[?25h\x1b[?1049l'
LOUD, QUIET = '\x1b[7m', '\x1b[0m'
USUAL_SIZE = (80, 24)
LAST_WORDS = 0.5
"""Seconds that a stalled terminal is given to take what restores it."""
MOST_ERRORS = 8192
"""Bytes at the end of what was complained of meanwhile that are shown afterwards."""
DISABLED = b'\0'
Rows = list[list[tuple[str, bool]]]


class TerminalError(Exception):
    """This is no terminal to be seen on; the message says why."""


class HungUp(Exception):
    """The terminal has gone."""


def _encoded(row: list[tuple[str, bool]]) -> str:
    return ''.join(f'{LOUD}{text}{QUIET}' if loud else text for text, loud in row)


def _keys_alone(settings: list[Any]) -> list[Any]:
    """Return settings in which keys come one by one, unseen, and Ctrl-C alone is a signal."""
    changed = [*settings[:6], list(settings[6])]
    changed[0] &= ~(termios.IXON | termios.ICRNL)
    changed[3] &= ~(termios.ICANON | termios.ECHO | termios.IEXTEN)
    # Suspended or quit by a key, it would leave the terminal in pieces, and the robot to itself.
    for key in (termios.VSUSP, termios.VQUIT):
        changed[6][key] = DISABLED
    return changed


class Terminal:
    """The terminal of this process, from `open` to its end."""

    def __init__(self, keys: int, screen: int) -> None:
        """Work on two open descriptors; use `opened`."""
        self.descriptor = keys
        """Becomes readable when a key was pressed."""
        self._screen = screen
        self._shown: list[str] = []
        self._size = (0, 0)
        self._unsent = b''

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows, as of now; HungUp: it has none any more."""
        try:
            columns, rows = os.get_terminal_size(self._screen)
        except OSError as error:
            raise HungUp from error
        # A serial console may not know its size.
        return (columns, rows) if columns and rows else USUAL_SIZE

    def read(self) -> bytes:
        """Return what was typed; HungUp: nobody will type again."""
        try:
            typed = os.read(self.descriptor, 1024)
        except OSError as error:
            raise HungUp from error
        if not typed:
            raise HungUp
        return typed

    def redraw(self) -> None:
        """Take nothing on the screen for granted."""
        self._size = (0, 0)

    def show(self, rows: Rows) -> None:
        """Write what has changed since the last picture, unless that is still on its way."""
        self._send()
        if self._unsent:
            return
        lines = [_encoded(row) for row in rows]
        out = ''
        if self._size != (size := self.size) or len(lines) != len(self._shown):
            self._shown, self._size, out = [], size, '\x1b[2J'
        before = self._shown or [''] * len(lines)
        out += ''.join(f'\x1b[{number};1H{line}' for number, (line, old) in enumerate(
            zip(lines, before, strict=True), 1) if line != old)
        self._shown = lines
        self.write(out)

    def write(self, text: str) -> None:
        """Send a text, after what is still on its way."""
        self._unsent += text.encode(errors='replace')
        self._send()

    def _send(self) -> None:
        if not self._unsent:
            return
        try:
            self._unsent = self._unsent[os.write(self._screen, self._unsent):]
        except BlockingIOError:
            return
        except OSError as error:
            raise HungUp from error

    def leave(self) -> None:
        """Give the screen back; a terminal that takes nothing any more is let be."""
        with suppress(HungUp):
            # What is left of a picture may have broken off within a sequence: all of it first.
            self.write(LEAVE)
            while self._unsent and select.select([], [self._screen], [], LAST_WORDS)[1]:
                self._send()


def check() -> None:
    """TerminalError: there is nobody to see or to type."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise TerminalError('it needs a terminal to show and to hear keys: run it in one, not in '
                            'a pipe (over ssh: ssh -t)')
    if os.environ.get('TERM', 'dumb') == 'dumb':
        raise TerminalError('TERM says that this terminal cannot move its cursor; xterm and its '
                            'like, screen, tmux and the Linux console can')


def simple() -> bool:
    """Tell whether to keep to ASCII: another encoding, or a console with few characters."""
    encoding = locale.getencoding().lower().replace('-', '')
    return encoding != 'utf8' or os.environ.get('TERM') == 'linux'


def _screen_of(descriptor: int) -> int:
    """Open the terminal once more, so that not to wait concerns nobody else."""
    try:
        return os.open(os.ttyname(descriptor), os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError:
        # After su, or in a container, the terminal may have no name that we may open.
        return os.dup(descriptor)


@contextmanager
def _errors_kept() -> Iterator[None]:
    """Keep complaints of libraries off the screen, and show the last of them afterwards."""
    if not sys.stderr.isatty():
        yield
        return
    with tempfile.TemporaryFile() as kept:
        was = os.dup(2)
        os.dup2(kept.fileno(), 2)
        try:
            yield
        finally:
            sys.stderr.flush()
            os.dup2(was, 2)
            os.close(was)
            _show_end(kept)


def _show_end(kept: IO[bytes]) -> None:
    kept.seek(max(0, kept.seek(0, os.SEEK_END) - MOST_ERRORS))
    with suppress(OSError):  # the terminal may have gone
        os.write(2, kept.read())


@contextmanager
def opened() -> Iterator[Terminal]:
    """Yield the terminal, and restore it however this ends."""
    check()
    keys, screen = sys.stdin.fileno(), _screen_of(sys.stdout.fileno())
    settings = termios.tcgetattr(keys)
    terminal = Terminal(keys, screen)
    try:
        with _errors_kept():
            try:
                termios.tcsetattr(keys, termios.TCSANOW, _keys_alone(settings))
                terminal.write(ENTER)
                yield terminal
            finally:
                terminal.leave()
                with suppress(termios.error):  # it may have gone
                    termios.tcsetattr(keys, termios.TCSANOW, settings)
    finally:
        os.close(screen)
