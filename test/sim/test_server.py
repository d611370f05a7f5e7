"""`create_sim` as its users run it: real processes, real terminals, no guessed sleeps."""

import csv
import fcntl
from itertools import pairwise
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
import termios
import threading
import time
from typing import Any

import pytest
import serial

from create_oi_ros import oi
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.server import Server
from create_oi_ros.sim.server.lines import PtyLine
from create_oi_ros.sim.world import shipped
from support.simulator import ControlClient, opened, receive, silent, simulator, taught

START, SAFE, FULL = bytes([128]), bytes([131]), bytes([132])
STREAM = bytes([148, 3, 35, 41, 42])
FRAME = 3 + 2 + 3 + 3


@pytest.fixture
def port(tmp_path: Path) -> Path:
    """Return the path of the simulator's link."""
    return tmp_path / 'create'


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


def test_it_serves_clients_one_after_the_other(port: Path) -> None:
    with simulator('--link', port) as sim:
        for _ in range(5):
            with opened(port) as client:
                os.write(client, START + SAFE + bytes([142, 35]))
                assert receive(client, 1) == b'\x02'
        assert sim.stop()[0] == 0


def test_it_ends_while_a_client_is_connected(port: Path) -> None:
    with simulator('--link', port) as sim, opened(port) as client:
        os.write(client, START + STREAM)
        receive(client, 10 * FRAME)
        assert sim.stop() == (0, f'  create_node --ros-args -p port:={port}\n', '')


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


def test_a_second_signal_ends_it_at_once(port: Path) -> None:
    with simulator('--link', port, '--linger', '60') as sim, opened(port) as client:
        os.write(client, START + STREAM)
        receive(client, FRAME)
        sim.process.send_signal(signal.SIGINT)
        receive(client, 20 * FRAME)
        assert sim.stop()[0] == 0


def test_without_a_client_linger_waits_for_nobody(port: Path) -> None:
    with simulator('--link', port, '--linger', '60') as sim:
        assert sim.stop()[0] == 0


def test_a_robot_whose_client_has_gone_drives_on(tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher):
        with opened(port) as client:
            os.write(client, START + SAFE + bytes([145, 0, 200, 0, 200]))
            teacher.tell('wait speed>0.19')
        assert teacher.truth('after 0.5')['x'] > 0.08


def test_a_command_written_by_a_client_that_closes_at_once_is_heard(tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher):
        for mode, opcode in (('SAFE', SAFE), ('FULL', FULL), ('PASSIVE', START)) * 5:
            with opened(port) as client:
                os.write(client, START + opcode)
            teacher.tell(f'wait mode={mode}')


def test_bytes_sent_while_no_client_is_connected_are_lost(tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher):
        with opened(port) as client:
            os.write(client, START + STREAM)
            receive(client, FRAME)
        before = teacher.truth('after 1')['frames']
        assert before > 60
        with opened(port) as client:
            os.write(client, bytes([150, 0]))
            teacher.tell('after 0.1')
            os.write(client, bytes([154]))
            heard = b''
            while not silent(client, 0.3):
                heard += os.read(client, 4096)
        assert len(heard) < 20 * FRAME
        assert heard[-1:] == b'\0'


def test_a_client_that_stops_reading_loses_bytes_and_no_more(tmp_path: Path) -> None:
    with taught(tmp_path, '--speed', '20') as (port, teacher), opened(port) as client:
        os.write(client, START + STREAM)
        teacher.tell('wait frames>3000 timeout=100')
        os.write(client, SAFE)
        teacher.tell('wait mode=SAFE')


def test_two_simulators_have_two_terminals(tmp_path: Path) -> None:
    one, two = tmp_path / 'one', tmp_path / 'two'
    with simulator('--link', one), simulator('--link', two):
        assert one.resolve() != two.resolve()


def test_a_link_left_by_a_killed_simulator_is_taken_over(port: Path) -> None:
    with simulator('--link', port) as sim:
        sim.process.kill()
        sim.process.wait()
    assert os.path.islink(port)
    with simulator('--link', port), opened(port) as client:
        os.write(client, START + bytes([142, 35]))
        assert receive(client, 1) == b'\x01'


@pytest.mark.parametrize('arguments', [
    ['--world', 'nowhere'], ['--fault', 'burn'], ['--guess', 'boot=1'], ['--speed', '0'],
    ['--tcp', 'nonsense'], ['--odometry', 'best'], ['--linger', '-1'], ['--linger', 'x'],
    ['--tcp', ':0', '--link', 'x']])
def test_a_wrong_option_is_refused_with_the_reason(arguments: list[str]) -> None:
    with simulator(*arguments) as sim:
        code, _, errors = sim.ended()
    assert code == 2
    assert 'create_sim: error: ' in errors
    assert 'Traceback' not in errors


def test_without_a_link_it_says_which_terminal_it_is_on() -> None:
    with simulator() as sim:
        name = sim.said.split()[5]
        with opened(Path(name)) as client:
            os.write(client, START + bytes([142, 35]))
            assert receive(client, 1) == b'\x01'


# The line.

def test_the_terminal_is_raw_and_57600() -> None:
    with simulator() as sim, opened(Path(sim.said.split()[5])) as client:
        settings = termios.tcgetattr(client)
        assert settings[4:6] == [termios.B57600, termios.B57600]
        assert not settings[3] & (termios.ICANON | termios.ECHO | termios.ISIG)
        os.write(client, START + bytes([140, 0, 1, 3, 13, 152, 4, 10, 13, 17, 19, 154]))
        assert receive(client, 5) == bytes([4, 10, 13, 17, 19])


@pytest.mark.parametrize('rate', [19200, 28800])
def test_a_client_at_another_baud_rate_is_not_understood(tmp_path: Path, rate: int) -> None:
    with taught(tmp_path) as (port, teacher):
        with serial.Serial(str(port), rate, timeout=0.2) as client:
            client.write(START * 5)
            assert client.read(10) == b''
            assert teacher.truth()['mode'] == 'OFF'
        with serial.Serial(str(port), 57600, timeout=5) as client:
            client.write(START + bytes([129, oi.BaudCode.of_rate(rate)]))
            teacher.tell(f'wait baud={rate}')
            teacher.tell('after 0.15')
            client.baudrate = rate
            client.write(bytes([142, 35]))
            assert client.read(1) == b'\x01'


def test_wire_time_lets_bytes_leave_at_the_baud_rate(port: Path) -> None:
    with simulator('--link', port, '--wire-time') as sim, opened(port) as client:
        os.write(client, START)
        begin = time.monotonic()
        os.write(client, bytes([149, 200] + [6] * 200))
        receive(client, 200 * 52)
        seconds = time.monotonic() - begin
        assert sim.stop()[0] == 0
    assert 200 * 52 * 10 / 57600 < seconds < 200 * 52 * 10 / 57600 * 1.5


def test_a_socket_url_works_on_loopback() -> None:
    with simulator('--tcp', '127.0.0.1:0') as sim:
        url = sim.said.split()[5]
        for _ in range(3):
            with serial.serial_for_url(url, timeout=5) as client:
                client.write(START + SAFE + bytes([142, 35]))
                assert client.read(1) == b'\x02'
        code, said, _ = sim.stop()
        assert code == 0
        assert 'password' not in said


def test_tcp_says_so_when_it_is_told_to_listen_elsewhere() -> None:
    with simulator('--tcp', '0.0.0.0:0') as sim:
        assert 'there is no password' in sim.stop()[1]


def test_tcp_without_a_host_listens_on_loopback_only() -> None:
    with simulator('--tcp', ':0') as sim:
        assert 'socket://127.0.0.1:' in sim.said


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

def test_a_client_that_streams_single_ids_and_checks_the_sum_with_the_header(
        port: Path) -> None:
    ids = [7, 9, 10, 11, 12, 15, 16, 18, 19, 20, 22, 25, 35]
    sizes = [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 1]
    with simulator('--link', port), serial.Serial(str(port), 57600, timeout=5) as client:
        client.write(bytes([128]))
        client.write(bytes([132]))
        client.write(bytes([148, len(ids), *ids]))
        client.write(bytes([145, 0, 100, 0, 100]))
        for _ in range(200):
            assert client.read(1) == b'\x13'
            length = client.read(1)[0]
            assert length == len(ids) + sum(sizes)
            body = client.read(length + 1)
            assert (19 + length + sum(body)) % 256 == 0
            place = 0
            for number, size in zip(ids, sizes, strict=True):
                assert body[place] == number
                place += 1 + size


def test_a_client_that_polls_group_6_and_single_packets_and_asks_for_group_100(
        tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher), \
            serial.Serial(str(port), 57600, timeout=5) as client:
        client.write(bytes([128, 131, 137, 0, 100, 128, 0]))
        travelled = 0
        for _ in range(100):
            teacher.tell('after 0.015')
            client.write(bytes([142, 6]))
            packet = client.read(52)
            assert len(packet) == 52
            assert packet[40] == 2
            travelled += int.from_bytes(packet[12:14], signed=True)
            client.write(bytes([142, 22]))
            assert 10_000 < int.from_bytes(client.read(2)) < 18_000
        assert 50 < travelled < 250
        client.timeout = 0.2
        client.write(bytes([142, 100]))
        assert client.read(80) == b''
        client.write(bytes([142, 35]))
        assert client.read(1) == b'\x02'


# The clock.

def test_frames_keep_to_the_clock(port: Path) -> None:
    with simulator('--link', port), opened(port) as client:
        os.write(client, START + STREAM)
        receive(client, FRAME)
        begin = time.monotonic()
        receive(client, 200 * FRAME)
        # Never early; bench_sim measures how late a busy computer makes them.
        assert time.monotonic() - begin > 200 * 0.015 - 0.02


def test_speed_makes_its_time_run_faster(tmp_path: Path) -> None:
    with taught(tmp_path, '--speed', '20') as (_, teacher):
        begin = time.monotonic()
        before = teacher.truth()['time']
        after = teacher.truth('after 20')['time']
        assert after - before >= 20
        assert time.monotonic() - begin < 5


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


# The control socket.

def test_it_sets_the_world_and_waits_for_what_happens(tmp_path: Path) -> None:
    with taught(tmp_path, '--world', 'room') as (port, teacher), opened(port) as client:
        os.write(client, START + SAFE)
        teacher.tell('wait mode=SAFE')
        os.write(client, bytes([142, 7]))
        assert receive(client, 1) == b'\x00'
        teacher.tell('bump left', 'wait bump_left=1')
        os.write(client, bytes([142, 7]))
        assert receive(client, 1) == b'\x02'
        teacher.tell('bump off', 'lift', 'wait mode=PASSIVE drop_left=true', 'down')
        teacher.tell('charger on', 'wait charging_state=2', 'charger off')
        teacher.tell('place 1 0.5 90')
        pose = teacher.truth()
        assert (pose['x'], pose['y']) == (1.0, 0.5)
        assert pose['yaw'] == pytest.approx(1.5708, abs=1e-4)


def test_every_word_is_understood_or_refused_with_the_reason(tmp_path: Path) -> None:
    with taught(tmp_path) as (_, teacher):
        teacher.tell(
            'help', 'truth', 'sense', 'room', 'wait time>=0 mode=OFF demo=none', 'after 0',
            'bump both 0.1', 'button play 0.1', 'force wall=1 seconds=0.1', 'unforce wall',
            'unforce', 'lift', 'down', 'drop right caster', 'drop', 'hold left', 'hold',
            'push 0.1 0.5 0.2', 'slip 0.1 0.2 1', 'place 0 0 0', 'load ld0=0.3', 'charger off',
            'dock off', 'dock on', 'battery charge=0.5 temperature=20 fault=0', 'power off',
            'power on', 'power toggle', 'power toggle', 'power fail', 'cable cut', 'cable mend',
            'fault flip:0.1 cut@100', 'fault off')
        for line in ('', 'dance', 'bump', 'bump up', 'bump left x', 'force nose=1', 'force',
                     'force wall=2', 'force wall=0.5', 'unforce nose', 'place 1 2', 'place 1 2 x',
                     'push 1', 'charger', 'battery charge=x', 'fault burn', 'cable tie', 'wait x',
                     'wait nose=1', 'wait mode>1', 'place nan 0 0', 'after', 'wait x=1 timeout=x',
                     'drop nose', 'load ld9=1', '\xe4\xf6'):
            assert teacher.ask(line).startswith('error '), line
        assert teacher.ask('wait x>9 timeout=0.05').startswith('error timeout')


def test_a_client_that_waits_does_not_block_the_others(tmp_path: Path) -> None:
    with taught(tmp_path) as (_, teacher):
        other = ControlClient(tmp_path / 'control')
        answers: list[str] = []
        waiting = threading.Thread(target=lambda: answers.append(other.ask('wait wall=1')))
        waiting.start()
        teacher.tell('truth', 'force wall=1')
        waiting.join()
        assert answers[0].startswith('ok ')
        other.close()


def test_a_pulled_cable_is_an_error_and_comes_back_under_the_same_name(tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher):
        with opened(port) as client:
            teacher.tell('cable unplug')
            assert not os.path.lexists(port)
            with pytest.raises(OSError, match='Input/output'):
                os.write(client, START)
        teacher.tell('cable plug', 'cable plug')
        with opened(port) as client:
            os.write(client, START + bytes([142, 35]))
            assert receive(client, 1) == b'\x01'


def test_a_cut_cable_loses_all_bytes_and_the_port_stays(tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher), opened(port) as client:
        os.write(client, START + STREAM)
        receive(client, FRAME)
        teacher.tell('cable cut')
        os.write(client, SAFE)
        while not silent(client, 0.1):
            os.read(client, 4096)
        assert teacher.truth()['mode'] == 'PASSIVE'
        teacher.tell('cable mend')
        receive(client, FRAME)


def test_a_power_failure_is_answered_by_the_banner(tmp_path: Path) -> None:
    with taught(tmp_path, '--guess', 'boot_seconds=0') as (port, teacher), \
            opened(port) as client:
        os.write(client, START + FULL)
        teacher.tell('wait mode=FULL', 'power fail')
        assert b'RDK by iRobot!' in receive(client, 130)
        assert teacher.truth()['mode'] == 'OFF'


def test_quit_ends_it(port: Path, tmp_path: Path) -> None:
    with simulator('--link', port, '--control', tmp_path / 'control') as sim:
        teacher = ControlClient(tmp_path / 'control')
        teacher.tell('quit')
        assert sim.ended()[0] == 0
        teacher.close()


# Faults, record, drawing.

def test_fault_off_ends_all_faults(tmp_path: Path) -> None:
    with taught(tmp_path) as (port, teacher), opened(port) as client:
        teacher.tell('fault silence@0+1000 unplug@1000', 'after 0.05', 'fault off', 'after 0.05')
        os.write(client, START + bytes([142, 35]))
        assert receive(client, 1) == b'\x01'


def test_faults_happen_at_their_times(tmp_path: Path) -> None:
    with taught(tmp_path, '--fault', 'unplug@0.5+0.5', '--fault', 'brownout@2',
                '--speed', '2') as (port, teacher):
        with opened(port) as client:
            os.write(client, START + FULL)
            teacher.tell('wait time>0.6')
            with pytest.raises(OSError, match='Input/output'):
                os.write(client, START)
        teacher.tell('wait time>1.1')
        with opened(port) as client:
            os.write(client, bytes([142, 35]))
            assert receive(client, 1) == b'\x03'
            teacher.tell('wait mode=OFF')


def test_damaged_frames_are_not_whole(port: Path) -> None:
    with simulator('--link', port, '--fault', 'flip:0.5', '--seed', '3'), \
            opened(port) as client:
        os.write(client, START + STREAM)
        frames = [receive(client, FRAME) for _ in range(100)]
    whole = sum(sum(frame) % 256 == 0 for frame in frames)
    assert 30 < whole < 70


def test_record_writes_the_truth_of_every_slot(tmp_path: Path) -> None:
    port, record = tmp_path / 'create', tmp_path / 'truth.csv'
    with simulator('--link', port, '--record', record) as sim, opened(port) as client:
        os.write(client, START + FULL + STREAM + bytes([145, 0, 200, 0, 200]))
        receive(client, 70 * FRAME)
        assert sim.stop()[0] == 0
    rows = list(csv.DictReader(record.open()))
    times = [float(row['time']) for row in rows]
    assert len(rows) >= 70
    assert all(b - a == pytest.approx(0.015) for a, b in zip(times, times[1:], strict=False))
    assert rows[-1]['mode'] == 'FULL'
    assert float(rows[-1]['x']) > 0.1


def test_the_simulator_does_not_hold_the_terminal_open(port: Path) -> None:
    """With the terminal open, it could not tell whether a client is connected."""
    with simulator('--link', port) as sim:
        held = Path(f'/proc/{sim.process.pid}/fd')
        targets = [os.readlink(each) for each in held.iterdir()]
        assert str(port.resolve()) not in targets


def test_it_needs_neither_ros_nor_pyserial() -> None:
    program = (
        'import sys, create_oi_ros.sim.server; '
        'sys.exit(any(name in sys.modules for name in ("rclpy", "serial", "numpy")))')
    assert subprocess.run([sys.executable, '-c', program], check=False).returncode == 0


def test_the_terminal_survives_a_client_that_hangs_it_up(port: Path) -> None:
    with simulator('--link', port):
        for _ in range(2):
            with opened(port) as client:
                fcntl.ioctl(client, termios.TIOCEXCL)
                os.write(client, START + bytes([142, 35]))
                assert receive(client, 1) == b'\x01'
                termios.tcflush(client, termios.TCIOFLUSH)
