# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What each simulated run has to itself on this computer: a ROS domain, and a folder."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
from pathlib import Path
import re
import shutil
import socket
import tempfile

from .programs import UserError

DOMAINS = range(215, 233)
"""Few people choose these; their UDP ports lie above those that Linux gives to other programs."""
FOLDER = re.compile(r'create-(\d+)-\w+')
"""Name of a run's folder, with its process id."""


@contextmanager
def run_domain() -> Iterator[str]:
    """
    Yield the ROS domain of a simulated run: ROS_DOMAIN_ID, or else one that no other run has.

    In a domain of our own we also stay on this computer: another one may use the same number.
    UserError: all are taken.
    """
    given = os.environ.get('ROS_DOMAIN_ID')
    if given:
        yield given
        return
    for domain in DOMAINS:
        # The kernel frees an abstract name when the process ends, however it ends.
        with socket.socket(socket.AF_UNIX) as reservation:
            try:
                reservation.bind(f'\0create_oi_ros/domain/{domain}')
            except OSError:
                continue  # another run has it
            os.environ['ROS_DOMAIN_ID'] = str(domain)
            os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
            yield str(domain)
            return
    raise UserError(
        f'the ROS domains {DOMAINS[0]} to {DOMAINS[-1]}, which simulated runs take, are all in '
        'use: end a run, or choose a domain yourself with ROS_DOMAIN_ID')


@contextmanager
def run_folder() -> Iterator[Path]:
    """Yield a new temporary folder, and remove it at the end; remove those of dead processes."""
    for abandoned in Path(tempfile.gettempdir()).glob('create-*'):
        found = FOLDER.fullmatch(abandoned.name)
        with suppress(FileNotFoundError):  # another run has just removed it
            if (found and not Path('/proc', found[1]).exists()
                    and abandoned.lstat().st_uid == os.getuid()):
                shutil.rmtree(abandoned, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=f'create-{os.getpid()}-') as folder:
        yield Path(folder)
