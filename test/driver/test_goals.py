# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals: where the robot is when they end, and how it gets there."""

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
from support import goals
from support.goals import angle, arc, distance, place, pursue, reach, start
from support.loop import texts, turn_difference

met = partial(goals.met, delay=0.005)


@pytest.mark.parametrize(('metres', 'rounding'), [
    (1.0, Rounding.CARRY), (0.3, Rounding.TRUNCATE), (0.02, Rounding.ROUND),
    (-0.5, Rounding.CARRY), (-0.5, Rounding.TRUNCATE)])
def test_a_distance_is_driven(rounding, metres):
    went, turned = reach(met(rounding=rounding), distance(metres))
    assert went == pytest.approx(metres, abs=0.005 + 0.005 * abs(metres))
    assert abs(turned) < 2


@pytest.mark.parametrize(('turn', 'rounding'), [
    (90, Rounding.CARRY), (-180, Rounding.TRUNCATE), (10, Rounding.ROUND),
    (720, Rounding.CARRY), (720, Rounding.TRUNCATE)])
def test_an_angle_is_turned(rounding, turn):
    went, turned = reach(met(rounding=rounding), angle(turn))
    assert turned == pytest.approx(turn, abs=1.5 + 0.003 * abs(turn))
    assert abs(went) < 0.005


@pytest.mark.parametrize(('turn', 'direction'), [(90, 1), (-90, -1), (400, 1), (90, -1)])
def test_an_arc_is_driven_on_its_circle(turn, direction):
    loop = met()
    went, turned = reach(loop, arc(turn, 0.4, direction))
    assert turned == pytest.approx(turn, abs=2 + 0.005 * abs(turn))
    assert went == pytest.approx(direction * 0.4 * abs(turn) * pi / 180, rel=0.03)
    pose, side = loop.body.truth().pose, direction * (1 if turn > 0 else -1)
    assert hypot(pose.x, pose.y - side * 0.4) == pytest.approx(0.4, abs=0.03)


@pytest.mark.parametrize(('x', 'y', 'heading'), [
    (0.5, 0.3, 90), (-0.4, 0.0, None), (0.0, -0.6, -170), (0.0, 0.0, 45)])
def test_a_place_is_reached_with_its_heading(x, y, heading):
    loop = met()
    reach(loop, place(x, y, heading))
    pose = loop.body.truth().pose
    assert hypot(pose.x - x, pose.y - y) < 0.02
    if heading is not None:
        assert degrees(turn_difference(pose.yaw, heading * pi / 180)) < 2


def test_a_robot_that_knows_its_coast_does_not_overshoot():
    loop = met()
    for _ in range(3):
        reach(loop, distance(0.4))
    begun, furthest = loop.body.truth().travelled, 0.0
    running = start(loop, distance(0.4))
    while running.outcome is None:
        loop.turn()
        furthest = max(furthest, loop.body.truth().travelled - begun)
    assert furthest < 0.4 + 0.005


def test_unequal_wheels_still_drive_straight():
    loop = goals.met(config=replace(DEFAULT_BODY, right_speed_gain=1.03, left_speed_gain=0.97))
    reach(loop, distance(1.0))
    assert abs(loop.body.truth().pose.y) < 0.05


def test_wheels_that_do_not_move_when_they_creep_are_told_to_creep_faster():
    loop = goals.met(config=replace(DEFAULT_BODY, dead_band=0.045))
    went, _ = reach(loop, distance(0.03))
    assert went == pytest.approx(0.03, abs=0.01)


def test_speeds_and_accelerations_stay_within_the_limits():
    limits = MotionLimits(max_wheel_speed=0.2, linear_acceleration=0.2)
    loop = met(limits)
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
    loop = met(MotionLimits(max_wheel_speed=0.3))
    assert 'slowed' not in pursue(loop, distance(0.1, speed=speed)).text
    angle(degrees(turn))


@pytest.mark.parametrize(('goal', 'hint'), [
    (RotateAngle(90.0, 1.9, 3.0), '90 rad is 14.3 turns: degrees?'),
    (RotateAngle(-45.0, 1.9, 3.0), '-45 rad is 7.2 turns: degrees?'),
    (DriveArc(90.0, 0.2, 1, 0.3, 3.0), '90 rad is 14.3 turns: degrees?')])
def test_more_than_four_turns_are_driven_but_asked_about(goal, hint):
    loop = met()
    ending = pursue(loop, goal)
    assert ending.code is Code.TIMEOUT
    assert hint in ending.text
    assert texts(loop.notices, Severity.WARNING) == [hint]


@pytest.mark.parametrize(('goal', 'name'), [
    (angle(90, speed=9.0), 'max_rotation_speed'), (arc(90, 0.3, speed=0.5), 'max_translation')])
def test_a_turning_speed_beyond_the_limits_is_slowed_and_said(goal, name):
    ending = pursue(met(), goal)
    assert ending.code is Code.NONE
    assert 'slowed to ' in ending.text and name in ending.text


def test_a_goal_that_is_reached_already_ends_at_once():
    loop = met()
    assert pursue(loop, distance(0.0)).code is Code.NONE
    assert pursue(loop, angle(0.0)).code is Code.NONE
    assert pursue(loop, place(0.0, 0.0)).code is Code.NONE
    assert loop.body.truth().travelled == pytest.approx(0.0, abs=1e-3)
