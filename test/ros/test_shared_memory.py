# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Shared memory of a program that was killed as it started hangs no other program."""

from pathlib import Path
import subprocess
import sys

import pytest

from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.ros.shared_memory import EACH, FIRST, FOLDER, remove_unfinished
from support.ros import own_domain, TIMEOUT

SIZE = 52400
READY = 2
DATA = 11
"""Number of the port that the first program in a domain has for its data."""


def make(port: Path, mark: int, size: int = SIZE) -> Path:
    """Write a port with a mark."""
    port.write_bytes((mark.to_bytes(4, sys.byteorder) + bytes(size))[:size])
    return port


def at_once() -> None:
    """Wait for nobody."""


@pytest.mark.parametrize(('mark', 'size'), [(0, 0), (0, SIZE), (1, SIZE)])
def test_an_unfinished_port_is_removed_and_the_user_told(tmp_path, mark, size):
    port = make(tmp_path / 'fastrtps_port7411', mark, size)
    assert remove_unfinished(1, tmp_path, pytest.fail) == []  # not of that domain

    assert remove_unfinished(0, tmp_path, at_once) == [
        f'{port} was left by a program that was killed as it started, and can hang ROS: removed']
    assert not port.exists()


def test_everything_else_stays_and_nobody_waits(tmp_path):
    kept = [
        make(tmp_path / 'fastrtps_port7411', READY),
        make(tmp_path / 'fastrtps_port7413', READY << 24),
        make(tmp_path / 'fastrtps_port7650', 0),  # of another domain
        make(tmp_path / 'fastrtps_port7411_el', 0, 0),
        make(tmp_path / 'fastrtps_0009625cbbd368b8', 0),
        make(tmp_path / 'sem.fastrtps_port7411_mutex', 0)]

    assert remove_unfinished(0, tmp_path, pytest.fail) == []
    assert sorted(tmp_path.iterdir()) == sorted(kept)


@pytest.mark.parametrize(('domain', 'number'), [(0, 7400), (0, 7649), (88, 29411), (88, 7000)])
def test_ports_of_the_domain_and_those_of_all_are_looked_at(tmp_path, domain, number):
    make(tmp_path / f'fastrtps_port{number}', 0)

    assert len(remove_unfinished(domain, tmp_path, at_once)) == 1


def test_a_port_that_its_program_finishes_stays(tmp_path):
    port = make(tmp_path / 'fastrtps_port7411', 1)
    dead = make(tmp_path / 'fastrtps_port7413', 0, 0)

    sentence, = remove_unfinished(0, tmp_path, lambda: make(port, READY))

    assert str(dead) in sentence
    assert [*tmp_path.iterdir()] == [port]


def test_a_port_that_cannot_be_removed_is_told_with_what_to_do(tmp_path, monkeypatch):
    port = make(tmp_path / 'fastrtps_port7411', 0)

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(1, 'Operation not permitted')
    monkeypatch.setattr(Path, 'unlink', refuse)

    sentence, = remove_unfinished(0, tmp_path, at_once)
    assert sentence.endswith(
        f'it cannot be removed (Operation not permitted); `sudo rm {port}`')


def test_a_system_without_that_folder_is_no_error(tmp_path):
    assert remove_unfinished(0, tmp_path / 'shm', pytest.fail) == []


@pytest.mark.parametrize('size', [0, SIZE])
def test_a_program_starts_where_another_was_killed_as_it_started(monkeypatch, size):
    monkeypatch.delenv('FASTDDS_BUILTIN_TRANSPORTS')  # shared memory, as users have it
    with own_domain() as domain:
        number = FIRST + domain * EACH + DATA
        port = make(FOLDER / f'fastrtps_port{number}', 0, size)
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        done = subprocess.run(
            [sys.executable, '-c', PROGRAMS['create_node'], '--ros-args', '-p', 'baud:=1'],
            text=True, capture_output=True, timeout=TIMEOUT)

    *told, wrong = done.stderr.splitlines()
    assert [line for line in told if line.startswith(f'{port} was left by')]
    assert wrong.startswith('create_node: parameter baud')
