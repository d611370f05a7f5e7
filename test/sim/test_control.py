# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The control socket, faults, record and replay of `create_sim`, and the pace of bytes."""

from collections import Counter
import csv
from dataclasses import fields
from enum import Enum
from math import hypot
import os
from pathlib import Path
import signal
import threading

from geometry_msgs.msg import Twist, Vector3
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest

from create_oi_ros.oi.tools.capture_format import encode_head, encode_record, Record, RecordKind
from create_oi_ros.sim.firmware.guesses import DEFAULT_GUESSES, Guesses
from create_oi_ros.sim.server.faults import Fault, FaultKind, Faults, MOST_GARBAGE
from create_oi_ros.sim.server.replay import Replay
from create_oi_ros.sim.server.serve import Pacer
from support.captures import read, said
from support.ros import Scene
from support.simulator import (
    ControlClient,
    FRAME,
    FULL,
    opened,
    receive,
    SAFE,
    silent,
    simulator,
    START,
    STREAM,
    taught,
)
from support.source import ROOT

Robot = tuple[Path, ControlClient]

# The control socket.

def test_it_sets_the_world_and_waits_for_what_happens(robot: Robot) -> None:
    port, teacher = robot
    with opened(port) as client:
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


def test_every_word_is_understood_or_refused_with_the_reason(robot: Robot) -> None:
    _, teacher = robot
    teacher.tell(
        'help', 'truth', 'sense', 'room', 'wait time>=0 mode=OFF demo=none', 'after 0',
        'bump both 0.1', 'button play 0.1', 'force wall=1 seconds=0.1', 'unforce wall',
        'unforce', 'lift', 'down', 'drop right caster', 'drop', 'hold left', 'hold',
        'push 0.1 0.5 0.2', 'slip 0.1 0.2 1', 'place 0 0 0', 'load ld0=0.3', 'charger off',
        'dock off', 'dock on', 'battery charge=0.5 temperature=20 fault=0 waits=1', 'power off',
        'power on', 'power toggle', 'power toggle', 'power fail', 'cable cut', 'cable mend',
        'fault flip:0.1 cut@100', 'fault off')
    for line in ('', 'dance', 'bump', 'bump up', 'bump left x', 'force nose=1', 'force',
                 'force wall=2', 'force wall=0.5', 'unforce nose', 'place 1 2', 'place 1 2 x',
                 'push 1', 'charger', 'battery charge=x', 'fault burn', 'cable tie', 'wait x',
                 'wait nose=1', 'wait mode>1', 'place nan 0 0', 'after', 'wait x=1 timeout=x',
                 'place 1e200 0 0', 'push 1e300 0 1', 'drop nose', 'load ld9=1', '\xe4\xf6'):
        assert teacher.ask(line).startswith('error '), line
    assert teacher.ask('wait x>9 timeout=0.05').startswith('error timeout')


def test_a_client_that_waits_does_not_block_the_others(robot: Robot) -> None:
    port, teacher = robot
    other = ControlClient(port.parent / 'control')
    answers: list[str] = []
    waiting = threading.Thread(target=lambda: answers.append(other.ask('wait wall=1')))
    waiting.start()
    teacher.tell('truth', 'force wall=1')
    waiting.join()
    assert answers[0].startswith('ok ')
    other.close()


def test_a_cut_cable_loses_all_bytes_and_the_port_stays(robot: Robot) -> None:
    port, teacher = robot
    with opened(port) as client:
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


# Faults, record, drawing.

def test_fault_off_ends_all_faults(robot: Robot) -> None:
    port, teacher = robot
    with opened(port) as client:
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


# The pages of the simulator.


GUESSES = (ROOT / 'docs' / 'simulator_guesses.md').read_text('utf-8')


@pytest.mark.parametrize('name', [field.name for field in fields(Guesses)])
def test_every_guess_is_there_with_its_default(name: str) -> None:
    value = getattr(DEFAULT_GUESSES, name)
    shown = (str(value).lower() if isinstance(value, bool) else
             value.value if isinstance(value, Enum) else f'{value:g}')
    assert f'`--guess {name}={shown}`' in GUESSES


# Faults that happen on purpose, and bytes that are delayed by the baud rate.


PIECE = bytes(range(100, 150))
SLOT = 0.015


def faults(*specs: str, seed: int = 1) -> Faults:
    """Return the faults of these specs."""
    return Faults([Fault.parse(spec) for spec in specs], seed)


def going_on(specs: str, kind: FaultKind, seconds: float) -> list[float]:
    """Return the start times of the slots in which a fault lasts."""
    some = faults(specs)
    times = []
    for slot in range(round(seconds / SLOT)):
        some.step(slot * SLOT)
        if some.active(kind):
            times.append(round(slot * SLOT, 3))
    return times


# Damage.

@pytest.mark.parametrize(('spec', 'changed'), [('flip:1', 0), ('drop:1', -1)])
def test_a_rate_of_1_damages_every_frame_once(spec: str, changed: int) -> None:
    some = faults(spec)
    for _ in range(100):
        data = some.from_robot(PIECE, 0)
        assert data != PIECE
        assert len(data) == len(PIECE) + changed
        if spec == 'flip:1':
            assert sum((a ^ b).bit_count() for a, b in zip(data, PIECE, strict=True)) == 1


def test_garbage_comes_in_front() -> None:
    some = faults('garbage:1')
    sizes = {len(some.from_robot(PIECE, 0)) - len(PIECE) for _ in range(1000)}
    assert sizes == set(range(1, MOST_GARBAGE + 1))
    assert some.from_robot(PIECE, 0).endswith(PIECE)


def test_damage_happens_to_bytes_of_the_robot_except_with_in() -> None:
    assert faults('flip:1').to_robot(PIECE, 0) == PIECE
    assert faults('flip.in:1').to_robot(PIECE, 0) != PIECE
    assert faults('flip.in:1').from_robot(PIECE, 0) == PIECE


# Faults that last.

def test_a_time_alone_is_once_for_a_second_a_period_repeats_a_rate_is_times_a_second() -> None:
    times = going_on('silence@1', FaultKind.SILENCE, 5)
    assert (times[0], times[-1]) == (1.005, 1.995)
    times = going_on('cut@1+0.5~2', FaultKind.CUT, 6)
    assert Counter(int(time) for time in times).keys() == {1, 3, 5}
    some = faults('unplug:0.1+0.5')
    begun = sum(FaultKind.UNPLUG in some.step(slot * SLOT) for slot in range(200_000))
    assert 200 < begun < 340


@pytest.mark.parametrize(('kind', 'out', 'into'), [
    ('silence', False, True), ('deaf', True, False), ('cut', False, False),
    ('unplug', False, False), ('brownout', True, True)])
def test_which_way_bytes_are_lost(kind: str, out: bool, into: bool) -> None:
    some = faults(f'{kind}@0')
    assert some.step(0) == {FaultKind(kind)}
    assert (some.from_robot(PIECE, 0) == PIECE) is out
    assert (some.to_robot(PIECE, 0) == PIECE) is into


@pytest.mark.parametrize('spec', ['', 'flip', 'flip@3', 'flip:1.1', 'silence', 'burn:1', 'cut:',
                                  'cut@', 'cut:x', 'flip:-1', 'cut@1+', 'flip:1e3', 'cut@nan'])
def test_a_spec_with_an_error_is_refused(spec: str) -> None:
    with pytest.raises(ValueError, match='allowed|add a rate'):
        Fault.parse(spec)


# Pacing.

def test_a_byte_takes_ten_bits_and_what_is_written_together_arrives_together() -> None:
    pacer = Pacer()
    pacer.put(bytes(10), 0.0, 57600)
    assert pacer.take(9.9 * 10 / 57600) is None
    assert pacer.take(10 * 10 / 57600) == (bytes(10), 57600)
    assert pacer.due() == float('inf')


@given(st.lists(st.tuples(st.binary(max_size=300), st.floats(0, 0.02)), max_size=20),
       st.sampled_from([300, 19200, 57600]))
def test_all_bytes_arrive_in_order_and_none_before_its_time(
        sent: list[tuple[bytes, float]], baud: int) -> None:
    pacer, now, arrived = Pacer(), 0.0, b''

    def take() -> None:
        nonlocal arrived
        while (came := pacer.take(now)) is not None:
            arrived += came[0]
            assert came[1] == baud and len(arrived) <= now * baud / 10 + 1e-3

    for data, seconds in sent:
        pacer.put(data, now, baud)
        now += seconds
        take()
    while pacer.due() < float('inf'):
        now = max(now, pacer.due())
        take()
    assert arrived == b''.join(data for data, _ in sent)
    assert now <= sum(seconds for _, seconds in sent) + len(arrived) * 10 / baud + 0.001


# Captures: `create_sim --replay` sends the same bytes, from which come the same readings.


SECOND = 1_000_000
LOSS = 2.0
"""Seconds of a capture that may be missing after kill -9 on a busy computer."""
NEAR = 0.01
"""Metres by which odometry may differ for the same readings at slightly other times."""


def written(path: Path, *records: tuple[float, RecordKind, bytes]) -> Path:
    """Write a capture of records with times in seconds."""
    before, data = 0, encode_head({'port': '/dev/create'})
    for time, kind, content in records:
        now = round(time * SECOND)
        data += encode_record(now - before, kind, content)
        before = now
    path.write_bytes(data)
    return path


# The robot's side, without a clock.

def replay(*records: tuple[float, RecordKind, bytes]) -> Replay:
    """Return a replay of records with times in seconds."""
    return Replay(Record(round(time * SECOND), kind, data) for time, kind, data in records)


def at(robot: Replay, now: float) -> bytes:
    """Return the bytes that are sent up to a time."""
    robot.poll(now)
    return robot.data_to_send()


def test_it_starts_when_the_host_sends_as_the_captured_one_did() -> None:
    robot = replay(
        (1, RecordKind.OPENED, b''), (2, RecordKind.FROM_ROBOT, b'before'),
        (3, RecordKind.TO_ROBOT, b'\x80'),
        (3.5, RecordKind.FROM_ROBOT, b'after'), (4, RecordKind.END, b''))
    assert at(robot, 100) == b''
    robot.receive(b'', 100)
    assert at(robot, 200) == b''
    robot.receive(b'\x80\x83', 200)
    assert at(robot, 200) == b'before'
    assert at(robot, 200.4) == b''
    robot.receive(b'\x83', 200.4)
    assert robot.due() == pytest.approx(200.5)
    assert at(robot, 200.6) == b'after' and not robot.over
    assert at(robot, 202) == b'' and robot.over and robot.due() > 1e9
    assert (robot.sent, robot.received, robot.received_then, robot.time) == (11, 3, 1, 4.0)


def test_a_port_that_was_lost_comes_back_and_waits_for_the_host() -> None:
    robot = replay(
        (0, RecordKind.TO_ROBOT, b'\x80'), (1, RecordKind.FROM_ROBOT, b'a'),
        (2, RecordKind.LOST, b'gone'),
        (7, RecordKind.OPENED, b''), (7.1, RecordKind.TO_ROBOT, b'\x80'),
        (7.2, RecordKind.FROM_ROBOT, b'b'))
    robot.receive(b'\x80', 10)
    assert at(robot, 11) == b'a' and robot.plugged
    assert at(robot, 12) == b'' and not robot.plugged
    assert at(robot, 16.9) == b'' and not robot.plugged
    assert at(robot, 30) == b'' and robot.plugged
    robot.receive(b'\x80', 40)
    assert at(robot, 40.05) == b''
    assert at(robot, 40.2) == b'b'


# `create_sim --replay`.

def test_a_capture_is_played_and_its_end_told(tmp_path: Path) -> None:
    path = written(tmp_path / 'c', (0, RecordKind.TO_ROBOT, b'\x80'),
                   (0.2, RecordKind.FROM_ROBOT, b'hello'),
                   (0.3, RecordKind.FROM_ROBOT, bytes(20_000)), (0.4, RecordKind.END, b''))
    with simulator('--link', tmp_path / 'create', '--replay', path) as sim:
        assert '/dev/create' in sim.said
        with opened(tmp_path / 'create') as host:
            os.write(host, b'\x80\x83')
            assert receive(host, 20_005) == b'hello' + bytes(20_000)
        code, told, errors = sim.ended()
    assert (code, errors) == (0, '')
    assert 'Played 0.4 s: 20005 bytes to the host, 2 bytes from it (1 when' in told
    assert not os.path.lexists(tmp_path / 'create')


def test_a_capture_that_is_cut_short_is_played_up_to_the_cut(tmp_path: Path) -> None:
    path = written(tmp_path / 'c', (0, RecordKind.TO_ROBOT, b'\x80'),
                   (0.1, RecordKind.FROM_ROBOT, b'hello'))
    with simulator('--link', tmp_path / 'create', '--replay', path) as sim:
        with opened(tmp_path / 'create') as host:
            os.write(host, b'\x80')
            assert receive(host, 5) == b'hello'
        code, told, errors = sim.ended()
    assert code == 1 and 'Played 0.1 s: 5 bytes' in told
    assert errors.startswith(f'create_sim: {path}: cut short at 0.100 s')


def test_a_file_that_cannot_be_replayed_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / 'c').write_bytes(encode_head({}) + b'\7\0')
    with simulator('--link', tmp_path / 'create', '--replay', tmp_path / 'c') as sim:
        code, told, errors = sim.ended()
    assert (code, sim.said, told) == (1, '', '')
    assert 'damaged' in errors and str(tmp_path / 'c') in errors and 'Errno' not in errors
    assert errors.count('\n') == 1


# The node.


def drive(stage: Scene, odom: list[Odometry]) -> None:
    """Drive half a metre on a bend and stand still again."""
    velocity = stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    going = Twist(linear=Vector3(x=0.3), angular=Vector3(z=0.6))
    timer = stage.ros.node.create_timer(0.1, lambda: velocity.publish(going))
    stage.ros.until(lambda: odom and abs(odom[-1].pose.pose.position.y) > 0.15)
    timer.cancel()
    frames = len(odom)
    stage.ros.until(lambda: len(odom) > frames + 150 and odom[-1].twist.twist.linear.x == 0)


def test_a_captured_run_is_played_to_another_node(stage: Scene) -> None:
    first, second = stage.folder / 'first.capture', stage.folder / 'second.capture'
    odom = stage.ros.listen(Odometry, 'odom', 1000)
    node = stage.node(stage.robot().link, capture=first)
    drive(stage, odom)
    node.send(signal.SIGINT)
    assert node.ended() == 0
    _, records, wrong = read(first.read_bytes())
    assert not wrong and f'written to {first}' in node.output
    assert {record.kind for record in records} >= {
        RecordKind.OPENED, RecordKind.FROM_ROBOT, RecordKind.TO_ROBOT, RecordKind.NOTE,
        RecordKind.END}
    then, odom[:] = list(odom), []
    again = stage.folder / 'again'
    sim = stage.program('create_sim', '--link', str(again), '--replay', str(first))
    node = stage.node(again, capture=second)
    stage.ros.until(lambda: not sim.running())
    node.send(signal.SIGINT)
    assert node.ended() == 0
    assert said(read(second.read_bytes())[1]) == said(records)
    ends = [run[-1].pose.pose for run in (then, odom)]
    assert ends[1].position.x == pytest.approx(ends[0].position.x, abs=NEAR)
    assert ends[1].position.y == pytest.approx(ends[0].position.y, abs=NEAR)
    assert ends[1].orientation.z == pytest.approx(ends[0].orientation.z, abs=NEAR)
    # A new node starts at the origin; its first frames may come before anybody hears them.
    assert hypot(ends[1].position.x, ends[1].position.y) > 0.15


def test_a_killed_node_leaves_a_capture(stage: Scene) -> None:
    path = stage.folder / 'walk.capture'
    odom = stage.ros.listen(Odometry, 'odom', 1000)
    node = stage.node(stage.robot().link, capture=path)
    stage.ros.until(lambda: len(odom) > 200)
    node.send(signal.SIGKILL)
    node.ended()
    _, records, wrong = read(path.read_bytes())
    assert wrong.startswith('cut short')
    assert records[-1].time / SECOND > 200 * 0.015 - LOSS


def test_a_capture_that_cannot_be_written_is_refused_at_start(stage: Scene) -> None:
    node = stage.node(stage.folder / 'create', capture=stage.folder / 'no/such/folder/walk')
    assert node.ended() == 2
    assert 'parameter capture' in node.output and 'No such file or directory' in node.output
    assert 'Traceback' not in node.output
