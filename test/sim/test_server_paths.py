# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Paths, addresses and files that `create_sim` cannot use: each gets one sentence."""

import os
from pathlib import Path
import socket

import pytest

from support.simulator import simulator, taught


@pytest.fixture
def port(tmp_path: Path) -> Path:
    """Return the path of the simulator's link."""
    return tmp_path / 'create'


def refused(*arguments: str | Path) -> str:
    """Run `create_sim`, which must end with exit code 2 and one sentence; return that."""
    with simulator(*arguments) as sim:
        code, said, errors = sim.ended()
    assert (code, sim.said, said) == (2, '', '')
    assert errors.startswith('create_sim: ') and errors.count('\n') == 1
    return errors.removeprefix('create_sim: ').removesuffix('\n')


def test_a_file_in_the_place_of_the_link_is_left_alone(port: Path) -> None:
    port.write_text('precious')
    assert refused('--link', port) == f'{port}: is no symbolic link, so it is kept'
    assert port.read_text() == 'precious'


def test_a_link_to_something_else_is_left_alone(port: Path) -> None:
    port.symlink_to('ttyUSB0')
    assert refused('--link', port) == (
        f'{port}: leads to ttyUSB0, which is no pseudo terminal, so it is kept')
    assert os.readlink(port) == 'ttyUSB0'


def test_a_file_in_the_place_of_the_control_socket_is_left_alone(tmp_path: Path) -> None:
    control = tmp_path / 'control'
    control.write_text('precious')
    assert refused('--control', control) == f'{control}: is no socket, so it is kept'
    assert control.read_text() == 'precious'


@pytest.mark.parametrize('option', ['--link', '--control'])
def test_the_path_of_a_live_simulator_is_refused_with_its_process(
        tmp_path: Path, option: str) -> None:
    """The second path is the same by another name."""
    path, same = tmp_path / 'path', tmp_path / '..' / tmp_path.name / 'path'
    with taught(tmp_path) as (_, teacher), simulator(option, path) as first:
        before = os.lstat(path).st_ino
        for _ in range(2):
            assert refused(option, same) == (
                f'{same}: belongs to a running create_sim (process {first.process.pid}); '
                'end that one, or use another path')
        assert os.lstat(path).st_ino == before
        assert first.process.poll() is None
        teacher.tell('truth')


def test_the_link_of_a_simulator_whose_cable_is_out_is_refused(tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher):
        teacher.tell('cable unplug')
        assert 'belongs to a running create_sim' in refused('--link', port)
        teacher.tell('cable plug')
        assert os.path.islink(port)


def test_a_socket_left_by_a_killed_simulator_is_taken_over(tmp_path: Path) -> None:
    control = tmp_path / 'control'
    with simulator('--control', control) as sim:
        sim.process.kill()
        sim.process.wait()
    assert control.is_socket()
    with taught(tmp_path) as (_, teacher):
        teacher.tell('truth')


@pytest.mark.parametrize('option', ['--link', '--control', '--record', '--replay'])
def test_a_path_that_cannot_be_used_is_named(option: str) -> None:
    assert refused(option, '/nodir/y') == '/nodir/y: No such file or directory'


def test_a_socket_whose_path_is_too_long_is_named(tmp_path: Path) -> None:
    path = tmp_path / ('x' * 108)
    assert refused('--control', path) == f'{path}: AF_UNIX path too long'


def test_a_full_disk_ends_a_recording_with_the_name_of_the_file() -> None:
    with simulator('--record', '/dev/full', '--speed', '100') as sim:
        code, _, errors = sim.ended()
    assert (code, errors) == (2, 'create_sim: /dev/full: No space left on device\n')


def test_an_address_that_is_in_use_is_named() -> None:
    with socket.create_server(('127.0.0.1', 0)) as server:
        port = server.getsockname()[1]
        assert refused('--tcp', f':{port}').startswith(
            f'socket://127.0.0.1:{port}: Address already in use')


def test_a_host_that_is_not_known_is_named() -> None:
    assert refused('--tcp', 'no.such.host.invalid:4567').startswith(
        'socket://no.such.host.invalid:4567: ')


@pytest.mark.parametrize('content, reason', [
    (b'\x7fELF\x80\xff', "'WORLD' is no world file: it is not text"),
    (b'PK\3\4' + bytes(5000), "WORLD, line 1: unknown 'PK\\x03\\x04"),
    (None, "'WORLD': Is a directory")], ids=['binary', 'zeros', 'folder'])
def test_a_file_that_is_no_world_is_named(
        tmp_path: Path, content: bytes | None, reason: str) -> None:
    path = tmp_path / 'world'
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    with simulator('--world', path) as sim:
        code, _, errors = sim.ended()
    assert code == 2
    assert reason.replace('WORLD', str(path)) in errors
    assert len(errors.splitlines()[-1]) < 400
