# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A served robot that tests share, and a port for those that serve one of their own."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from support.simulator import ControlClient, taught

AS_NEW = ('fault off', 'cable mend', 'cable unplug', 'cable plug', 'unforce', 'down', 'drop',
          'hold', 'charger off', 'place 0 0 0', 'power off', 'power on')


@pytest.fixture
def port(tmp_path: Path) -> Path:
    """Return the path of the simulator's link."""
    return tmp_path / 'create'


@pytest.fixture(scope='module')
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, ControlClient]]:
    """Serve a robot in the room, for all tests of a module."""
    with taught(tmp_path_factory.mktemp('served'), '--world', 'room', '--guess', 'boot_seconds=0',
                '--guess', 'banner=0') as (port, teacher):
        yield port, teacher


@pytest.fixture
def robot(served: tuple[Path, ControlClient]) -> tuple[Path, ControlClient]:
    """Return the port and the control socket of the shared robot, as new."""
    port, teacher = served
    teacher.tell(*AS_NEW)
    with serial.Serial(str(port), 57600) as client:
        teacher.tell('after 0.05')  # until the line knows this rate
        client.reset_input_buffer()
    return served
