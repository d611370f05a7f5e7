# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_sim` as a process, its control socket, and the simplest clients of its port."""

from collections.abc import Iterator
from contextlib import contextmanager
import json
import os
from pathlib import Path
import select
import signal
import socket
import subprocess
import sys
import time
from typing import Any

from create_oi_ros.ros.programs import PROGRAMS

START, SAFE, FULL = bytes([128]), bytes([131]), bytes([132])
STREAM = bytes([148, 3, 35, 41, 42])
FRAME = 3 + 2 + 3 + 3
"""Bytes of commands, and of a frame of that stream."""
PATIENCE = 20.0
"""Timeout of everything that a test waits for, seconds."""


class Simulator:
    """One process; `said` is its first line of output."""

    def __init__(self, *arguments: str | Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, '-c', PROGRAMS['create_sim'], *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.said = self.process.stdout.readline()

    def ended(self) -> tuple[int, str, str]:
        """Wait for its end; return exit code, the rest of its output, and its errors."""
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        code = self.process.wait(PATIENCE)
        return code, self.process.stdout.read(), self.process.stderr.read()

    def stop(self, number: signal.Signals = signal.SIGINT) -> tuple[int, str, str]:
        """End it by a signal; return what `ended` does."""
        self.process.send_signal(number)
        return self.ended()


class ControlClient:
    """Speaks with the control socket."""

    def __init__(self, path: Path) -> None:
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.settimeout(PATIENCE)
        self._socket.connect(str(path))
        self._lines = self._socket.makefile('r')

    def ask(self, line: str) -> str:
        """Send a line; return the answer."""
        self._socket.sendall(line.encode() + b'\n')
        return self._lines.readline().strip()

    def tell(self, *lines: str) -> None:
        """Send lines that must be answered by ok."""
        for line in lines:
            answer = self.ask(line)
            assert answer.startswith('ok'), f'{line}: {answer}'

    def truth(self, line: str = 'truth') -> dict[str, Any]:
        """Send a line that is answered by the truth; return that."""
        answer = self.ask(line)
        assert answer.startswith('ok '), f'{line}: {answer}'
        return json.loads(answer[3:])

    def close(self) -> None:
        """Disconnect."""
        self._lines.close()
        self._socket.close()


@contextmanager
def simulator(*arguments: str | Path) -> Iterator[Simulator]:
    """Run `create_sim`; end it whatever happens."""
    running = Simulator(*arguments)
    try:
        yield running
    finally:
        running.process.kill()
        running.process.communicate()


@contextmanager
def taught(folder: Path, *arguments: str | Path) -> Iterator[tuple[Path, ControlClient]]:
    """Run `create_sim` on a pseudo terminal with a control socket."""
    port, control = folder / 'create', folder / 'control'
    with simulator('--link', port, '--control', control, *arguments):
        teacher = ControlClient(control)
        try:
            yield port, teacher
        finally:
            teacher.close()


@contextmanager
def opened(port: Path) -> Iterator[int]:
    """Open a port as the simplest program does."""
    descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def receive(descriptor: int, count: int) -> bytes:
    """Read exactly this many bytes."""
    data = b''
    deadline = time.monotonic() + PATIENCE
    while len(data) < count:
        ready, _, _ = select.select([descriptor], [], [], max(0, deadline - time.monotonic()))
        assert ready, f'only {len(data)} of {count} bytes came: {data!r}'
        data += os.read(descriptor, count - len(data))
    return data


def silent(descriptor: int, seconds: float) -> bool:
    """Return whether nothing arrives for some time."""
    return not select.select([descriptor], [], [], seconds)[0]
