# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs a program on a pseudo terminal, with its keyboard."""

import codecs
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import fcntl
import os
import pty
import select
import signal
import subprocess
import sys
import termios
import time
from typing import Any

from create_oi_ros.ros.programs import PROGRAMS

TIMEOUT = 30.0
"""Seconds after which a test that waits fails."""


class TerminalProgram:
    """A program on a terminal of its own."""

    def __init__(self, program: str, *arguments: str, domain: int) -> None:
        self.master, slave = pty.openpty()
        self._decoder = codecs.getincrementaldecoder('utf-8')()  # reads may cut characters
        self.output = ''
        """Everything that it has written."""
        self.process = subprocess.Popen(
            [sys.executable, '-c', PROGRAMS[program], *arguments],
            stdin=slave, stdout=slave, stderr=slave, start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0), env={
                **os.environ, 'ROS_DOMAIN_ID': str(domain), 'TERM': 'xterm',
                'PYTHONIOENCODING': 'utf-8'})
        self._open = [self.master, slave]

    def type(self, keys: str) -> None:
        """Press keys."""
        os.write(self.master, keys.encode())

    def look(self, seconds: float = 0.0) -> None:
        """Read its output."""
        while select.select([self.master], [], [], seconds)[0]:
            seconds = 0.0
            self.output += self._decoder.decode(os.read(self.master, 65536))

    def until(self, happened: Callable[[], Any], what: str = '') -> None:
        """Read its output until a condition holds; fail after TIMEOUT."""
        deadline = time.monotonic() + TIMEOUT
        while not happened():
            assert time.monotonic() < deadline, f'{what} did not happen:\n{self.output[-3000:]}'
            assert self.process.poll() is None, f'it has ended:\n{self.output[-3000:]}'
            self.look(0.05)

    def send(self, number: signal.Signals) -> None:
        """Send it a signal."""
        self.process.send_signal(number)

    def ended(self) -> int:
        """Wait for its end; return its exit code."""
        deadline = time.monotonic() + TIMEOUT
        while self.process.poll() is None:
            assert time.monotonic() < deadline, f'it does not end:\n{self.output[-3000:]}'
            self.look(0.05)
        self.look()
        return self.process.returncode

    def close(self) -> None:
        """Kill it if it runs, and close the terminal."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        for descriptor in self._open:
            os.close(descriptor)


@contextmanager
def terminals(program: str, domain: int) -> Iterator[Callable[..., TerminalProgram]]:
    """Yield a function that starts a program on a terminal; kill all of them at the end."""
    started: list[TerminalProgram] = []

    def start(*arguments: str) -> TerminalProgram:
        started.append(TerminalProgram(program, *arguments, domain=domain))
        return started[-1]
    try:
        yield start
    finally:
        for each in started:
            each.close()
