# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_sim` as its users run it: real processes, real terminals, no guessed sleeps."""

from collections.abc import Callable, Iterator
from itertools import pairwise
import os
from pathlib import Path
import signal
import socket
import termios
import time
from typing import Any

import pytest
import serial

from create_oi_ros import oi
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.server import Server
from create_oi_ros.sim.server.create_sim import main
from create_oi_ros.sim.server.lines import PtyLine
from create_oi_ros.sim.world import shipped
from support.simulator import (
    ControlClient,
    FULL,
    opened,
    receive,
    SAFE,
    simulator,
    START,
    taught,
)

Robot = tuple[Path, ControlClient]

# Serving and ending.

@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_it_with_0_and_nothing_is_left_behind(
        port: Path, tmp_path: Path, number: signal.Signals) -> None:
    with simulator('--link', port, '--control', tmp_path / 'control') as sim:
        assert str(port) in sim.said
        assert os.path.islink(port)
        code, said, errors = sim.stop(number)
        assert (code, errors) == (0, '')
        assert str(port) in said
        assert list(tmp_path.iterdir()) == []


def test_with_linger_it_ends_when_the_client_has_closed_the_port(port: Path) -> None:
    """A driver that stops the robot at the same Ctrl-C must not lose its port first."""
    with simulator('--link', port, '--linger', '20') as sim:
        with opened(port) as client:
            os.write(client, START + bytes([142, 35]))
            assert receive(client, 1) == b'\x01'
            sim.process.send_signal(signal.SIGINT)
            for _ in range(5):
                os.write(client, bytes([142, 35]))
                assert receive(client, 1) == b'\x01'
        assert sim.ended()[0] == 0


def test_a_robot_whose_client_has_gone_drives_on(robot: Robot) -> None:
    port, teacher = robot
    with opened(port) as client:
        os.write(client, START + SAFE + bytes([145, 0, 200, 0, 200]))
        teacher.tell('wait speed>0.19')
    assert teacher.truth('after 0.5')['x'] > 0.08


def test_a_command_written_by_a_client_that_closes_at_once_is_heard(robot: Robot) -> None:
    port, teacher = robot
    for mode, opcode in (('SAFE', SAFE), ('FULL', FULL), ('PASSIVE', START)) * 5:
        with opened(port) as client:
            os.write(client, START + opcode)
        teacher.tell(f'wait mode={mode}')


# The line.

def test_the_terminal_is_raw_and_57600() -> None:
    with simulator() as sim, opened(Path(sim.said.split()[5])) as client:
        settings = termios.tcgetattr(client)
        assert settings[4:6] == [termios.B57600, termios.B57600]
        assert not settings[3] & (termios.ICANON | termios.ECHO | termios.ISIG)
        os.write(client, START + bytes([140, 0, 1, 3, 13, 152, 4, 10, 13, 17, 19, 154]))
        assert receive(client, 5) == bytes([4, 10, 13, 17, 19])


def test_a_program_of_ours_says_lines_to_the_control_socket(capsys, tmp_path) -> None:
    control = tmp_path / 'world'
    with simulator('--link', str(tmp_path / 'tty'), '--control', str(control)):
        assert main(['--control', str(control), '--say', 'bump left']) == 0
        assert main(['--control', str(control), '--say', 'fly']) == 1
        ok, error = capsys.readouterr().out.splitlines()
        assert ok == 'ok' and error.startswith('error')
    assert main(['--control', str(tmp_path / 'none'), '--say', 'lift']) == 2
    assert f'{tmp_path}/none: No such file or directory' in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(['--say', 'lift'])
    assert '--say needs --control PATH' in capsys.readouterr().err


def test_a_socket_url_works_on_loopback_and_one_for_others_is_told_to_have_no_password() -> None:
    with simulator('--tcp', '127.0.0.1:0') as sim:
        url = sim.said.split()[5]
        for _ in range(3):
            with serial.serial_for_url(url, timeout=5) as client:
                client.write(START + SAFE + bytes([142, 35]))
                assert client.read(1) == b'\x02'
        code, said, _ = sim.stop()
        assert code == 0
        assert 'password' not in said
    with simulator('--tcp', '0.0.0.0:0') as sim:
        assert 'there is no password' in sim.stop()[1]


def test_a_new_tcp_client_replaces_the_old_one() -> None:
    with simulator('--tcp', ':0') as sim:
        address = ('127.0.0.1', int(sim.said.split()[5].rpartition(':')[2]))
        with socket.create_connection(address, 5) as first:
            first.sendall(START + bytes([142, 35]))
            assert first.recv(1) == b'\x01'
            with socket.create_connection(address, 5) as second:
                second.sendall(bytes([142, 35]))
                assert second.recv(1) == b'\x01'
                assert first.recv(1) == b''


# Clients that other people wrote.

def test_a_client_that_drains_and_sets_the_new_rate_at_once(robot: Robot) -> None:
    port, teacher = robot
    with serial.Serial(str(port), 57600, timeout=5) as client:
        for old, new in pairwise((57600, 19200, 38400, 28800, 57600)):
            client.write(START + SAFE + bytes([129, oi.BaudCode[f'B{new}']]))
            termios.tcdrain(client.fileno())
            client.baudrate = new
            teacher.tell(f'wait baud={new}', 'after 0.15')
            client.write(bytes([142, 35]))
            assert client.read(1) == b'\x02', (old, new)


# The clock.


def test_a_long_stall_leaves_the_robot_where_it_was() -> None:
    """A process that stands still, or a laptop that sleeps, is a jump of the clock."""
    jumps: list[dict[str, Any]] = []
    create, line = Create(Body(shipped('empty'))), PtyLine()
    server = Server(create, line, clock=lambda: time.monotonic() + len(jumps))

    def jump() -> None:
        facts = server.control.facts()
        if facts['speed'] > 0.09:
            jumps.append(facts)
        if len(jumps) == 3:
            server.stop()
    create.receive(START + SAFE + bytes([145, 0, 100, 0, 100]), 0.0)
    server.watchers.append(jump)
    server.serve()
    line.close()
    for before, after in pairwise(jumps):
        assert after['time'] - before['time'] < 0.6
        assert after['x'] - before['x'] < 0.06


# Paths, addresses and files that it cannot use: each gets one sentence.


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
