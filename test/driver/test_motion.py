# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which bytes velocity commands become, figure by figure; times are binary fractions, so exact."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, ModeStatus, MotionLimits, Settings, wheel_speeds
from create_oi_ros.driver.core import Core
from create_oi_ros.driver.mode import Modes
from create_oi_ros.driver.motion import (
    Motion,
    next_speeds,
    RAMP_STEP,
    REPORT_TIMEOUT,
    rounded,
    STOPPED,
    without_forward,
)
from create_oi_ros.driver.outputs import Outputs
from create_oi_ros.driver.state import StateEvent
from create_oi_ros.oi.commands import WheelSpeeds
from support.loop import AT_ONCE

FREE = MotionLimits(
    wheel_separation=0.25, linear_acceleration=0.0, angular_acceleration=0.0)
RAMPED = MotionLimits(wheel_separation=0.25, linear_acceleration=1.0, angular_acceleration=4.0)
HALT = oi.DriveDirect(right=0, left=0)
SLOT = 0.015


class Wheels(Motion):
    """The motion of a robot that obeys."""

    def __init__(self, limits: MotionLimits) -> None:
        self.core = Core(Settings(limits=limits), lambda event: self.handled(event))
        super().__init__(self.core, Modes(self.core, Outputs(self.core)))
        self.core.handle(StateEvent.OPENED)
        self.core.handle(StateEvent.ANSWERED)
        self.core.status = ModeStatus(oi.Mode.SAFE, oi.Mode.SAFE)

    def drives(self, now: float) -> bool:
        """Let time pass; return whether a velocity command holds then."""
        self.poll(now)
        return self.core.state.activity is Activity.DRIVING


def report(wheels: Wheels, right: int, left: int, now: float, bumps: int = 0) -> None:
    """Let the robot report the speeds that it was asked for, and its bumper."""
    wheels.observe(oi.Readings({
        'requested_right_velocity': right, 'requested_left_velocity': left,
        'bumps_and_wheel_drops': bumps}), now)


def commanded(linear: float, angular: float, limits: MotionLimits = AT_ONCE) -> Wheels:
    """Return wheels that a velocity was commanded to at second 8, and have been told."""
    wheels = Wheels(limits)
    assert wheels.follow(linear, angular, 8.0) == bool(linear or angular)
    wheels.next_drive(8.0)
    return wheels


def straight(speed: int) -> oi.DriveDirect:
    """Return the command for both wheels, mm/s."""
    return oi.DriveDirect(right=speed, left=speed)


# From velocities to wheels.


@pytest.mark.parametrize(('linear', 'angular', 'right', 'left'), [
    (0.25, 0.0, 250, 250), (-0.25, 0.0, -250, -250), (0.0, 1.0, 125, -125), (0.0, -1.0, -125, 125),
    (0.25, 1.0, 375, 125), (-0.25, 1.0, -125, -375), (0.25, 2.0, 500, 0), (0.0, 0.0, 0, 0),
    (0.5, 0.0, 500, 500), (1.0, 0.0, 500, 500), (0.5, 4.0, 500, 0), (0.5, -4.0, 0, 500),
    (-1.0, 8.0, 0, -500), (1e308, 0.0, 500, 500), (5e-324, 0.0, 0, 0)])
def test_a_velocity_becomes_wheel_speeds_and_one_that_is_too_fast_keeps_its_curve(
        linear: float, angular: float, right: float, left: float) -> None:
    assert wheel_speeds(linear, angular, FREE) == pytest.approx((right, left), abs=1e-9)


def test_the_default_limits_are_those_of_the_pages() -> None:
    limits = MotionLimits()
    assert (limits.wheel_separation, limits.max_wheel_speed, limits.timeout) == (0.258, 0.5, 0.5)
    assert (limits.linear_acceleration, limits.angular_acceleration) == (1.0, 4.0)
    assert (limits.bump_stop, limits.commands_interrupt) == (False, True)


@pytest.mark.parametrize(('wanted', 'after'), [
    ((500, 500), (31.25, 31.25)), ((-500, -500), (-31.25, -31.25)),
    ((200, -200), (15.625, -15.625)), ((-200, 200), (-15.625, 15.625)),
    ((500, 250), (31.25 * 4 / 3, 31.25 * 2 / 3)), ((30, 30), (30, 30)), ((15, -15), (15, -15)),
    ((0, 0), (0, 0))])
def test_wheels_are_accelerated_by_the_tighter_limit_and_the_curve_is_kept(
        wanted: tuple[float, float], after: tuple[float, float]) -> None:
    found = next_speeds(STOPPED, WheelSpeeds(*wanted), 1 / 32, RAMPED)
    assert found == pytest.approx(after)


def test_wheels_are_slowed_from_the_speeds_that_they_have() -> None:
    found = next_speeds(WheelSpeeds(300, 100), WheelSpeeds(100, 100), 1 / 32, RAMPED)
    assert found == pytest.approx((268.75, 100)), 'by turning: 800 mm/s, of 4 rad/s²'
    found = next_speeds(WheelSpeeds(300, 300), STOPPED, 1 / 32, RAMPED)
    assert found == pytest.approx((268.75, 268.75))


@pytest.mark.parametrize(('linear', 'angular', 'after'), [
    (0.0, 4.0, (15.625, -15.625)), (1.0, 0.0, (200, -200))])
def test_without_one_limit_the_other_holds(
        linear: float, angular: float, after: tuple[float, float]) -> None:
    limits = MotionLimits(
        wheel_separation=0.25, linear_acceleration=linear, angular_acceleration=angular)
    assert next_speeds(STOPPED, WheelSpeeds(200, -200), 1 / 32, limits) == pytest.approx(after)


@pytest.mark.parametrize(('speeds', 'left_of_it'), [
    ((200, 200), (0, 0)), ((300, 100), (100, -100)), ((200, -200), (200, -200)),
    ((-200, -200), (-200, -200)), ((-100, -300), (-100, -300)), ((100, -300), (100, -300)),
    ((1, 1), (0, 0)), ((1, 0), (0.5, -0.5))])
def test_what_drives_forward_is_left_out_and_what_turns_or_backs_is_kept(
        speeds: tuple[float, float], left_of_it: tuple[float, float]) -> None:
    assert without_forward(WheelSpeeds(*speeds)) == left_of_it


# Commands, one after the other.


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


def test_a_robot_is_told_once_a_slot_but_a_stop_does_not_wait() -> None:
    wheels = commanded(0.25, 0.0)
    wheels.follow(0.125, 0.0, 8.0)
    assert wheels.next_drive(8.0 + SLOT * 0.95) is None
    assert wheels.next_drive(8.0 + SLOT * 1.01) == straight(125)
    assert wheels.next_drive(9.0) is None, 'nothing new'
    wheels.follow(0.25, 0.0, 9.0)
    assert wheels.next_drive(9.0) == straight(250)
    wheels.stop()
    assert wheels.next_drive(9.001) == HALT
    assert wheels.next_drive(9.5) is None


def test_a_command_of_zero_ends_motion_once_the_wheels_have_followed_it() -> None:
    wheels = Wheels(AT_ONCE)
    wheels.command(0.25, 0.0, 8.0)
    wheels.core.outbox.take_ready()
    wheels.follow(0.0, 0.0, 8.1)
    assert wheels.core.state.activity is Activity.DRIVING
    assert not wheels.drives(8.1)
    assert wheels.core.outbox.take_ready() == HALT.encode()


def test_a_command_after_a_pause_gets_the_acceleration_of_two_slots() -> None:
    assert RAMP_STEP == 2 * SLOT
    wheels = Wheels(RAMPED)
    wheels.follow(0.5, 0.0, 8.0)
    assert wheels.next_drive(8.0) == straight(30)
    assert wheels.next_drive(8.02) == straight(50)
    assert wheels.next_drive(9.0) == straight(80)


# What the robot reports.


def test_speeds_that_the_robot_did_not_take_in_time_are_sent_again() -> None:
    assert REPORT_TIMEOUT == pytest.approx(0.15)
    wheels = commanded(0.25, 0.0)
    report(wheels, 0, 0, 8.1499)
    assert wheels.next_drive(8.1499) is None and wheels.missed_since is None, 'it may still come'
    report(wheels, 0, 0, 8.1501)
    assert wheels.missed_since == 8.0
    assert wheels.next_drive(8.16) == straight(250)
    report(wheels, 250, 0, 8.17)
    report(wheels, 250, 0, 8.4)
    assert wheels.missed_since == 8.0
    wheels.next_drive(8.7)
    report(wheels, 250, 250, 8.71)
    assert wheels.missed_since is None
    assert wheels.next_drive(9.0) is None


def test_a_stop_that_the_robot_did_not_take_is_sent_again() -> None:
    wheels = commanded(0.25, 0.0)
    wheels.stop()
    assert wheels.next_drive(8.1) == HALT
    report(wheels, 250, 250, 8.2)
    assert wheels.next_drive(8.2) is None
    report(wheels, 250, 250, 8.3)
    assert wheels.next_drive(8.3) == HALT
