# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A line that falls silent, loses or damages frames, ends or is slow; what is true after it."""

from itertools import pairwise
from math import hypot, radians

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Severity
from create_oi_ros.driver.connection import SILENCE
from support.goals import angle, distance, met, reach
from support.loop import Loop, texts


def test_silence_is_said_once_and_the_robot_is_called_until_it_answers(loop):
    loop.drive(0.2, 0.0, 0.3)
    loop.cut = True
    loop.run(5 * SILENCE)
    assert loop.driver.state.activity is Activity.CALLING
    assert loop.driver.status.actual is None
    said = [text.partition(':')[0] for text in texts(loop.notices, Severity.ERROR)]
    assert said == [f'no frame for {SILENCE} s', 'no answer at 57600 baud']
    assert loop.body.truth().speed > 0, 'the last Drive holds for ever'
    loop.cut = False
    loop.run(1.0)
    assert loop.driver.state.answered
    assert loop.robot.mode is oi.Mode.SAFE
    loop.run(0.5)
    assert loop.body.truth().speed == 0


@pytest.mark.parametrize('gap', [0.1, 0.2, 0.3, 0.4, 0.45])
def test_odometry_says_what_was_driven_while_frames_were_lost(loop, gap):
    loop.drive(0.2, 0.0, 3.0)
    off = loop.estimate.x - loop.body.truth().pose.x
    seen = len(loop.moved)
    loop.cut = True
    loop.drive(0.2, 0.0, gap)
    loop.cut = False
    loop.drive(0.2, 0.0, 1.0)
    assert loop.estimate.x - loop.body.truth().pose.x == pytest.approx(off, abs=0.002)
    for before, after in pairwise(loop.moved[seen - 1:]):
        seconds = after.stamp - before.stamp
        assert after.estimate.x - before.estimate.x == pytest.approx(0.2 * seconds, abs=0.003)


@pytest.fixture(scope='module')
def taught():
    """Return a driver that knows its robot: the first seconds have errors of their own."""
    made = Loop()
    made.run(0.3)
    for lesson in ((0.3, 0.0), (-0.2, 0.0), (0.0, 1.5), (0.0, -1.0), (0.2, 0.5), (0.0, 0.0)) * 3:
        made.drive(*lesson, 2.0)
    return made


@pytest.mark.parametrize(('speeds', 'gap', 'still'), [
    ((0.3, 0.0), 0.1, 0.0), ((0.3, 0.0), 0.45, 0.05), ((0.0, 2.0), 0.2, 0.0),
    ((0.0, 2.0), 0.45, 0.2), ((0.2, 1.0), 0.3, 0.05), ((0.2, 1.0), 0.45, 0.0)])
def test_what_was_driven_while_frames_were_lost_is_not_what_is_driven_now(
        taught, gap, speeds, still):
    loop = taught

    def miss():
        estimate, truth = loop.estimate, loop.body.truth()
        return estimate.x - truth.pose.x, estimate.y - truth.pose.y, estimate.yaw - truth.turned

    def off():
        now = miss()
        return hypot(now[0] - before[0], now[1] - before[1]), abs(now[2] - before[2])
    loop.drive(*speeds, 3.0)
    before = miss()
    loop.cut = True
    loop.drive(*speeds, gap)
    loop.cut = False
    loop.drive(*speeds, still)
    most = [each + 0.15 for each in off()]
    for _ in range(6):
        loop.drive(-speeds[0], -speeds[1], 0.1)
        assert all(now < limit for now, limit in zip(off(), most, strict=True))
    loop.drive(0.0, 0.0, 1.0)
    assert off() == pytest.approx((0.0, 0.0), abs=0.1)


# Frames that come late, as on a busy computer, say what was: the driver must not act on it.


@pytest.mark.parametrize('delay', [0.05, 0.2, 0.3, 0.45])
def test_a_robot_that_answers_late_is_not_said_to_have_left_its_mode(loop, delay):
    loop.run(3.0)
    loop.cut, loop.delay = True, delay
    loop.run(0.6)  # the driver calls again, and the robot's last frames in Safe come first
    loop.cut = False
    loop.run(4.0)
    assert loop.driver.status.actual is oi.Mode.SAFE
    assert not [notice.text for notice in loop.notices if 'robot left' in notice.text]


# After gaps, held wheels and waits: goals measure their own way, and the pose says its doubt.


HONEST = 3.5
"""Standard deviations by which an estimate may be off."""


def cut(loop: Loop, seconds: float, linear: float, angular: float) -> None:
    """Drive, and cut the line for a while; the robot drives on."""
    loop.drive(linear, angular, 4.0)
    loop.cut = True
    loop.drive(linear, angular, seconds)
    loop.cut = False


def off(loop: Loop) -> tuple[float, float]:
    """Return by how many of its deviations the estimate is off in place and yaw."""
    truth, e = loop.body.truth(), loop.estimate
    xx, _, _, _, yy, _, _, _, aa = e.pose_covariance
    return (hypot(e.x - truth.pose.x, e.y - truth.pose.y) / (xx + yy) ** 0.5,
            abs(e.yaw - truth.turned) / aa ** 0.5)


@pytest.mark.parametrize('turn', [90, -60])
@pytest.mark.parametrize(('gap', 'linear', 'angular'), [
    (10.0, 0.2, 0.3), (1.2, 0.2, 0.3), (4.0, 0.1, -0.8), (25.0, 0.15, 0.1)])
def test_a_turn_after_a_gap_is_as_long_as_was_asked(gap, linear, angular, turn):
    loop = met()
    cut(loop, gap, linear, angular)
    loop.run(2.0)
    assert reach(loop, angle(turn))[1] == pytest.approx(turn, abs=3.0)


def test_a_distance_after_a_gap_is_as_long_as_was_asked():
    loop = met()
    cut(loop, 6.0, 0.2, 0.0)
    loop.run(2.0)
    assert reach(loop, distance(1.0))[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(('seconds', 'rate'), [(1.5, 1.0), (2.5, -0.6)])
def test_a_turn_right_after_wheels_were_held_is_as_long_as_was_asked(seconds, rate):
    loop = met()
    loop.drive(0.0, rate, 3.0)
    loop.body.hold(right=True, left=True)
    loop.drive(0.0, rate, seconds)
    loop.body.hold(right=False, left=False)
    assert reach(loop, angle(90))[1] == pytest.approx(90, abs=5.0)


@pytest.mark.parametrize(('gap', 'linear', 'angular'), [
    (10.0, 0.2, 0.3), (30.0, 0.2, 0.3), (3.0, 0.3, -1.0), (20.0, 0.25, 0.0)])
def test_after_a_gap_the_pose_is_not_surer_than_it_is_right(gap, linear, angular):
    loop = met()
    cut(loop, gap, linear, angular)
    seen = len(loop.moved)
    for _ in range(40):
        loop.run(0.1)
        if len(loop.moved) > seen:
            assert max(off(loop)) < HONEST


def test_a_computer_that_slept_knows_that_it_does_not_know():
    loop = met()
    loop.drive(0.2, 0.2, 3.0)
    loop.stand_still(20.0)
    loop.robot.data_to_send()
    loop.run(0.5)
    assert max(off(loop)) < HONEST
    loop.run(4.0)
    assert max(off(loop)) < HONEST


@pytest.mark.parametrize('mode', [oi.Mode.PASSIVE, oi.Mode.SAFE])
def test_a_robot_that_stands_keeps_its_heading_in_each_mode(mode):
    loop = met()
    loop.drive(0.2, 0.5, 4.0)
    loop.run(2.0)
    loop.driver.modes.set(mode, loop.now)
    before = loop.estimate
    loop.run(180.0)
    assert loop.estimate.yaw == pytest.approx(before.yaw, abs=radians(0.5))
    assert loop.estimate.pose_covariance[8] < max(
        radians(1.5) ** 2, 1.5 * before.pose_covariance[8])
