# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the driver does when something is wrong with line or robot, in memory."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Severity
from create_oi_ros.driver.mode import CLEAR_TIME
from create_oi_ros.driver.outbox import DEAD_MAN_STOP
from support.loop import Loop, said

# What cannot be.


def test_an_impossible_jump_is_dropped_and_counted():
    loop = Loop()
    loop.run(1)
    before = loop.estimate
    forged = loop.driver.plan.full
    values = [0] * len(forged.packets)
    values[forged.names.index('distance')] = 4000
    values[forged.names.index('oi_mode')] = oi.Mode.SAFE
    loop.driver.receive(forged.pack_frame(values), loop.now)
    loop.run(0.1)
    assert loop.driver.counts.impossible_jumps == 1
    assert loop.estimate.x == pytest.approx(before.x, abs=1e-6)


# A driver that was stopped.


def test_after_a_standstill_what_came_long_ago_is_dropped_and_the_robot_called_anew():
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    frames = len(loop.moved)
    stale = loop.driver.plan.short.pack_frame([0] * len(loop.driver.plan.short.packets))
    loop.robot.receive(DEAD_MAN_STOP, loop.now)
    loop.cut, receive, poll = True, loop.driver.receive, loop.driver.poll
    loop.driver.poll = lambda now: None
    loop.run(5.0)
    loop.cut, loop.driver.poll = False, poll
    receive(stale * 60, loop.now)
    assert len(loop.moved) == frames
    loop.run(2.0)
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.01)
    assert said(loop, Severity.WARNING, 'stood still for 5.0 s') == 1
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.driver.state.answered
    assert loop.body.truth().speed == 0


def test_a_robot_that_cannot_enter_its_mode_at_first_is_not_pestered_and_may_later():
    loop = Loop()
    loop.body.plug_charger(True)
    loop.run(2.0)
    assert loop.driver.status.reason == 'charger powered'
    assert loop.robot.mode is oi.Mode.PASSIVE
    assert sum(isinstance(each, oi.Safe) for each in loop.commands()) <= 2
    loop.body.plug_charger(False)
    loop.run(CLEAR_TIME + 1.0)
    loop.drive(0.2, 0.0, 0.5)
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.body.truth().speed > 0
