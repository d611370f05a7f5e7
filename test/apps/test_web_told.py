# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a page of `create_web` is told of a robot: changes, events, samples, track, battery."""

import json
from math import inf, nan, pi

from create_oi_msgs.msg import Bumper, Cliff, Mode, Wall
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest
from sensor_msgs.msg import BatteryState

from create_oi_ros.apps.web.bag_recording import recorder_arguments
from create_oi_ros.apps.web.live_robot import (
    BatteryTime,
    Cursor,
    LiveRobot,
    MOST_POINTS,
    OLD,
    SILENT,
    TrackLog,
)
from create_oi_ros.apps.web.simulated_truth import room_origin
from create_oi_ros.ros import topics
from create_oi_ros.ros.collector import FlatPose, NAMES
from support.anything import anything


def odom(x: float = 0.0, y: float = 0.0, speed: float = 0.0) -> Odometry:
    """Return an odometry message."""
    made = Odometry()
    made.pose.pose.position.x, made.pose.pose.position.y = x, y
    made.twist.twist.linear.x = speed
    return made


def diagnostics(level: bytes, message: str) -> DiagnosticArray:
    """Return what a driver says of its battery, beside a line that is fine."""
    return DiagnosticArray(status=[
        DiagnosticStatus(name='create: serial link'),
        DiagnosticStatus(name='create: battery', level=level, message=message)])


NAME_OF = {topic.type: name for name, topic in NAMES.items()}


def update(robot: LiveRobot, message: object, now: float) -> None:
    """Give a message to the robot as its topic does."""
    robot.update(NAME_OF[type(message)], message, now)


BEGIN = Cursor()


def news(robot: LiveRobot, cursor: Cursor = BEGIN, now: float = 0.0):
    """Return the news since a cursor, decoded, and the next cursor."""
    text, cursor = robot.news(cursor, now)
    return json.loads(text), cursor


def test_a_page_is_told_each_change_once():
    robot = LiveRobot()
    update(robot, odom(1.0, 2.0), 0.0)
    update(robot, Mode(mode=Mode.PASSIVE, wanted=Mode.SAFE, reason='cliff'), 0.0)
    first, cursor = news(robot)
    assert first['type'] == 'news'
    assert first['pose']['x'] == 1.0
    assert first['anew'] == [1.0, 2.0]
    assert first['mode'] == {'actual': 'PASSIVE', 'wanted': 'SAFE', 'reason': 'cliff'}
    assert news(robot, cursor, 0.5) == ({'type': 'news', 'at': 0.5}, cursor)
    update(robot, odom(1.1, 2.0), 0.2)
    second, cursor = news(robot, cursor)
    assert second.keys() == {'type', 'at', 'pose', 'track'}
    assert second['track'] == [1.1, 2.0]


def test_a_touch_is_an_event_where_it_began():
    robot = LiveRobot()
    update(robot, Bumper(left=True), 0.0)
    update(robot, Bumper(), 0.0)
    assert 'events' not in news(robot)[0], 'its place is not known'
    update(robot, odom(1.0), 0.1)
    update(robot, Bumper(left=True), 0.1)
    update(robot, Bumper(left=True, right=True), 0.2)
    update(robot, Cliff(front_left=True), 0.2)
    told, cursor = news(robot)
    assert told['events'] == [['bumper', 1.0, 0.0, 'left'], ['cliff', 1.0, 0.0, 'front left']]
    assert told['bump'] == {'left': True, 'right': True}
    update(robot, Bumper(), 0.3)
    update(robot, Bumper(right=True), 0.3)
    assert news(robot, cursor)[0]['events'] == [['bumper', 1.0, 0.0, 'right']]


def test_after_a_reset_of_the_odometry_the_track_begins_anew():
    robot = LiveRobot()
    update(robot, odom(3.0), 0.0)
    update(robot, Bumper(left=True), 0.0)
    _, cursor = news(robot)
    update(robot, odom(0.0), 0.02)
    told, cursor = news(robot, cursor)
    assert told['anew'] == [0.0, 0.0]
    assert 'events' not in told
    robot.forget()
    assert news(robot, cursor)[0]['anew'] == []


@pytest.mark.parametrize(('place', 'heading'), [(nan, 0.0), (inf, 0.0), (1e9, 0.0), (0.0, nan)])
def test_a_place_or_heading_that_cannot_be_drawn_is_left_out(place, heading):
    robot, message = LiveRobot(), odom(place)
    message.pose.pose.orientation.z = heading
    update(robot, message, 0.0)
    told, _ = news(robot)
    assert 'pose' not in told and told['anew'] == []


def test_samples_come_five_times_a_second_while_the_driver_speaks():
    robot = LiveRobot()
    robot.sample(0.0)
    told, cursor = news(robot)
    assert told['silent'] is True and 'samples' not in told
    for step in range(20):
        update(robot, odom(speed=0.2), step / 20)
        update(robot, Wall(signal=step), step / 20)
        robot.sample(step / 20)
    told, cursor = news(robot, cursor)
    assert told['silent'] is False
    assert len(told['samples']) == 5
    assert told['samples'][0] == [0.0, 0.2, 0.0, None, None, None, None, None, 0]
    robot.sample(1.0 + SILENT)
    assert news(robot, cursor)[0]['silent'] is True


def test_a_value_that_comes_again_is_old_when_it_does_not():
    robot = LiveRobot()
    for now in (0.0, 1.0, 2.0):
        update(robot, BatteryState(), now)
        update(robot, odom(), now)
    update(robot, Mode(), 2.0)
    robot.sample(2.0 + OLD)
    assert news(robot)[0]['old'] == []
    update(robot, odom(), 2.0 + OLD)
    robot.sample(2.1 + OLD)
    assert news(robot)[0]['old'] == ['battery'], 'the mode comes only when it changes'
    slow = LiveRobot()
    for now in (0.0, 10.0):  # sensor_rate: 0.1
        update(slow, Wall(), now)
    slow.sample(25.0)
    assert news(slow)[0]['old'] == []
    slow.sample(41.0)
    assert news(slow)[0]['old'] == ['wall']


def test_what_happened_is_told_with_its_time_and_once():
    robot = LiveRobot()
    update(robot, Mode(mode=Mode.SAFE, wanted=Mode.SAFE), 1.0)
    update(robot, Mode(mode=Mode.PASSIVE, wanted=Mode.SAFE, reason='cliff left'), 2.0)
    update(robot, Bumper(left=True), 3.0)
    update(robot, Bumper(left=True, right=True), 3.1)
    for now in (4.0, 5.0):
        update(robot, diagnostics(b'\x01', 'low'), now)
    update(robot, diagnostics(b'\x00', 'fine'), 6.0)
    told, cursor = news(robot)
    assert told['log'] == [
        [1.0, '', 'Mode SAFE'], [2.0, 'warn', 'Mode PASSIVE (cliff left)'],
        [3.0, 'warn', 'Bump left'], [4.0, 'warn', 'battery: low']]
    assert told['diagnostics']['battery'] == {'level': 0, 'message': 'fine', 'values': {}}
    assert 'log' not in news(robot, cursor)[0]


@given(st.data())
def test_any_message_of_a_driver_becomes_json(data):
    robot = LiveRobot()
    heard = [topic.type for topic in topics.SENSOR_TOPICS if topic.name != 'cargo_bay']
    for _ in range(3):
        update(robot, data.draw(anything(data.draw(st.sampled_from([*heard, Odometry, Mode])))), 0)
    robot.sample(0.1)
    news(robot)


def test_a_track_of_days_stays_small_and_goes_all_the_way():
    track = TrackLog()
    for second in range(60_000):
        track.add(FlatPose(0.5 * second, 0.0, 0.0))
    xs = track.since(0)[::2]
    assert len(xs) <= MOST_POINTS and (xs[0], xs[-1]) == (0.0, 0.5 * 59_999)
    assert max(b - a for a, b in zip(xs, xs[1:])) <= 8.0
    assert track.since(len(track) - 1) == [xs[-1], 0.0]


def test_pages_get_a_track_anew_when_it_has_lost_points_and_keep_the_events():
    robot = LiveRobot()
    update(robot, odom(), 0.0)
    update(robot, Bumper(left=True), 0.0)
    _, cursor = news(robot)
    anew = 0
    for second in range(2 * MOST_POINTS):
        update(robot, odom(0.1 * second), float(second))
        if second % 1000 == 0:
            told, cursor = news(robot, cursor)
            anew += 'anew' in told
            again = [['bumper', 0.0, 0.0, 'left']] if 'anew' in told else None
            assert told.get('events') == again
    assert anew == 2


def battery(charge=2.0, capacity=3.0, current=-1.0) -> dict[str, float]:
    """Return the arguments of the battery's time."""
    return {'charge': charge, 'capacity': capacity, 'current': current}


def test_the_battery_s_time_is_its_charge_over_the_mean_current_until_the_charger_comes_or_goes():
    assert BatteryTime().left(**battery(), now=0.0) == 120
    assert BatteryTime().left(**battery(current=2.0), now=0.0) == 30
    for unknown in (battery(charge=nan), battery(capacity=nan), battery(current=0.001),
                    battery(current=-0.03), battery(current=nan)):
        assert BatteryTime().left(**unknown, now=0.0) is None
    time = BatteryTime()
    time.left(**battery(current=-1.0), now=0.0)
    assert 110 < time.left(**battery(current=-2.0), now=1.0) < 120
    assert time.left(**battery(current=1.0), now=2.0) == 60


def test_the_room_lies_where_both_poses_are_one():
    assert room_origin(FlatPose(0, 0, 0), FlatPose(1, 2, pi / 2)) == pytest.approx(
        (-2, 1, -pi / 2))
    assert room_origin(FlatPose(2, 0, 3), FlatPose(0, 0, 0)) == (2, 0, 3)


def test_a_recorder_gets_the_names_and_the_enclave_of_its_page():
    assert recorder_arguments(
        ['-r', '__ns:=/one', '--log-level', 'warn', '--enclave', '/web', '-r', '__node:=page',
         '--remap', 'odom:=here']) == [
        '-r', '__ns:=/one', '--remap', 'odom:=here', '--enclave', '/web']
