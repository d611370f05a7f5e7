# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs one step of set-up or build: shows how far it is, and prints its log only if it fails."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
import os
from pathlib import Path
import subprocess
import sys
import time

LAST_LINES = 30
WIDTH = 78
POLL = 0.5
"""Seconds between two looks at the log."""


def step(command: Sequence[str | Path], log: str, failure: str,
         env: Mapping[str, str] | None = None, *, show: bool = True,
         progress: Callable[[str], str] | None = None) -> None:
    """
    Run a command with its output in a file in log/; if it fails, exit with a message.

    `progress` makes a line of the log so far; a terminal shows it with the time that has passed.
    `show=False` leaves out the end of the log, where the message says everything.
    """
    path = Path('log') / log
    path.parent.mkdir(exist_ok=True)
    began = time.monotonic()
    with path.open('ab') as out:
        start = out.tell()
        with subprocess.Popen(command, stdout=out, stderr=out, env=env) as process:
            while (code := _wait(process)) is None:
                if progress is not None and moves_in_place():
                    _write(f'  {progress(_text(path, start))}, {clock(began)}')
    if progress is not None and moves_in_place():
        _write('')
    if code and show:
        print(*_text(path, start).splitlines()[-LAST_LINES:], sep='\n', file=sys.stderr)
    if code:
        sys.exit(f'make: {failure} (complete log: {path})')


@contextmanager
def interruptible() -> Iterator[None]:
    """Exit with a message instead of a traceback at Ctrl-C."""
    try:
        yield
    except KeyboardInterrupt:
        sys.exit('\nmake: interrupted; make again begins with what is not complete')


def _wait(process: subprocess.Popen[bytes]) -> int | None:
    try:
        return process.wait(POLL)
    except subprocess.TimeoutExpired:
        return None


def _text(path: Path, start: int) -> str:
    return path.read_bytes()[start:].decode(errors='replace')


def clock(began: float) -> str:
    """Return the time since then as minutes and seconds."""
    minutes, seconds = divmod(int(time.monotonic() - began), 60)
    return f'{minutes}:{seconds:02}'


def moves_in_place() -> bool:
    """Return whether stdout is a terminal whose line can be written over."""
    return sys.stdout.isatty() and os.environ.get('TERM', 'dumb') != 'dumb'


def _write(text: str) -> None:
    """Write over the line; '' clears it."""
    sys.stdout.write(f'\r{text[:WIDTH]:{WIDTH}}\r' if not text else f'\r{text[:WIDTH]:{WIDTH}}')
    sys.stdout.flush()
