# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What people are told of a robot that has become known."""

from dataclasses import replace

import pytest

from create_oi_ros.driver import Notice
from create_oi_ros.driver.acquaintance import Acquaintance, described, EVERY
from create_oi_ros.driver.events import EventQueue
from create_oi_ros.odometry import Family, Knowledge, Known, SignSource
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.dead_band import DeadBand
from create_oi_ros.odometry.knowledge import learned
from create_oi_ros.robot import Rounding


def robot(rounding: Rounding = Rounding.TRUNCATE) -> Knowledge:
    """Return what is known of a robot with springs for wheels."""
    sure = Known(0.0, 0.0001)
    return replace(
        learned(Assumptions.all(), DeadBand()), frame_period=Known(0.01525, 1e-6),
        rounding={each: float(each is rounding) for each in Rounding},
        encoder_sign={each: float(each is SignSource.DRIVE) for each in SignSource},
        response={Family.LAG: 0.0, Family.SPRING: 1.0}, right_gain=replace_value(sure, 0.98),
        left_gain=replace_value(sure, 1.02), time_constant=replace_value(sure, 0.15),
        slow_part=sure, fast_part=sure, dead_time=replace_value(sure, 0.05),
        inverse_acceleration=None, damping=replace_value(sure, 0.36), correlations=())


def replace_value(known: Known, value: float) -> Known:
    """Return a number that is as sure."""
    return known._replace(value=value)


def test_a_robot_is_described_in_a_line() -> None:
    assert described(robot()) == (
        'fractions are cut off, encoders take the sign of the drive, wheels run at 0.980 (right) '
        'and 1.020 (left) of the speed asked, 200 ms late at 0.2 m/s and overshoot by 30 %; a '
        'frame lasts 15.25 ms')
    lag = replace(robot(), damping=None, inverse_acceleration=Known(0.0, 0.0001),
                  response={Family.LAG: 1.0, Family.SPRING: 0.0})
    assert 'overshoot' not in described(lag)


def test_people_are_told_once_and_again_of_another_robot() -> None:
    events = EventQueue()
    watch = Acquaintance(None, events)
    for known in (None, replace(robot(), right_gain=Known(1.0, 0.1)), robot(), robot(),
                  robot(Rounding.ROUND)):
        watch.look(known)
    first, second = (each.text for each in events if isinstance(each, Notice))
    assert first.startswith('the odometry knows this robot now: fractions are cut off')
    assert second.startswith('this is another robot than odometry_model says; the odometry has '
                             'learned: fractions are rounded')


@pytest.mark.parametrize('rounding', [Rounding.TRUNCATE, Rounding.CARRY])
def test_of_a_robot_that_was_known_before_nobody_is_told(rounding: Rounding) -> None:
    events = EventQueue()
    Acquaintance(robot(rounding), events).look(robot())
    assert bool(events) is (rounding is not Rounding.TRUNCATE)


def test_it_looks_from_time_to_time() -> None:
    watch = Acquaintance(None, EventQueue())
    assert [watch.due(now) for now in (3.0, 3.0 + EVERY - 0.1, 3.0 + EVERY)] == [
        True, False, True]
