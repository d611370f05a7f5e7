# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The program of the dead-man: `dead_man_process.py PIPE LINE STOP DRIVER`.

`dead_man` says what it is for. This file imports next to nothing: the process starts in a few
milliseconds, before anything moves, and takes a third less memory than with `signal`, which it
does without. It writes byte by byte instead, so that no write can block.
"""

import os
import select
import sys

GOODBYE = b'\0'
WRITE_TIMEOUT = 2.0
"""Seconds after which the process gives up on a line that takes no byte."""
CHECK_INTERVAL, CONFIRM_INTERVAL = 0.1, 0.02
"""Seconds between two checks whether the driver is suspended, and before the one that confirms it:
together 0.12, where 0.2 are promised until the wheels are told to stop."""
CHECKS_TO_REPEAT = 10
"""Checks between two times that the stop is written while the driver stays suspended."""
SUSPENDED = (b'T', b't')
"""Process states: stopped by a signal, and by a debugger (proc(5))."""


def is_suspended(process: int) -> bool:
    """Tell whether a process is suspended; one that is gone or hidden is not."""
    try:
        with open(f'/proc/{process}/stat', 'rb') as status:
            # The process name, in brackets, may hold anything.
            return status.read().rpartition(b') ')[2][:1] in SUSPENDED
    except OSError:
        return False


def watch(pipe: int, line: int, stop_bytes: bytes, driver: int) -> None:
    """Wait for the driver's goodbye or its death; write the stop after its death."""
    found, wait = 0, CHECK_INTERVAL
    while not select.select([pipe], [], [], wait)[0]:
        found = found + 1 if is_suspended(driver) else 0
        wait = CONFIRM_INTERVAL if found == 1 else CHECK_INTERVAL
        if found % CHECKS_TO_REPEAT == 2:
            write_all(line, stop_bytes)
    if os.read(pipe, 1) != GOODBYE:
        write_all(line, stop_bytes)


def write_all(line: int, stop_bytes: bytes) -> None:
    """Write to a line; end the process if the line takes no bytes, do nothing if it is gone."""
    written = 0
    while written < len(stop_bytes):
        # A suspended driver shares the open line, so its blocking mode must stay as it is. A line
        # that is ready takes one byte at least; more might block.
        if not select.select([], [line], [], WRITE_TIMEOUT)[1]:
            sys.exit(1)
        try:
            written += os.write(line, stop_bytes[written:written + 1])
        except BlockingIOError:
            continue
        except OSError:
            break


if __name__ == '__main__':
    watch(int(sys.argv[1]), int(sys.argv[2]), bytes.fromhex(sys.argv[3]), int(sys.argv[4]))
