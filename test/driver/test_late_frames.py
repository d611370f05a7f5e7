# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames that come late, as on a busy computer, say what was: the driver must not act on it."""

from math import radians
from random import Random

import pytest

from create_oi_ros import oi
from create_oi_ros.sim.body.config import DEFAULT_BODY
from support.loop import Loop, turn_difference


class PausingLoop(Loop):
    """A computer that does not run at all now and then; bytes wait for it."""

    paused_until = 0.0

    def _arrived(self, line):
        return None if self.now < self.paused_until else super()._arrived(line)


@pytest.mark.parametrize('delay', [0.05, 0.2, 0.3, 0.45])
def test_a_robot_that_answers_late_is_not_said_to_have_left_its_mode(delay):
    loop = Loop()
    loop.run(3.0)
    loop.cut, loop.delay = True, delay
    loop.run(0.6)  # the driver calls again, and the robot's last frames in Safe come first
    loop.cut = False
    loop.run(4.0)
    assert loop.driver.status.actual is oi.Mode.SAFE
    assert not [notice.text for notice in loop.notices if 'robot left' in notice.text]


@pytest.mark.parametrize('seed', range(3))
def test_pauses_of_the_computer_do_not_spoil_the_odometry(seed):
    chance, loop = Random(seed), PausingLoop(config=DEFAULT_BODY, delay=0.005)
    loop.run(3.0)
    for _ in range(20):
        loop.drive(0.0, 1.0, chance.uniform(0.2, 1.8))
        loop.paused_until = loop.now + chance.uniform(0.06, 0.1)
    loop.run(3.0)
    truth = loop.body.truth().pose.yaw
    assert turn_difference(loop.estimate.yaw, truth) < radians(4)
