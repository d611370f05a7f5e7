# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_sim` as its users run it: real processes, real terminals, no guessed sleeps."""

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
