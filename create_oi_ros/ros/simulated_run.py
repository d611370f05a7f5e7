# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What each simulated run has to itself on this computer: a ROS domain, and a folder."""

from collections.abc import Iterator
from contextlib import contextmanager
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
    with _reserved() as domain:
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        yield str(domain)


@contextmanager
def _reserved() -> Iterator[int]:
    for domain in DOMAINS:
        # The kernel frees an abstract name when the process ends, however it ends.
        with socket.socket(socket.AF_UNIX) as reservation:
            try:
                reservation.bind(f'\0create_oi_ros/domain/{domain}')
            except OSError:
                continue  # another run has it
            yield domain
            return
    raise UserError(
        f'the ROS domains {DOMAINS[0]} to {DOMAINS[-1]}, which simulated runs take, are all in '
        'use: end a run, or choose a domain yourself with ROS_DOMAIN_ID')


@contextmanager
def run_folder() -> Iterator[Path]:
    """Yield a new temporary folder, and remove it at the end; remove those of dead processes."""
    _remove_abandoned()
    with tempfile.TemporaryDirectory(prefix=f'create-{os.getpid()}-') as folder:
        yield Path(folder)


def _remove_abandoned() -> None:
    """Remove our folders whose process was killed before it could."""
    for folder in Path(tempfile.gettempdir()).glob('create-*'):
        found = FOLDER.fullmatch(folder.name)
        if found and not Path('/proc', found[1]).exists() and _ours(folder):
            shutil.rmtree(folder, ignore_errors=True)


def _ours(folder: Path) -> bool:
    try:
        return folder.lstat().st_uid == os.getuid()
    except FileNotFoundError:  # another run has just removed it
        return False
