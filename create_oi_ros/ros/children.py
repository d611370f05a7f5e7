# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Other programs of this package, as processes that a program starts and ends."""

from functools import partial
import os
import subprocess
import sys

from .process import end_with_parent
from .programs import PROGRAMS

GRACE = 1.5
"""Seconds that a child has to end by itself after SIGTERM, before it is killed."""


def start(program: str, *arguments: str, stdout: int | None = None) -> subprocess.Popen[bytes]:
    """Start a program that ends with this process; the terminal's Ctrl-C does not reach it."""
    return subprocess.Popen(
        [sys.executable, '-c', PROGRAMS[program], *arguments], stdout=stdout,
        start_new_session=True, preexec_fn=partial(end_with_parent, os.getpid()))


class Children:
    """Child processes, ended in the reverse order of their start."""

    def __init__(self) -> None:
        self._processes: list[tuple[str, subprocess.Popen[bytes]]] = []

    def start(self, program: str, *arguments: str) -> None:
        """Start a program."""
        self._processes.insert(0, (program, start(program, *arguments)))

    def ended(self) -> str | None:
        """Return a sentence about a child that has ended by itself; None while all run."""
        for program, process in self._processes:
            if process.poll() is not None:
                return f'{program} has ended with exit code {process.returncode}'
        return None

    def end(self) -> None:
        """End all children, the newest first: start the node last, it has to stop the robot."""
        for _, process in self._processes:
            if process.poll() is None:
                process.terminate()  # SIGINT while Python starts would print a traceback
            try:
                process.wait(GRACE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
