# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Shared memory of a program that was killed as it started hangs no other program."""

import os
from pathlib import Path
import subprocess
import sys
import time

import pytest

from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.ros.shared_memory import FOLDER, OLD, remove_unfinished
from support.ros import own_domain, TIMEOUT

SIZE = 52400
FIRST_PORT, PORTS_OF_A_DOMAIN, DATA = 7400, 250, 11
"""How RTPS numbers the port of the first program in a domain for user data."""


def mark(file: Path, number: int, age: float = 2 * OLD, size: int = SIZE) -> Path:
    """Write a port that is marked with a number and was made so many seconds ago."""
    file.write_bytes((number.to_bytes(4, sys.byteorder) + bytes(size))[:size])
    made = time.time() - age
    os.utime(file, (made, made))
    return file


@pytest.mark.parametrize('number', [0, 1])
def test_an_unfinished_port_is_removed_and_the_user_told(tmp_path, number):
    port = mark(tmp_path / 'fastrtps_port7411', number)

    assert remove_unfinished(tmp_path) == [
        f'{port} was left by a program that was killed as it started, and can hang ROS: removed']
    assert not port.exists()
    assert remove_unfinished(tmp_path) == []


def test_everything_else_stays(tmp_path):
    kept = [
        mark(tmp_path / 'fastrtps_port7411', 2),
        mark(tmp_path / 'fastrtps_port7413', 0x01000000 if sys.byteorder == 'little' else 0x100),
        mark(tmp_path / 'fastrtps_port7415', 0, age=0.0),  # its program may still make it
        mark(tmp_path / 'fastrtps_port7417_el', 0),
        mark(tmp_path / 'fastrtps_port7419', 0, size=3),
        mark(tmp_path / 'fastrtps_0009625cbbd368b8', 0),
        mark(tmp_path / 'sem.fastrtps_port7411_mutex', 0)]

    assert remove_unfinished(tmp_path) == []
    assert sorted(tmp_path.iterdir()) == sorted(kept)


def test_a_port_that_cannot_be_removed_is_told_with_what_to_do(tmp_path, monkeypatch):
    port = mark(tmp_path / 'fastrtps_port7411', 0)

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(1, 'Operation not permitted')
    monkeypatch.setattr(Path, 'unlink', refuse)

    sentence, = remove_unfinished(tmp_path)
    assert sentence.endswith(
        f'it cannot be removed (Operation not permitted); `sudo rm {port}`')


def test_a_system_without_that_folder_is_no_error(tmp_path):
    assert remove_unfinished(tmp_path / 'shm') == []


def test_a_program_starts_where_another_was_killed_as_it_started(monkeypatch):
    monkeypatch.delenv('FASTDDS_BUILTIN_TRANSPORTS')  # shared memory, as users have it
    with own_domain() as domain:
        number = FIRST_PORT + domain * PORTS_OF_A_DOMAIN + DATA
        port = mark(FOLDER / f'fastrtps_port{number}', 0)
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        done = subprocess.run(
            [sys.executable, '-c', PROGRAMS['create_node'], '--ros-args', '-p', 'baud:=1'],
            text=True, capture_output=True, timeout=TIMEOUT)

    *told, wrong = done.stderr.splitlines()
    assert [line for line in told if line.startswith(f'{port} was left by')]
    assert wrong.startswith('create_node: parameter baud')
