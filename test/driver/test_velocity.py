# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity commands, byte for byte: followed, limited, refused, too old."""

from dataclasses import replace
from math import inf, nan

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings, Severity, wheel_speeds
from create_oi_ros.driver.goals import Code
from create_oi_ros.driver.state import Activity
from support.goals import angle, met, moving, pursue
from support.loop import AT_ONCE, Loop, texts

TIMEOUT = MotionLimits.timeout


def drives(loop):
    """Return what the robot was told of its wheels since the last time."""
    return [command for command in loop.commands() if isinstance(command, oi.DriveDirect)]


def test_a_velocity_becomes_drive_direct_right_wheel_first(at_once):
    loop = at_once
    loop.driver.drive(0.2, 1.0, loop.now)
    loop.run(0.05)
    assert loop.commands() == [oi.DriveDirect(right=329, left=71)]


def test_an_unchanged_velocity_is_sent_once(at_once):
    loop = at_once
    loop.drive(0.1, 0.0, 1.0)
    assert drives(loop) == [oi.DriveDirect(right=100, left=100)]


def test_commands_faster_than_the_robot_listens_are_thinned_and_the_newest_wins(loop):
    for step in range(1, 101):
        loop.driver.drive(step / 1000, 0.0, loop.now)
        loop.turn()
    loop.run(0.05)
    sent = loop.commands()
    assert sent[-1] == oi.DriveDirect(right=100, left=100)
    assert len(sent) <= 100 * 0.005 / oi.SLOT + 2


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


def test_the_wheels_stop_when_commands_stop(at_once):
    loop = at_once
    loop.driver.drive(0.2, 0.0, loop.now)
    loop.run(TIMEOUT - 0.01)
    assert drives(loop) == [oi.DriveDirect(right=200, left=200)]
    loop.run(0.03)
    assert drives(loop) == [oi.DriveDirect(right=0, left=0)]


def test_stop_stops_at_once(loop):
    loop.drive(0.2, 0.0, 0.2)
    loop.commands()
    assert loop.driver.stop(loop.now).outcome.ok
    loop.turn()
    assert loop.commands()[0] == oi.DriveDirect(right=0, left=0)


@pytest.mark.parametrize('velocity', [(5e-324, 0.0), (0.1, -9e-7)])
def test_a_speed_that_is_next_to_nothing_is_hinted_at_once(loop, velocity):
    for sent in ((0.2, 0.0), (0.0, 1e-6), velocity, velocity):
        loop.driver.drive(*sent, loop.now)
    loop.run(0.05)
    hint, = texts(loop.notices, Severity.WARNING)
    assert 'did the sender write 1 for 1.0?' in hint


@pytest.mark.parametrize('velocity', [(nan, 0.0), (0.1, nan), (inf, 0.0), (0.0, -inf)])
def test_a_velocity_that_is_not_finite_is_refused_and_stops(loop, velocity):
    loop.drive(0.2, 0.0, 0.2)
    loop.commands()
    loop.driver.drive(*velocity, loop.now)
    loop.run(0.05)
    assert loop.commands() == [oi.DriveDirect(right=0, left=0)]
    assert 'not finite' in texts(loop.notices, Severity.WARNING)[-1]


def test_velocities_that_are_not_finite_are_reported_once_and_counted(loop):
    for _ in range(50):
        loop.driver.drive(nan, 0.0, loop.now)
        loop.turn()
    assert len(texts(loop.notices, Severity.WARNING)) == 1
    loop.drive(0.1, 0.0, 0.1)
    assert texts(loop.notices, Severity.WARNING)[1:] == [
        'velocities are finite again; before, 49 more than the first were not']


@given(st.floats(-3, 3), st.floats(-20, 20))
def test_limits_keep_the_curve(linear, angular):
    limits = MotionLimits()
    right, left = wheel_speeds(linear, angular, limits)
    assert max(abs(right), abs(left)) <= 500 + 1e-9
    free = MotionLimits(max_wheel_speed=1e9)
    free_right, free_left = wheel_speeds(linear, angular, free)
    fastest = max(abs(free_right), abs(free_left))
    scale = min(1.0, 500 / fastest) if fastest else 1.0
    assert right == pytest.approx(free_right * scale, abs=1.0)
    assert left == pytest.approx(free_left * scale, abs=1.0)


def test_limits_may_change_while_the_robot_drives(loop):
    loop.drive(0.2, 0.0, 0.5)
    loop.driver.set_limits(MotionLimits(max_wheel_speed=0.1))
    loop.drive(0.2, 0.0, 0.5)
    assert drives(loop)[-1] == oi.DriveDirect(right=100, left=100)


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


def test_turning_acceleration_is_limited():
    loop = Loop(Settings(limits=MotionLimits(angular_acceleration=1.0)))
    loop.run(0.3)
    drives(loop)
    loop.drive(0.0, 2.0, 0.5)
    last = drives(loop)[-1]
    assert (last.right - last.left) / 258 == pytest.approx(0.5, abs=0.05)


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
    assert running.ending.code is Code.SUPERSEDED
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
    assert running.ending is None
    assert loop.driver.state.activity is Activity.GOAL
    assert loop.robot.actuators.wheels == (300, 300)


# Refused.


def test_the_first_refusal_is_reported_and_the_next_ones_are_not():
    loop = Loop(Settings(mode_on_start=oi.Mode.PASSIVE))
    loop.run(0.5)
    loop.drive(0.1, 0.0, 0.5)
    said, = texts(loop.notices, Severity.WARNING)
    assert said.startswith('not driving: robot is in PASSIVE')


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
    assert loop.driver.scripts.show(loop.now).outcome is not None  # refused: the robot drives
    assert loop.body.truth().speed == pytest.approx(0.1, abs=0.01)
    assert texts(loop.notices, Severity.WARNING) == []


def test_a_goal_for_a_robot_that_enters_its_mode_waits_for_it():
    loop = Loop()
    while not loop.driver.state.answered:
        loop.turn()
    assert pursue(loop, angle(10)).code is Code.NONE


def test_commands_while_the_stored_script_is_read_are_no_warning(loop):
    shown = loop.driver.scripts.show(loop.now)
    drive_all_the_time(loop, 1.0)
    assert shown.outcome is not None
    assert loop.body.truth().speed > 0
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


def test_a_robot_that_plays_a_script_is_sent_only_the_stops_that_ask_for_its_end(loop):
    loop.driver.scripts.define(oi.Script(script=oi.WaitTime(time=20).encode()))
    loop.driver.scripts.play(loop.now, force=False)
    loop.run(0.2)
    drives(loop)
    loop.drive(0.1, 0.0, 0.5)
    assert set(drives(loop)) == {oi.DriveDirect(right=0, left=0)}


@pytest.mark.parametrize(('count', 'more'), [
    (1, []), (2, ['velocities are finite again; before, 1 more than the first were not'])])
def test_the_first_velocity_that_is_not_finite_is_not_counted_again(loop, count, more):
    for _ in range(count):
        loop.driver.drive(0.1, inf, loop.now)
    loop.drive(0.1, 0.0, 0.1)
    assert texts(loop.notices, Severity.WARNING)[1:] == more


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


def test_without_bump_stop_the_bumper_holds_nothing_back():
    loop = met()
    loop.body.force(bump_left=1)
    loop.drive(0.2, 0.0, 0.5)
    assert loop.robot.actuators.wheels == (200, 200)
