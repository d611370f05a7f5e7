# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity commands, byte for byte: followed, limited, refused, too old."""

from dataclasses import replace
from itertools import pairwise

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings, Severity, wheel_speeds
from create_oi_ros.driver.goals import Code
from create_oi_ros.driver.motion import next_speeds, rounded, STOPPED
from create_oi_ros.driver.state import Activity
from create_oi_ros.oi.commands import WheelSpeeds
from support.goals import met, moving
from support.loop import AT_ONCE, Loop, texts

TIMEOUT = MotionLimits.timeout


def drives(loop):
    """Return what the robot was told of its wheels since the last time."""
    return [command for command in loop.commands() if isinstance(command, oi.DriveDirect)]


def test_a_command_before_the_robot_answers_moves_nothing_later():
    loop = Loop()
    loop.cut = True
    loop.run(1.0)
    loop.driver.drive(0.2, 0.0, loop.now)
    loop.cut = False
    loop.run(0.4)
    assert loop.driver.state.answered
    assert loop.body.truth().speed == 0
    assert not texts(loop.notices, Severity.WARNING)


def test_the_wheels_stop_when_commands_stop(loop):
    loop.driver.set_limits(AT_ONCE)
    loop.driver.drive(0.2, 0.0, loop.now)
    loop.run(TIMEOUT - 0.01)
    assert drives(loop) == [oi.DriveDirect(right=200, left=200)]
    loop.run(0.03)
    assert drives(loop) == [oi.DriveDirect(right=0, left=0)]


@pytest.mark.parametrize('velocity', [(5e-324, 0.0), (0.1, -9e-301)])
def test_a_speed_that_is_a_whole_number_by_mistake_is_hinted_at_once(loop, velocity):
    for sent in ((0.2, 0.0), (0.0, 5.55e-17), (-1e-6, 1.1e-300), velocity, velocity):
        loop.driver.drive(*sent, loop.now)
    loop.run(0.05)
    hint, = texts(loop.notices, Severity.WARNING)
    assert 'did the sender write 1 for 1.0?' in hint


@pytest.mark.parametrize('acceleration', [0.01, 0.5])
def test_acceleration_is_limited_up_and_down_and_the_curve_is_kept(acceleration):
    loop = Loop(Settings(limits=MotionLimits(linear_acceleration=acceleration)))
    loop.run(0.3)
    drives(loop)
    loop.drive(0.2, 0.4, 0.3)
    sent = drives(loop)
    assert sent[-1].right + sent[-1].left == pytest.approx(2000 * acceleration * 0.3, abs=20)
    for each in sent[len(sent) // 2:]:
        assert each.right == pytest.approx(each.left * 251.6 / 148.4, abs=1.5)
    loop.drive(0.2, 0.4, 0.3)
    loop.drive(0.0, 0.0, 0.1)
    assert drives(loop)[-1].right > 0


def test_stop_and_the_end_of_commands_know_no_acceleration_limit():
    loop = Loop(Settings(limits=MotionLimits(linear_acceleration=0.2)))
    loop.run(0.3)
    for end in (lambda: loop.driver.stop(loop.now), lambda: loop.run(TIMEOUT)):
        loop.drive(0.2, 0.0, 0.5)
        assert drives(loop)[-1].right > 50
        end()
        loop.run(0.02)
        assert drives(loop)[-1] == oi.DriveDirect(right=0, left=0)


def test_a_robot_that_somebody_else_stopped_starts_from_rest():
    loop = Loop(Settings(limits=MotionLimits(linear_acceleration=0.5)))
    loop.run(0.3)
    loop.drive(0.3, 0.0, 1.0)
    drives(loop)
    loop.robot.receive(oi.DriveDirect(right=0, left=0).encode(), loop.now)
    loop.drive(0.3, 0.0, 0.3)
    assert drives(loop)[0].right < 50
    loop.drive(0.3, 0.0, 1.0)
    assert drives(loop)[-1].right == 300


# Beside a goal.


@pytest.mark.parametrize('velocity', [
    (0.1, 0.0), (0.0, 0.1), (-0.1, 0.0), (0.0, -0.1), (0.1, 0.1), (-0.1, -0.1), (1.0, 1.0)])
def test_any_velocity_but_zero_takes_over_from_a_goal(velocity):
    loop = met()
    running = moving(loop)
    loop.commands()
    loop.driver.drive(*velocity, loop.now)
    assert running.code is Code.SUPERSEDED
    assert loop.driver.state.activity is Activity.DRIVING
    loop.turn()
    halt, first, *_ = drives(loop)
    assert halt == oi.DriveDirect(right=0, left=0)
    assert abs(first.right) < 100 and abs(first.left) < 100, 'from rest'


@pytest.mark.parametrize(('interrupt', 'velocity'), [
    (True, (0.0, -0.0)), (False, (0.0, 0.0)), (False, (0.1, 0.0)), (False, (0.0, 0.1))])
def test_zero_does_not_end_a_goal_and_nothing_does_where_that_is_not_wanted(interrupt, velocity):
    loop = met(MotionLimits(commands_interrupt=interrupt))
    running = moving(loop)
    loop.driver.drive(*velocity, loop.now)
    loop.run(0.1)
    assert running.outcome is None
    assert loop.driver.state.activity is Activity.GOAL
    assert loop.robot.actuators.wheels == (300, 300)


# Refused.


def drive_all_the_time(loop: Loop, seconds: float) -> None:
    """Command a velocity in each turn of the loop."""
    until = loop.now + seconds
    while loop.now < until:
        loop.driver.drive(0.1, 0.0, loop.now)
        loop.turn()


def test_a_robot_that_is_found_or_enters_a_mode_under_commands_drives_without_a_warning():
    loop = Loop()
    drive_all_the_time(loop, 1.0)
    loop.driver.modes.set(oi.Mode.FULL, loop.now)
    drive_all_the_time(loop, 0.5)
    assert loop.driver.scripts.play(loop.now, force=True).outcome is not None  # refused: it drives
    assert loop.body.truth().speed == pytest.approx(0.1, abs=0.01)
    assert texts(loop.notices, Severity.WARNING) == []


def test_a_mode_that_does_not_come_is_a_warning_after_all():
    loop = Loop()
    loop.body.drop(left=True)
    drive_all_the_time(loop, 1.0)
    said, = texts(loop.notices, Severity.WARNING)
    assert said.startswith('not driving: robot is in PASSIVE (left wheel dropped)')


@pytest.mark.parametrize('velocity', [(0.1, 0.0), (0.0, 0.0)])
def test_a_robot_that_cannot_drive_is_sent_no_speeds(velocity):
    loop = Loop(Settings(mode_on_start=oi.Mode.PASSIVE))
    loop.run(0.5)
    drives(loop)
    loop.drive(*velocity, 0.5)
    assert drives(loop) == []


def test_with_bump_stop_no_command_drives_further_into_an_obstacle():
    loop = met(replace(AT_ONCE, bump_stop=True))
    loop.drive(0.2, 0.0, 0.5)
    loop.body.force(bump_left=1)
    loop.drive(0.2, 0.5, 0.3)
    right, left = loop.robot.actuators.wheels
    assert right == -left > 0, 'it may turn away'
    loop.drive(-0.1, 0.0, 0.3)
    assert loop.robot.actuators.wheels == (-100, -100)
    loop.drive(-0.1, 0.5, 0.3)
    right, left = loop.robot.actuators.wheels
    assert right + left == pytest.approx(-200, abs=2)
    loop.body.unforce()
    loop.drive(0.2, 0.0, 0.3)
    assert loop.robot.actuators.wheels == (200, 200)


# The sums, figure by figure.


FREE = MotionLimits(wheel_separation=0.25, linear_acceleration=0.0, angular_acceleration=0.0)
RAMPED = MotionLimits(wheel_separation=0.25, linear_acceleration=1.0, angular_acceleration=4.0)


@pytest.mark.parametrize(('linear', 'angular', 'right', 'left'), [
    (0.25, 0.0, 250, 250), (-0.25, 0.0, -250, -250), (0.0, 1.0, 125, -125), (0.0, -1.0, -125, 125),
    (0.25, 1.0, 375, 125), (-0.25, 1.0, -125, -375), (0.25, 2.0, 500, 0), (0.0, 0.0, 0, 0),
    (0.5, 0.0, 500, 500), (1.0, 0.0, 500, 500), (0.5, 4.0, 500, 0), (0.5, -4.0, 0, 500),
    (-1.0, 8.0, 0, -500), (1e308, 0.0, 500, 500), (5e-324, 0.0, 0, 0)])
def test_a_velocity_becomes_wheel_speeds_and_one_that_is_too_fast_keeps_its_curve(
        linear: float, angular: float, right: float, left: float) -> None:
    assert wheel_speeds(linear, angular, FREE) == pytest.approx((right, left), abs=1e-9)


@pytest.mark.parametrize(('wanted', 'after'), [
    ((500, 500), (31.25, 31.25)), ((-500, -500), (-31.25, -31.25)),
    ((200, -200), (15.625, -15.625)), ((-200, 200), (-15.625, 15.625)),
    ((500, 250), (31.25 * 4 / 3, 31.25 * 2 / 3)), ((30, 30), (30, 30)), ((15, -15), (15, -15)),
    ((0, 0), (0, 0))])
def test_wheels_are_accelerated_by_the_tighter_limit_and_the_curve_is_kept(
        wanted: tuple[float, float], after: tuple[float, float]) -> None:
    found = next_speeds(STOPPED, WheelSpeeds(*wanted), 1 / 32, RAMPED)
    assert found == pytest.approx(after)


@pytest.mark.parametrize('linear', [*(step / 1000 for step in range(-600, 601, 120)), 0.1, 0.037])
def test_rounding_to_whole_millimetres_keeps_the_turn_and_the_limit(linear) -> None:
    limits = MotionLimits()
    for angular in (*(step / 1000 for step in range(-4000, 4001, 173)), 0.0116):
        speeds = wheel_speeds(linear, angular, limits)
        right, left = rounded(speeds)
        assert max(abs(right), abs(left)) <= 500
        assert abs((right + left) / 2 - (speeds.right + speeds.left) / 2) <= 0.5 + 1e-9
        asked = (speeds.right - speeds.left) / limits.wheel_separation / 1000
        if linear:
            assert abs((right - left) / limits.wheel_separation / 1000 - asked) < 0.00195
        else:
            assert right == -left, 'it creeps'
            assert abs(right - speeds.right) <= 0.5


def test_a_robot_is_told_at_most_once_a_slot_but_a_stop_does_not_wait(loop):
    loop.driver.set_limits(AT_ONCE)
    told = []
    for step in range(40):
        loop.driver.drive(0.1 + step / 1000, 0.0, loop.now)
        loop.turn()
        told += [loop.now for _ in drives(loop)]
    assert min(b - a for a, b in pairwise(told)) >= oi.SLOT - 1e-6
    assert len(told) >= 10
    loop.run(oi.SLOT)
    assert loop.robot.actuators.wheels == (139, 139), 'the newest command wins'
    loop.driver.drive(0.3, 0.0, loop.now)
    loop.driver.stop(loop.now)
    loop.turn()
    assert drives(loop)[-1] == oi.DriveDirect(right=0, left=0)


@pytest.mark.parametrize('speed', [0.25, 0.0])
def test_speeds_that_the_robot_did_not_take_in_time_are_sent_again(loop, speed):
    loop.driver.set_limits(AT_ONCE)
    told = []
    loop.drive(0.25 - speed, 0.0, 0.3)
    drives(loop)
    hear, loop.robot.receive = loop.robot.receive, lambda *_: None
    for _ in range(44):
        loop.driver.drive(speed, 0.0, loop.now)
        loop.turn()
        told += [loop.now for _ in drives(loop)]
    assert [b - a for a, b in pairwise(told)] == pytest.approx([0.155], abs=2 * oi.SLOT)
    loop.robot.receive = hear
    loop.drive(speed, 0.0, 1.0)
    assert loop.robot.actuators.wheels == (1000 * speed, 1000 * speed)
