# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The watch of the long tests tells a jump of the odometry from a robot that drove on."""

from math import cos, pi, sin

import pytest

from nightly.watch import GAP, jump, Pose, PROMPT, STEP, TruePath, TURN

BEGIN, LATE = 1000.0, 1000.0 + 2 * GAP
SLOT = 0.015


def odometry(time, forward=0.0, yaw=0.0):
    """Return a pose of the odometry."""
    return Pose(time, 5 + forward, -2.0, yaw)


class World:
    """A robot that drives straight ahead in a world whose axes are not the odometry's."""

    def __init__(self, speed, delay=0.0):
        self.now, self._delay, self._speed = BEGIN, delay, speed
        self.path = TruePath(self._truth, lambda: self.now)

    def _truth(self):
        gone = self._speed * (self.now - BEGIN)
        self.now += self._delay
        return {'x': gone * cos(2.0), 'y': gone * sin(2.0), 'yaw': 2.0, 'mode': 'SAFE'}

    def seen(self, until):
        """Query it every 20 ms until a time; return its path."""
        while self.now < until:
            self.path.look()
            self.now += 0.02
        return self.path


def test_odometry_may_drive_on_or_stay():
    assert not jump(odometry(BEGIN), odometry(BEGIN + SLOT, 0.007))
    assert not jump(odometry(BEGIN), odometry(LATE, STEP - 0.001, TURN - 0.001))


@pytest.mark.parametrize('after', [
    odometry(BEGIN + SLOT, 0.5), odometry(BEGIN + SLOT, yaw=1.0), odometry(LATE, STEP + 0.001),
    odometry(LATE, yaw=TURN + 0.001)])
@pytest.mark.parametrize('speed', [None, 0.0, -0.01])
def test_a_jump_is_found(after, speed):
    path = None if speed is None else World(speed).seen(LATE)
    assert jump(odometry(BEGIN), after, path).startswith('odom: ')


def test_after_a_gap_the_odometry_may_be_where_the_robot_is():
    path = World(0.3).seen(LATE)
    gone = 0.3 * (LATE - BEGIN)
    assert not jump(odometry(BEGIN), odometry(LATE, gone), path)
    for wrong in (gone + STEP + 0.002, -gone, gone / 2 - STEP):
        found = jump(odometry(BEGIN), odometry(LATE, wrong), path)
        assert bool(found) == (abs(wrong) > STEP), found
    assert 'the robot: 0.120 m ahead' in jump(odometry(BEGIN), odometry(LATE, 0.2), path)


def test_a_step_is_compared_in_the_frame_of_its_first_pose():
    path = World(0.3).seen(LATE)
    gone = 0.3 * (LATE - BEGIN)
    assert jump(odometry(BEGIN, yaw=pi / 2), odometry(LATE, gone, yaw=pi / 2), path)


@pytest.mark.parametrize('begin', [BEGIN - 1, BEGIN])
def test_a_pose_that_was_not_queried_in_time_is_not_known(begin):
    slow = World(0.3, delay=2 * PROMPT).seen(LATE)
    late = World(0.3).seen(LATE)
    gone = odometry(LATE, 0.12)
    assert 'not known' in jump(odometry(begin), gone, slow)
    assert ('not known' in jump(odometry(begin), gone, late)) == (begin < BEGIN)


def test_stamps_must_rise():
    assert 'do not rise' in jump(odometry(BEGIN), odometry(BEGIN))
