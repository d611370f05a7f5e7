# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals that a bumper, a cliff, a wheel that drops or a stall ends."""

from dataclasses import replace

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits
from create_oi_ros.driver.goals import Code
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY
from support.goals import (
    angle,
    arc,
    distance,
    ended,
    met,
    moving,
    place,
    pursue,
    start,
    until_ended,
)
from support.loop import Loop


@pytest.mark.parametrize(('happens', 'code', 'where', 'what_to_do'), [
    (lambda body: body.force(bump_left=1), Code.BUMP, 'on the left', 'drive backwards'),
    (lambda body: body.force(bump_right=1), Code.BUMP, 'on the right', 'drive backwards'),
    (lambda body: body.force(bump_left=1, bump_right=1), Code.BUMP, 'in front', 'drive backwards'),
    (lambda body: body.lift(True), Code.WHEEL_DROP, '', 'put the robot on the floor')],
    ids=['left', 'right', 'front', 'lifted'])
@pytest.mark.parametrize('make', [
    lambda: distance(1.0), lambda: angle(300), lambda: arc(90, 0.5), lambda: place(1.0, 0.0)])
def test_a_bump_and_a_wheel_that_drops_end_every_motion(make, happens, code, where, what_to_do):
    loop = met()
    running = moving(loop, make())
    happens(loop.body)
    ending = ended(loop, running)
    assert ending.code is code
    assert where in ending.text and what_to_do in ending.text


def test_a_pressed_bumper_lets_no_distance_begin_but_backwards_and_turns():
    loop = met()
    loop.body.force(bump_left=1)
    loop.run(0.1)
    assert pursue(loop, distance(0.2)).code is Code.BUMP
    assert loop.body.truth().travelled == 0
    assert pursue(loop, place(-0.3, 0.0)).code is Code.BUMP  # it turns, then drives ahead
    assert pursue(loop, angle(20)).code is Code.NONE
    assert pursue(loop, distance(-0.2)).code is Code.NONE


def test_a_bumper_that_is_pressed_again_while_the_robot_backs_off_ends_that():
    loop = met()
    loop.body.force(bump_left=1)
    loop.run(0.1)
    running = moving(loop, distance(-1.0))
    loop.body.unforce()
    loop.run(0.1)
    loop.body.force(bump_right=1)
    assert ended(loop, running).code is Code.BUMP


@pytest.mark.parametrize('mode', [oi.Mode.SAFE, oi.Mode.FULL])
def test_a_cliff_ends_a_motion_and_says_where(mode):
    loop = met()
    loop.driver.modes.set(mode, loop.now)
    loop.run(0.2)
    running = moving(loop)
    loop.body.force(cliff_front_left=1)
    ending = ended(loop, running)
    assert ending.code is Code.CLIFF
    assert 'front left' in ending.text


def test_at_a_cliff_in_full_mode_only_the_way_back_is_open():
    loop = met()
    loop.driver.modes.set(oi.Mode.FULL, loop.now)
    loop.run(0.2)
    loop.body.force(cliff_right=1)
    loop.run(0.1)
    assert pursue(loop, distance(0.1)).code is Code.CLIFF
    assert pursue(loop, angle(30)).code is Code.CLIFF
    assert pursue(loop, distance(-0.1)).code is Code.NONE


def test_safe_mode_itself_may_end_a_way_back_at_a_cliff():
    loop = met()
    loop.body.force(cliff_left=1)
    loop.run(0.1)
    ending = pursue(loop, arc(90, 0.1, direction=-1))
    assert ending.code is Code.CLIFF
    assert 'robot left SAFE (cliff left)' in ending.text
    assert 'call set_mode with SAFE, then drive backwards' in ending.text


@pytest.mark.parametrize('speed', [0.11, 0.2, 0.3])
def test_wheels_that_do_not_follow_stall_even_if_no_current_shows_it(speed):
    """Also where readings in a row would tell the rounding, which standing wheels do not."""
    loop = met()
    running = moving(loop, distance(5.0, speed))
    loop.body.hold(right=True, left=True)
    loop.body.force(overcurrent_right_wheel=0, overcurrent_left_wheel=0)
    ending = until_ended(loop, running)
    assert ending.code is Code.STALL
    assert 'do not follow' in ending.text
    assert loop.robot.actuators.wheels == (0, 0)


@pytest.mark.parametrize('most', [0.0, 0.0004])
def test_a_robot_that_may_not_turn_its_wheels_says_so(most):
    for goal in (distance(0.1), angle(10)):
        ending = pursue(met(MotionLimits(max_wheel_speed=most)), goal)
        assert ending.code is Code.STALL
        assert 'max_wheel_speed is 0' in ending.text


def test_low_side_drivers_that_draw_too_much_stop_no_wheels():
    loop = met()
    loop.body.force(overcurrent_ld0=1, overcurrent_ld1=1, overcurrent_ld2=1)
    assert pursue(loop, distance(0.3)).code is Code.NONE


@pytest.mark.parametrize('wheel', ['overcurrent_left_wheel', 'overcurrent_right_wheel'])
def test_a_wheel_that_draws_too_much_for_half_a_second_is_held(wheel):
    loop = met()
    running = moving(loop, distance(9.0))
    for _ in range(2):
        loop.body.force(seconds=0.45, **{wheel: 1})
        loop.run(0.6)
        assert running.outcome is None
    loop.body.force(**{wheel: 1})
    loop.run(0.55)
    assert running.code is Code.STALL


@pytest.mark.parametrize('make', [
    lambda: distance(0.7), lambda: angle(120, 1.0), lambda: arc(90, 0.3), lambda: place(0.5, 0.2),
    lambda: distance(-0.6)], ids=['distance', 'angle', 'arc', 'place', 'back'])
@pytest.mark.parametrize('limits', [
    MotionLimits(max_wheel_speed=0.03), MotionLimits(max_wheel_speed=0.012),
    MotionLimits(linear_acceleration=0.01, angular_acceleration=0.05)],
    ids=['slow', 'slower', 'lazy'])
def test_a_robot_that_is_made_slow_while_a_goal_runs_is_not_taken_for_a_held_one(make, limits):
    loop = met()
    running = start(loop, make())
    loop.run(0.4)
    loop.driver.set_limits(limits)
    running.allowance = 400.0
    loop.run(20.0)
    assert running.outcome is None or running.code is Code.NONE, running.outcome


@pytest.mark.parametrize('rounding', list(Rounding))
@pytest.mark.parametrize('make', [
    lambda: distance(0.5, 0.013), lambda: angle(100, 0.05), lambda: angle(-100, 0.012)])
def test_a_slow_goal_is_not_taken_for_a_held_robot(make, rounding):
    loop = Loop(rounding=rounding)
    loop.run(1.0)
    running = start(loop, make())
    loop.run(30.0)
    assert running.outcome is None or running.code is Code.NONE, running.outcome


def test_a_robot_with_half_the_speed_is_not_taken_for_a_held_one():
    loop = met(config=replace(DEFAULT_BODY, right_speed_gain=0.45, left_speed_gain=0.45))
    assert pursue(loop, distance(0.6, 0.2)).code is Code.NONE
