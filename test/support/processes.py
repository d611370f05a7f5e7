# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Processes that must not outlive a test."""

from contextlib import suppress
import os
from pathlib import Path
import signal
import time

MARK = 'CREATE_OI_TEST_PROGRAM'
"""Environment variable by which the processes of a test's program are found."""


def marked(mark: str) -> dict[int, str]:
    """Return the processes that have inherited this value of MARK, with their commands."""
    found = {}
    for process in Path('/proc').glob('[0-9]*'):
        with suppress(OSError):  # it has ended, or belongs to somebody else
            if f'{MARK}={mark}\0' in (process / 'environ').read_text(errors='replace'):
                found[int(process.name)] = (process / 'cmdline').read_text().replace('\0', ' ')
    return found


def kill_marked(mark: str) -> list[str]:
    """Kill these processes; return their commands."""
    found = marked(mark)
    for process in found:
        with suppress(ProcessLookupError):  # it has ended meanwhile
            os.kill(process, signal.SIGKILL)
    return [*found.values()]


def dead_men() -> list[int]:
    """Return the processes that watch over the lines of this one."""
    children = ' '.join(each.read_text() for each in Path('/proc/self/task').glob('*/children'))
    return [int(child) for child in children.split()
            if 'dead_man_process' in Path(f'/proc/{child}/cmdline').read_text()]


def dead_man() -> int:
    """Return the one process that watches; the kernel may list none for a moment."""
    until = time.monotonic() + 30.0
    while len(found := dead_men()) != 1 and time.monotonic() < until:
        time.sleep(0.01)
    only, = found
    return only
