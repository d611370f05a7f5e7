# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals: where the robot is when they end, how it gets there, and what ends them before."""

from dataclasses import replace
from functools import partial
from math import degrees, hypot, pi
import struct

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Severity
from create_oi_ros.driver.goals import Code, DriveArc, RotateAngle
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
    reach,
    start,
    until_ended,
)
from support.loop import Loop, texts, turn_difference

loop = pytest.fixture(met)
"""A robot and a driver that have met."""
late = partial(met, delay=0.005)
"""Makes a robot on a line with a delay."""


@pytest.mark.parametrize(('metres', 'rounding'), [
    (1.0, Rounding.CARRY), (0.3, Rounding.TRUNCATE), (0.02, Rounding.ROUND),
    (-0.5, Rounding.CARRY), (-0.5, Rounding.TRUNCATE)])
def test_a_distance_is_driven(rounding, metres):
    went, turned = reach(late(rounding=rounding), distance(metres))
    assert went == pytest.approx(metres, abs=0.005 + 0.005 * abs(metres))
    assert abs(turned) < 2


@pytest.mark.parametrize(('turn', 'rounding'), [
    (90, Rounding.CARRY), (-180, Rounding.TRUNCATE), (10, Rounding.ROUND),
    (720, Rounding.CARRY), (720, Rounding.TRUNCATE)])
def test_an_angle_is_turned(rounding, turn):
    went, turned = reach(late(rounding=rounding), angle(turn))
    assert turned == pytest.approx(turn, abs=1.5 + 0.003 * abs(turn))
    assert abs(went) < 0.005


@pytest.mark.parametrize(('turn', 'direction'), [(90, 1), (-90, -1), (400, 1), (90, -1)])
def test_an_arc_is_driven_on_its_circle(turn, direction):
    loop = late()
    went, turned = reach(loop, arc(turn, 0.4, direction))
    assert turned == pytest.approx(turn, abs=2 + 0.005 * abs(turn))
    assert went == pytest.approx(direction * 0.4 * abs(turn) * pi / 180, rel=0.03)
    pose, side = loop.body.truth().pose, direction * (1 if turn > 0 else -1)
    assert hypot(pose.x, pose.y - side * 0.4) == pytest.approx(0.4, abs=0.03)


@pytest.mark.parametrize(('x', 'y', 'heading'), [
    (0.5, 0.3, 90), (-0.4, 0.0, None), (0.0, -0.6, -170), (0.0, 0.0, 45)])
def test_a_place_is_reached_with_its_heading(x, y, heading):
    loop = late()
    reach(loop, place(x, y, heading))
    pose = loop.body.truth().pose
    assert hypot(pose.x - x, pose.y - y) < 0.02
    if heading is not None:
        assert degrees(turn_difference(pose.yaw, heading * pi / 180)) < 2


def test_a_robot_that_knows_its_coast_does_not_overshoot():
    loop = late()
    for _ in range(3):
        reach(loop, distance(0.4))
    begun, furthest = loop.body.truth().travelled, 0.0
    running = start(loop, distance(0.4))
    while running.outcome is None:
        loop.turn()
        furthest = max(furthest, loop.body.truth().travelled - begun)
    assert furthest < 0.4 + 0.005


def test_unequal_wheels_still_drive_straight():
    loop = met(config=replace(DEFAULT_BODY, right_speed_gain=1.03, left_speed_gain=0.97))
    reach(loop, distance(1.0))
    assert abs(loop.body.truth().pose.y) < 0.05


def test_wheels_that_do_not_move_when_they_creep_are_told_to_creep_faster():
    loop = met(config=replace(DEFAULT_BODY, dead_band=0.045))
    went, _ = reach(loop, distance(0.03))
    assert went == pytest.approx(0.03, abs=0.01)


def test_speeds_and_accelerations_stay_within_the_limits():
    limits = MotionLimits(max_wheel_speed=0.2, linear_acceleration=0.2)
    loop = late(limits)
    loop.commands()
    ending = pursue(loop, distance(0.5, speed=0.4))
    assert ending.code is Code.NONE
    assert 'slowed to 0.20 m/s: max_translation_speed = 0.4 is beyond max_wheel_speed' in (
        ending.text)
    told = [each.right for each in loop.commands() if isinstance(each, oi.DriveDirect)]
    assert 190 < max(told) <= 200
    rises = [after - before for before, after in zip(told, told[1:]) if before >= 40]
    assert max(rises) <= 0.2 * 1000 * 0.03 + 1


def test_a_limit_that_arrives_as_float32_is_not_beyond_itself():
    speed, turn = (struct.unpack('f', struct.pack('f', each))[0] for each in (0.3, 2000 * pi))
    assert speed > 0.3 and turn > 2000 * pi
    loop = late(MotionLimits(max_wheel_speed=0.3))
    assert 'slowed' not in pursue(loop, distance(0.1, speed=speed)).text
    angle(degrees(turn))


@pytest.mark.parametrize(('goal', 'hint'), [
    (RotateAngle(90.0, 1.9, 3.0), '90 rad is 14.3 turns: degrees?'),
    (RotateAngle(-45.0, 1.9, 3.0), '-45 rad is 7.2 turns: degrees?'),
    (DriveArc(90.0, 0.2, 1, 0.3, 3.0), '90 rad is 14.3 turns: degrees?')])
def test_more_than_four_turns_are_driven_but_asked_about(goal, hint):
    loop = late()
    ending = pursue(loop, goal)
    assert ending.code is Code.TIMEOUT
    assert hint in ending.text
    assert texts(loop.notices, Severity.WARNING) == [hint]


@pytest.mark.parametrize(('goal', 'name'), [
    (angle(90, speed=9.0), 'max_rotation_speed'), (arc(90, 0.3, speed=0.5), 'max_translation')])
def test_a_turning_speed_beyond_the_limits_is_slowed_and_said(goal, name):
    ending = pursue(late(), goal)
    assert ending.code is Code.NONE
    assert 'slowed to ' in ending.text and name in ending.text


def test_a_goal_that_is_reached_already_ends_at_once():
    loop = late()
    assert pursue(loop, distance(0.0)).code is Code.NONE
    assert pursue(loop, angle(0.0)).code is Code.NONE
    assert pursue(loop, place(0.0, 0.0)).code is Code.NONE
    assert loop.body.truth().travelled == pytest.approx(0.0, abs=1e-3)


# What a bumper, a cliff, a wheel that drops or a stall ends.


@pytest.mark.parametrize(('happens', 'code', 'where', 'what_to_do'), [
    (lambda body: body.force(bump_left=1), Code.BUMP, 'on the left', 'drive backwards'),
    (lambda body: body.force(bump_right=1), Code.BUMP, 'on the right', 'drive backwards'),
    (lambda body: body.force(bump_left=1, bump_right=1), Code.BUMP, 'in front', 'drive backwards'),
    (lambda body: body.lift(True), Code.WHEEL_DROP, '', 'put the robot on the floor')],
    ids=['left', 'right', 'front', 'lifted'])
@pytest.mark.parametrize('make', [
    lambda: distance(1.0), lambda: angle(300), lambda: arc(90, 0.5), lambda: place(1.0, 0.0)])
def test_a_bump_and_a_wheel_that_drops_end_every_motion(
        loop, make, happens, code, where, what_to_do):
    running = moving(loop, make())
    happens(loop.body)
    ending = ended(loop, running)
    assert ending.code is code
    assert where in ending.text and what_to_do in ending.text


def test_a_pressed_bumper_lets_no_distance_begin_but_backwards_and_turns(loop):
    loop.body.force(bump_left=1)
    loop.run(0.1)
    assert pursue(loop, distance(0.2)).code is Code.BUMP
    assert loop.body.truth().travelled == 0
    assert pursue(loop, place(-0.3, 0.0)).code is Code.BUMP  # it turns, then drives ahead
    assert pursue(loop, angle(20)).code is Code.NONE
    assert pursue(loop, distance(-0.2)).code is Code.NONE


def test_a_bumper_that_is_pressed_again_while_the_robot_backs_off_ends_that(loop):
    loop.body.force(bump_left=1)
    loop.run(0.1)
    running = moving(loop, distance(-1.0))
    loop.body.unforce()
    loop.run(0.1)
    loop.body.force(bump_right=1)
    assert ended(loop, running).code is Code.BUMP


@pytest.mark.parametrize('mode', [oi.Mode.SAFE, oi.Mode.FULL])
def test_a_cliff_ends_a_motion_and_says_where(loop, mode):
    loop.driver.modes.set(mode, loop.now)
    loop.run(0.2)
    running = moving(loop)
    loop.body.force(cliff_front_left=1)
    ending = ended(loop, running)
    assert ending.code is Code.CLIFF
    assert 'front left' in ending.text


def test_at_a_cliff_in_full_mode_only_the_way_back_is_open(loop):
    loop.driver.modes.set(oi.Mode.FULL, loop.now)
    loop.run(0.2)
    loop.body.force(cliff_right=1)
    loop.run(0.1)
    assert pursue(loop, distance(0.1)).code is Code.CLIFF
    assert pursue(loop, angle(30)).code is Code.CLIFF
    assert pursue(loop, distance(-0.1)).code is Code.NONE


def test_safe_mode_itself_may_end_a_way_back_at_a_cliff(loop):
    loop.body.force(cliff_left=1)
    loop.run(0.1)
    ending = pursue(loop, arc(90, 0.1, direction=-1))
    assert ending.code is Code.CLIFF
    assert 'robot left SAFE (cliff left)' in ending.text
    assert 'call set_mode with SAFE, then drive backwards' in ending.text


@pytest.mark.parametrize('speed', [0.11, 0.2, 0.3])
def test_wheels_that_do_not_follow_stall_even_if_no_current_shows_it(loop, speed):
    """Also where readings in a row would tell the rounding, which standing wheels do not."""
    running = moving(loop, distance(5.0, speed))
    loop.body.hold(right=True, left=True)
    loop.body.force(overcurrent_right_wheel=0, overcurrent_left_wheel=0)
    ending = until_ended(loop, running)
    assert ending.code is Code.STALL
    assert 'do not follow' in ending.text
    assert loop.robot.actuators.wheels == (0, 0)


@pytest.mark.parametrize(('make', 'from_', 'until'), [
    (lambda: distance(1.0), 0.3, 2.2), (lambda: distance(0.4), 1.0, 2.1),
    (lambda: angle(360.0, 1.2), 0.7, 2.6)])
def test_readings_that_are_damaged_are_not_taken_for_wheels_that_are_held(make, from_, until):
    loop = met()
    carry, begun = loop._carry, loop.now

    def damaged(line, data):
        reader = oi.StreamReader(loop.driver.plan.lists)
        if line is loop._down and begun + from_ <= loop.now < begun + until:
            reader.feed(data)
            data = b''.join(
                event.data[:-1] + bytes([event.data[-1] ^ 1]) if isinstance(event, oi.Frame)
                and 'distance' in event.packets.names else event.data
                for event in reader.finish())
        carry(line, data)
    loop._carry = damaged
    ending = pursue(loop, make())
    assert loop.driver.counts.checksum_failures > 1
    assert ending.code is Code.NONE, ending.text


@pytest.mark.parametrize('most', [0.0, 0.0004])
def test_a_robot_that_may_not_turn_its_wheels_says_so(most):
    for goal in (distance(0.1), angle(10)):
        ending = pursue(met(MotionLimits(max_wheel_speed=most)), goal)
        assert ending.code is Code.STALL
        assert 'max_wheel_speed is 0' in ending.text


def test_low_side_drivers_that_draw_too_much_stop_no_wheels(loop):
    loop.body.force(overcurrent_ld0=1, overcurrent_ld1=1, overcurrent_ld2=1)
    assert pursue(loop, distance(0.3)).code is Code.NONE


@pytest.mark.parametrize('wheel', ['overcurrent_left_wheel', 'overcurrent_right_wheel'])
def test_a_wheel_that_draws_too_much_for_half_a_second_is_held(loop, wheel):
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
def test_a_robot_that_is_made_slow_while_a_goal_runs_is_not_taken_for_a_held_one(
        loop, make, limits):
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
