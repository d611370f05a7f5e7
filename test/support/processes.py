# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Processes that must not outlive a test."""

from contextlib import suppress
import os
from pathlib import Path
import signal

MARK = 'CREATE_OI_TEST_PROGRAM'
"""Environment variable by which the processes of a test's program are found."""


def kill_marked(mark: str) -> list[str]:
    """Kill all processes that have inherited a variable NAME=VALUE; return their commands."""
    killed = []
    for process in Path('/proc').glob('[0-9]*'):
        with suppress(OSError):  # it has ended, or belongs to somebody else
            if f'{mark}\0' in (process / 'environ').read_text(errors='replace'):
                killed.append((process / 'cmdline').read_text().replace('\0', ' '))
                os.kill(int(process.name), signal.SIGKILL)
    return killed
