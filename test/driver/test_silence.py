# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A line that falls silent, loses or damages frames, ends or is slow."""

from itertools import pairwise
from math import hypot

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Severity
from create_oi_ros.driver.connection import SILENCE
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
