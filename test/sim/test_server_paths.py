# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Paths, addresses and files that `create_sim` cannot use: each gets one sentence."""

from collections.abc import Callable, Iterator
import os
from pathlib import Path
import signal
import socket

import pytest

from create_oi_ros.sim.server import main
from support.simulator import opened, receive, simulator, START, taught

Refused = Callable[..., str]


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Iterator[Refused]:
    """Run `create_sim` with arguments that it must refuse by one sentence; return that."""
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}

    def run(*arguments: str | Path) -> str:
        assert main([*map(str, arguments)]) == 2
        said, errors = capsys.readouterr()
        assert said == ''
        assert errors.startswith('create_sim: ') and errors.count('\n') == 1
        return errors.removeprefix('create_sim: ').removesuffix('\n')
    yield run
    for number, handler in handlers.items():
        if number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, handler)


def test_what_is_in_the_place_of_the_link_or_the_socket_is_left_alone(
        port: Path, refused: Refused) -> None:
    port.write_text('precious')
    assert refused('--link', port) == f'{port}: is no symbolic link, so it is kept'
    assert refused('--control', port) == f'{port}: is no socket, so it is kept'
    assert port.read_text() == 'precious'
    port.unlink()
    port.symlink_to('ttyUSB0')
    assert refused('--link', port) == (
        f'{port}: leads to ttyUSB0, which is no pseudo terminal, so it is kept')
    assert os.readlink(port) == 'ttyUSB0'


@pytest.mark.parametrize('option', ['--link', '--control'])
def test_the_path_of_a_live_simulator_is_refused_with_its_process(
        tmp_path: Path, option: str, refused: Refused) -> None:
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


def test_link_and_socket_left_by_a_killed_simulator_are_taken_over(tmp_path: Path) -> None:
    port, control = tmp_path / 'create', tmp_path / 'control'
    with simulator('--link', port, '--control', control) as sim:
        sim.process.kill()
        sim.process.wait()
    assert port.is_symlink() and control.is_socket()
    with taught(tmp_path) as (_, teacher), opened(port) as client:
        os.write(client, START + bytes([142, 35]))
        assert receive(client, 1) == b'\x01'
        teacher.tell('truth')


@pytest.mark.parametrize(('option', 'path', 'reason'), [
    *((option, '/nodir/y', 'No such file or directory')
      for option in ('--link', '--control', '--record', '--replay')),
    ('--control', f'/tmp/{"x" * 108}', 'AF_UNIX path too long')])
def test_a_path_that_cannot_be_used_is_named(
        option: str, path: str, reason: str, refused: Refused) -> None:
    assert refused(option, path) == f'{path}: {reason}'


def test_a_full_disk_ends_a_recording_with_the_name_of_the_file() -> None:
    with simulator('--record', '/dev/full', '--speed', '100') as sim:
        code, _, errors = sim.ended()
    assert (code, errors) == (2, 'create_sim: /dev/full: No space left on device\n')


def test_an_address_that_is_in_use_or_not_known_is_named(refused: Refused) -> None:
    with socket.create_server(('127.0.0.1', 0)) as server:
        port = server.getsockname()[1]
        assert refused('--tcp', f':{port}').startswith(
            f'socket://127.0.0.1:{port}: Address already in use')
    unknown = 'no.such.host.invalid:4567'
    assert refused('--tcp', unknown).startswith(f'socket://{unknown}: ')


@pytest.mark.parametrize('name', ['map.yaml', 'map.pgm'])
def test_an_export_overwrites_nothing(tmp_path: Path, name: str, refused: Refused) -> None:
    (tmp_path / name).write_text('precious')
    said = refused('--export', tmp_path / 'map.yaml')
    assert said.startswith(f'{tmp_path / name}: exists already')
    assert [path.read_text() for path in tmp_path.iterdir()] == ['precious']


@pytest.mark.parametrize(('arguments', 'reason'), [
    (['--world', 'nowhere'], 'one of apartment, empty, room, table'),
    (['--world', ''], "''; allowed: a file, or one of apartment"),
    (['--world', 'FOLDER'], 'one of apartment, empty, room, table'),
    (['--world', 'FOLDER/binary'], 'is no world file: it is not text'),
    (['--world', 'FOLDER/zeros'], "FOLDER/zeros, line 1: unknown 'PK"),
    (['--fault', 'burn'], 'with KIND one of flip'), (['--guess', 'boot=1'], "no guess 'boot'"),
    (['--speed', '0'], 'allowed: 0.001 to 1000'), (['--tcp', 'nonsense'], 'allowed: HOST:PORT'),
    (['--odometry', 'best'], 'invalid choice'), (['--linger', 'x'], 'allowed: 0 to 60'),
    (['--tcp', ':0', '--link', 'x'], 'not allowed with argument'),
    (['--export', 'map.png'], 'allowed: a file that ends with .yaml'),
    (['--replay', 'c', '--world=room'], '--world does not work with --replay'),
    (['--replay', 'c', '--fault=cut:1'], '--fault does not work with --replay')])
def test_a_wrong_option_is_refused_with_the_reason(
        tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str],
        reason: str) -> None:
    (tmp_path / 'binary').write_bytes(b'\x7fELF\x80\xff')
    (tmp_path / 'zeros').write_bytes(b'PK\3\4' + bytes(5000))
    with pytest.raises(SystemExit) as ended:
        main([each.replace('FOLDER', str(tmp_path)) for each in arguments])
    error = capsys.readouterr().err.splitlines()[-1]
    assert ended.value.code == 2
    assert error.startswith('create_sim: error: ') and len(error) < 700
    assert reason.replace('FOLDER', str(tmp_path)) in error
