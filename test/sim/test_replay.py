# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The real node captures a run, `create_sim` replays it: same bytes, same readings."""

from math import hypot
import os
from pathlib import Path
import signal

from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
import pytest

from create_oi_ros.oi.tools.capture_format import encode_head, encode_record, Record, RecordKind
from create_oi_ros.sim.server.replay import Replay
from support.captures import read, said
from support.ros import Scene
from support.simulator import opened, receive, simulator

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
