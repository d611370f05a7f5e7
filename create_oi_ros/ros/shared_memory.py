# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Shared memory that a killed program left unfinished.

Fast DDS, the middleware of ROS, keeps a file in shared memory for each port of a ROS domain. A
program that is killed in the moment in which it makes one leaves a file that is not marked as
ready. Every later program that gets the same port waits for that mark, without a word, for ever.
"""

from collections.abc import Callable
from pathlib import Path
import sys
import time

FOLDER = Path('/dev/shm')
"""Where Linux keeps shared memory."""
SHARED, FIRST, EACH = range(7000, 7400), 7400, 250
"""Ports of all domains, the first one of domain 0, and how many a domain has (DDSI-RTPS 9.6.1)."""
WORD = 4
"""Bytes at the beginning of a port, in which Boost.Interprocess marks how far it is made."""
UNFINISHED = (0, 1)
"""Marks: 0 nothing done yet, 1 in the making; 2 is ready."""
WAIT = 1.0
"""Seconds after which a port is ready, or its program dead: it takes less than a thousandth."""


def remove_unfinished(
    domain: int, folder: Path = FOLDER, wait: Callable[[], object] = lambda: time.sleep(WAIT),
) -> list[str]:
    """
    Remove the ports that nobody will finish and a program of this ROS domain may get.

    Return a sentence for the user about each.
    """
    first = FIRST + domain * EACH
    numbers = *SHARED, *range(first, first + EACH)
    ports = [folder / f'fastrtps_port{number}' for number in numbers]
    unfinished = [port for port in ports if _is_unfinished(port)]
    if unfinished:
        wait()
    return [_remove(port) for port in unfinished if _is_unfinished(port)]


def _is_unfinished(port: Path) -> bool:
    try:
        with port.open('rb') as file:
            word = file.read(WORD)
    except OSError:  # there is none, or it is not ours to read
        return False
    return int.from_bytes(word, sys.byteorder) in UNFINISHED  # also where it has no bytes yet


def _remove(port: Path) -> str:
    left = f'{port} was left by a program that was killed as it started, and can hang ROS'
    try:
        port.unlink(missing_ok=True)
    except OSError as error:
        return f'{left}: it cannot be removed ({error.strerror}); `sudo rm {port}`'
    return f'{left}: removed'
