# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The terminal: shows whole screens, reads single keys, and restores its settings at the end.

It writes through a non-blocking descriptor of its own: a stalled terminal (a slow line, a hanging
ssh) loses pictures, but neither the keys nor the end of the program wait for it.
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

from ...characters.ink import encoded, has_colors, InkedText

ENTER = '\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[2J'
"""Alternate screen, no cursor, no line wrap, cleared."""
LEAVE = '\x1b[0m\x1b[?7h\x1b[?25h\x1b[?1049l'
USUAL_SIZE = (80, 24)
RESTORE_TIMEOUT = 0.5
"""Seconds that a stalled terminal has to accept what restores it."""
MOST_ERRORS = 8192
"""Bytes of stderr, the last ones, that are shown when the terminal is restored."""
DISABLED = b'\0'
Rows = list[list[InkedText]]


class TerminalError(Exception):
    """This terminal cannot be used; the message says why."""


class TerminalClosed(Exception):
    """The terminal was closed."""


def _keys_alone(settings: list[Any]) -> list[Any]:
    """Return settings: no line buffer, no echo; of the keys only Ctrl-C sends a signal."""
    changed = [*settings[:6], list(settings[6])]
    changed[0] &= ~(termios.IXON | termios.ICRNL)
    changed[3] &= ~(termios.ICANON | termios.ECHO | termios.IEXTEN)
    # Ctrl-Z is a key, for the terminal is restored first; Ctrl-\ would leave it unusable.
    for key in (termios.VSUSP, termios.VQUIT):
        changed[6][key] = DISABLED
    return changed


class Terminal:
    """The terminal of this process; made by `opened`, which restores it."""

    def __init__(self, keys: int, screen: int) -> None:
        """Use two open descriptors: one to read keys, one to write."""
        self._colors = has_colors(os.environ)
        self.descriptor = keys
        """Readable when a key was pressed."""
        self._screen = screen
        self._shown: list[str] = []
        self._size = (0, 0)
        self._unsent = b''
        self._settings = termios.tcgetattr(keys)

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows now; TerminalClosed: the terminal is gone."""
        try:
            columns, rows = os.get_terminal_size(self._screen)
        except OSError as error:
            raise TerminalClosed from error
        # A serial console may not know its size.
        return (columns, rows) if columns and rows else USUAL_SIZE

    def read(self) -> bytes:
        """Return the bytes typed; TerminalClosed: the terminal is gone."""
        try:
            typed = os.read(self.descriptor, 1024)
        except OSError as error:
            raise TerminalClosed from error
        if not typed:
            raise TerminalClosed
        return typed

    def drop_typed(self) -> None:
        """Forget keys that were typed and not read, so that no other program reads them."""
        with suppress(termios.error):  # it may be closed
            termios.tcflush(self.descriptor, termios.TCIFLUSH)

    def redraw(self) -> None:
        """Draw the whole screen again with the next picture."""
        self._size = (0, 0)

    def show(self, rows: Rows) -> None:
        """Write the rows that changed; skip this picture while the last one is not sent yet."""
        self._send()
        if self._unsent:
            return
        lines = [encoded(row, colors=self._colors) for row in rows]
        out = ''
        if self._size != (size := self.size) or len(lines) != len(self._shown):
            self._shown, self._size, out = [], size, '\x1b[2J'
        before = self._shown or [''] * len(lines)
        out += ''.join(f'\x1b[{number};1H{line}' for number, (line, old) in enumerate(
            zip(lines, before, strict=True), 1) if line != old)
        self._shown = lines
        self.write(out)

    def write(self, text: str) -> None:
        """Send a text, after what is not sent yet."""
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
            raise TerminalClosed from error

    def enter(self) -> None:
        """Take over keys and screen; TerminalClosed: the terminal is gone."""
        try:
            termios.tcsetattr(self.descriptor, termios.TCSANOW, _keys_alone(self._settings))
        except termios.error as error:
            raise TerminalClosed from error
        self.redraw()
        self.write(ENTER)

    def leave(self) -> None:
        """Restore screen and keys; give up after RESTORE_TIMEOUT if the terminal has stalled."""
        with suppress(TerminalClosed):
            # Send the rest of the picture first: it may have been cut within an escape sequence.
            self.write(LEAVE)
            while self._unsent and select.select([], [self._screen], [], RESTORE_TIMEOUT)[1]:
                self._send()
        with suppress(termios.error):  # it may be closed
            termios.tcsetattr(self.descriptor, termios.TCSANOW, self._settings)


def check() -> None:
    """Check that stdin and stdout are a terminal with a cursor; TerminalError says why not."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise TerminalError('it needs a terminal for input and output: do not use a pipe or a '
                            'redirection; over ssh use ssh -t')
    if os.environ.get('TERM', 'dumb') == 'dumb':
        raise TerminalError('this terminal cannot move its cursor (TERM is dumb or not set): use '
                            'an xterm or similar, screen, tmux or the Linux console')


def simple() -> bool:
    """Return whether to draw in ASCII: no UTF-8 locale, or the Linux console."""
    encoding = locale.getencoding().lower().replace('-', '')
    return encoding != 'utf8' or os.environ.get('TERM') == 'linux'


def _screen_of(descriptor: int) -> int:
    """Open the terminal again: non-blocking mode must not affect other programs on it."""
    try:
        return os.open(os.ttyname(descriptor), os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError:
        # After su, or in a container, we may lack the permission, or the terminal a name.
        return os.dup(descriptor)


@contextmanager
def _errors_kept() -> Iterator[None]:
    """Keep stderr off the screen, and show the end of it afterwards."""
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
    with suppress(OSError):  # the terminal may be closed
        os.write(2, kept.read())


@contextmanager
def opened() -> Iterator[Terminal]:
    """Yield the terminal, and restore it at the end, whatever happens."""
    check()
    keys, screen = sys.stdin.fileno(), _screen_of(sys.stdout.fileno())
    terminal = Terminal(keys, screen)
    try:
        with _errors_kept():
            try:
                terminal.enter()
                yield terminal
            finally:
                terminal.leave()
    finally:
        os.close(screen)
