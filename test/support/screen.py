# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs a program on a pseudo terminal, and reads its screen as a person would."""

import codecs
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from typing import Any

from create_oi_ros.ros.programs import PROGRAMS

TIMEOUT = 30.0
"""Seconds after which a test that waits fails."""
SHELL = ('bash', '--norc', '--noprofile', '--noediting', '-i')
"""A shell with job control, which writes no escape sequences."""
SEQUENCE = re.compile(r'\x1b\[([?\d;]*)([A-Za-z])')


class Screen:
    """The part of a terminal that our programs use: a cursor, and clearing."""

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        self.alternate = False
        """Whether the alternate screen is shown."""
        self.outside = 0
        """Characters written outside the screen."""
        self._rest = ''
        self._row = self._column = 0
        self._clear()

    def _clear(self) -> None:
        self._cells = [[' '] * self.columns for _ in range(self.rows)]

    def feed(self, text: str) -> None:
        """Process output; an escape sequence may be cut anywhere."""
        text, self._rest = self._rest + text, ''
        at = 0
        while at < len(text):
            if text[at] != '\x1b':
                self._put(text[at])
                at += 1
            elif found := SEQUENCE.match(text, at):
                self._obey(*found.groups())
                at = found.end()
            else:
                self._rest = text[at:]
                assert len(self._rest) < 20, f'unknown sequence: {self._rest!r}'
                return

    def _obey(self, arguments: str, command: str) -> None:
        match arguments, command:
            case '2', 'J':
                self._clear()
            case '', 'K':
                self._cells[self._row][self._column:] = [' '] * (self.columns - self._column)
            case _, 'H':
                row, column = map(int, (arguments or '1;1').split(';'))
                self._row, self._column = row - 1, column - 1
            case column, 'G':
                self._column = int(column) - 1
            case _, 'm':
                assert re.fullmatch(r'(\d+(;\d+)*)?', arguments)
            case '?1049', _:
                self.alternate = command == 'h'
            case _:
                assert (arguments, command) in {
                    ('?25', 'l'), ('?25', 'h'), ('?7', 'l'), ('?7', 'h')}

    def _put(self, character: str) -> None:
        if not self.alternate or character in '\r\n':
            return
        if self._row < self.rows and self._column < self.columns:
            self._cells[self._row][self._column] = character
        else:
            self.outside += 1
        self._column += 1

    @property
    def text(self) -> str:
        """Everything on the screen."""
        return '\n'.join(''.join(row) for row in self._cells)

    def after(self, label: str) -> str:
        """Return the text of the panel after a label."""
        found = re.search(rf'[│|]{label:8}(.*)', self.text)
        return found[1].strip() if found else ''


class TerminalProgram:
    """A program on a terminal of its own, with its keyboard and its screen."""

    def __init__(
        self, program: str, *arguments: str, domain: int, size: tuple[int, int] = (80, 24),
        **environment: str,
    ) -> None:
        self.master, self.slave = pty.openpty()
        self._open = [self.master, self.slave]
        self.screen = Screen(*size)
        self._decoder = codecs.getincrementaldecoder('utf-8')()  # reads may cut characters
        self.output = ''
        """Everything that it has written."""
        self.resize(*size)
        self.settings = termios.tcgetattr(self.slave)
        command = [*SHELL] if program == 'bash' else [
            sys.executable, '-c', PROGRAMS[program], *arguments]
        self.process = subprocess.Popen(
            command, stdin=self.slave, stdout=self.slave, stderr=self.slave,
            start_new_session=True, preexec_fn=self._take_terminal, env={
                **os.environ, 'ROS_DOMAIN_ID': str(domain), 'TERM': 'xterm',
                'PYTHONIOENCODING': 'utf-8', **environment})

    @staticmethod
    def _take_terminal() -> None:
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)

    def resize(self, columns: int, rows: int) -> None:
        """Resize the window."""
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack('HHHH', rows, columns, 0, 0))
        self.screen = Screen(columns, rows)
        self.screen.alternate = bool(self.output)

    def type(self, keys: str) -> None:
        """Press keys."""
        os.write(self.master, keys.encode())

    def look(self, seconds: float = 0.0) -> None:
        """Read its output."""
        while select.select([self.master], [], [], seconds)[0]:
            seconds = 0.0
            text = self._decoder.decode(os.read(self.master, 65536))
            self.output += text
            self.screen.feed(text)

    def until(self, happened: Callable[[], Any], what: str = '') -> None:
        """Read its output until a condition holds; fail after TIMEOUT."""
        deadline = time.monotonic() + TIMEOUT
        while not happened():
            assert time.monotonic() < deadline, f'{what} did not happen:\n{self.screen.text}'
            assert self.process.poll() is None, f'it has ended:\n{self.output[-3000:]}'
            self.look(0.05)

    def sees(self, text: str) -> None:
        """Wait until a text is on the screen."""
        self.until(lambda: text in self.screen.text, f'{text!r}')

    def send(self, number: signal.Signals) -> None:
        """Send it a signal."""
        self.process.send_signal(number)

    def ended(self) -> int:
        """Wait for its end; return its exit code."""
        deadline = time.monotonic() + TIMEOUT
        while self.process.poll() is None:
            assert time.monotonic() < deadline, f'it does not end:\n{self.screen.text}'
            self.look(0.05)
        self.look()
        return self.process.returncode

    @property
    def restored(self) -> bool:
        """Return whether the terminal has its first settings and the normal screen again."""
        return termios.tcgetattr(self.slave) == self.settings and not self.screen.alternate

    def hang_up(self) -> None:
        """Close the window."""
        for descriptor in self._open:
            os.close(descriptor)
        self._open = []

    def close(self) -> None:
        """Kill it if it runs, and close the terminal."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.hang_up()


@contextmanager
def terminals(program: str, domain: int) -> Iterator[Callable[..., TerminalProgram]]:
    """Yield a function that starts a program on a terminal; kill all of them at the end."""
    started: list[TerminalProgram] = []

    def start(*arguments: str, **more: Any) -> TerminalProgram:
        started.append(TerminalProgram(program, *arguments, domain=domain, **more))
        return started[-1]
    try:
        yield start
    finally:
        for each in started:
            each.close()
