# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Demos byte for byte: started, ended, and what a robot is sent before it looks for its dock."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver
from create_oi_ros.driver.state import StateEvent
from support.typed_frames import answered, heard, LAST, polled

NOW = LAST + 1.0
STOP, START, DOCK, ABORT = bytes([145, 0, 0, 0, 0]), b'\x80', bytes([136, 1]), bytes([136, 255])


def in_mode(mode: oi.Mode) -> Driver:
    """Return a driver whose robot has been in a mode for a while, as it wants."""
    driver = answered()
    driver.set_mode(mode, LAST)
    for now in (LAST + step * 0.05 for step in range(1, 20)):
        heard(driver, now, mode=mode)
        polled(driver, now)
    assert driver.status.actual is driver.status.wanted is mode
    return driver


@pytest.mark.parametrize('mode', [oi.Mode.SAFE, oi.Mode.FULL])
@pytest.mark.parametrize('goal', [False, True])
def test_a_robot_that_drives_rests_in_passive_for_a_second_before_it_looks_for_its_dock(
        mode, goal):
    driver = in_mode(mode)
    if goal:
        driver.core.handle(StateEvent.GOAL_STARTED)
        driver.demos.seek_dock()
    else:
        driver.demos.start(oi.DemoNumber.COVER_AND_DOCK)
    assert polled(driver, NOW) == STOP + START
    for now in (NOW + 0.4, NOW + 0.8, NOW + 0.98):
        heard(driver, now, mode=oi.Mode.PASSIVE)
        assert DOCK not in polled(driver, now)
    assert DOCK in polled(driver, NOW + 1.01)


@pytest.mark.parametrize('goal', [False, True])
def test_a_robot_in_passive_looks_for_it_at_once(goal):
    driver = in_mode(oi.Mode.PASSIVE)
    if goal:
        driver.core.handle(StateEvent.GOAL_STARTED)
        driver.demos.seek_dock()
    else:
        driver.demos.start(oi.DemoNumber.COVER_AND_DOCK)
    assert polled(driver, NOW) == DOCK


@pytest.mark.parametrize('demo', [each for each in oi.DemoNumber if each not in (-1, 1)])
def test_other_demos_begin_at_once(demo):
    driver = in_mode(oi.Mode.SAFE)
    assert driver.demos.start(demo).outcome is None
    assert polled(driver, NOW) == STOP + bytes([136, demo])
    assert driver.status.wanted is oi.Mode.PASSIVE


def test_to_abort_is_no_demo():
    driver = in_mode(oi.Mode.SAFE)
    assert not driver.demos.start(oi.DemoNumber.ABORT).outcome.ok
    assert polled(driver, NOW) == b''


def test_a_demo_is_ended_where_one_may_run():
    driver = in_mode(oi.Mode.SAFE)
    assert driver.demos.stop().outcome == (True, 'no demo runs: the robot obeys cmd_vel', b'')
    assert polled(driver, NOW) == b''
    driver = in_mode(oi.Mode.PASSIVE)
    assert driver.demos.stop().outcome is None
    assert polled(driver, NOW) == ABORT
