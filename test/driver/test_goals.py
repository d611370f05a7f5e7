# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals: where the robot is when they end, and how it gets there."""

from dataclasses import replace
from math import degrees, hypot, inf, nan, pi
import struct

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings, Severity
from create_oi_ros.driver.goals import (
    Code,
    DriveArc,
    Malformed,
    RotateAngle,
)
from create_oi_ros.driver.goals.goal import Instruction, StoppingModel, View
from create_oi_ros.driver.goals.legs import Straight
from create_oi_ros.driver.motion import Velocity
from create_oi_ros.odometry import Estimate
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY
from support.goals import angle, arc, distance, place, pursue, reach, start
from support.loop import Loop, texts, turn_difference


def met(**options) -> Loop:
    """Return the likeliest robot and a driver that have met."""
    loop = Loop(config=DEFAULT_BODY, delay=0.005, **options)
    loop.run(1.0)
    return loop


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
    assert turned == pytest.approx(turn, abs=2 + 0.003 * abs(turn))
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
    assert hypot(pose.x - x, pose.y - y) < 0.035
    if heading is not None:
        assert degrees(turn_difference(pose.yaw, heading * pi / 180)) < 3


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
    loop = Loop(config=replace(DEFAULT_BODY, right_speed_gain=1.03, left_speed_gain=0.97))
    loop.run(1.0)
    reach(loop, distance(1.0))
    assert abs(loop.body.truth().pose.y) < 0.05


def test_wheels_that_do_not_move_when_they_creep_are_told_to_creep_faster():
    loop = Loop(config=replace(DEFAULT_BODY, dead_band=0.045))
    loop.run(1.0)
    went, _ = reach(loop, distance(0.03))
    assert went == pytest.approx(0.03, abs=0.01)


def test_speeds_and_accelerations_stay_within_the_limits():
    limits = MotionLimits(max_wheel_speed=0.2, linear_acceleration=0.2)
    loop = met(settings=Settings(limits=limits))
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
    loop = met(settings=Settings(limits=MotionLimits(max_wheel_speed=0.3)))
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


def test_four_turns_are_no_question():
    assert not angle(4 * 360).hint


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


@pytest.mark.parametrize(('make', 'says'), [
    (lambda: distance(nan), 'distance = nan m is not finite'),
    (lambda: distance(inf), 'distance = inf m is not finite'),
    (lambda: distance(5000.0), 'distance = 5000 m; allowed: -1000 to 1000'),
    (lambda: distance(1.0, speed=0.0), 'max_translation_speed = 0 m/s; allowed: 0.001 or more'),
    (lambda: distance(1.0, speed=-0.1), 'max_translation_speed = -0.1 m/s; allowed: 0.001'),
    (lambda: distance(1.0, speed=1e-6), 'max_translation_speed = 1e-06 m/s; allowed: 0.001'),
    (lambda: arc(90, 0.3, speed=4e-4), 'max_translation_speed = 0.0004 m/s; allowed: 0.001'),
    (lambda: angle(90, speed=0.0077), 'max_rotation_speed = 0.0077 rad/s; allowed: 0.008'),
    (lambda: distance(1.0, speed=nan), 'max_translation_speed = nan m/s is not finite'),
    (lambda: distance(1.0, allowance=-1.0), 'time_allowance = -1 s; allowed: 0 or more'),
    (lambda: angle(nan), 'angle = nan rad is not finite'),
    (lambda: angle(90, speed=0.0), 'max_rotation_speed = 0 rad/s; allowed: 0.008 or more'),
    (lambda: angle(1e6), 'angle = 17453.3 rad; allowed: -6283.19 to 6283.19'),
    (lambda: arc(90, 0.0), 'radius = 0 m; allowed: above 0'),
    (lambda: arc(90, -1.0), 'radius = -1 m; allowed: above 0'),
    (lambda: arc(90, 1.0, direction=0), 'translate_direction = 0; allowed: 1 forward'),
    (lambda: arc(90, 1e6), 'length of the arc = 1.5708e+06 m; allowed: -1000 to 1000'),
    (lambda: place(nan, 0), 'goal_pose.position.x = nan m is not finite'),
    (lambda: place(0, 1e7), 'goal_pose.position.y = 1e+07 m; allowed'),
    (lambda: place(0, 0, nan), 'heading of goal_pose = nan rad is not finite'),
])
def test_a_malformed_goal_is_refused_in_words(make, says):
    with pytest.raises(Malformed) as refused:
        make()
    assert says in str(refused.value)


# The speed along one way, frame by frame: faster, slower, stop, settle, correct.


WAY, TOP, DT = 1.0, 0.3, 0.1


def approach(learned: StoppingModel | None = None, way: float = WAY) -> Straight:
    """Return a straight line that has not begun."""
    return Straight(at(WAY)._replace(straight=learned or StoppingModel()), way, 0.0, TOP)


def at(left: float, speed: float = 0.0, dt: float = DT, measured: bool = False) -> View:
    """Return what a frame says."""
    return View(0.0, dt, Estimate(linear=speed, trip=(WAY - left, 0.0)), oi.Readings(), measured,
                MotionLimits(linear_acceleration=0.0), StoppingModel(), StoppingModel())


def step(begun: Straight, frame: View) -> float | None:
    """Return the speed that a frame leads to: 0 too where it asks for a reading."""
    told = begun.step(frame)
    if isinstance(told, Velocity):
        assert told.angular == 0.0
        return told.linear
    return 0.0 if told is Instruction.MEASURE else None


def stopped(left: float, pace: float = 0.0, learned: StoppingModel | None = None) -> Straight:
    """Return an approach that has just told the wheels to stand, with so much left."""
    begun = approach(learned)
    step(begun, at(1.0))
    assert step(begun, at(left, pace)) == 0.0
    return begun


def frames_until_moving(begun: Straight, frame: View) -> int:
    """Return after how many frames an approach that stands has arrived or goes on."""
    count = 0
    while step(begun, frame) == 0.0 and not begun.correcting:
        count += 1
    return count


@pytest.mark.parametrize(('way', 'coast'), [(9.0, 0.8), (-1.0, 0.03)])
def test_a_coast_that_cannot_be_is_not_believed(way, coast):
    learned = StoppingModel()
    for _ in range(50):
        learned.stopped(0.3, way)
    assert learned.coast == pytest.approx(coast, abs=0.001)


@pytest.mark.parametrize('sign', [1, -1])
def test_a_short_rest_of_the_way_is_a_push_of_its_length(sign):
    begun = stopped(0.0)
    frames_until_moving(begun, at(sign * 0.015))
    told = [step(begun, at(sign * 0.015, dt=0.01)) for _ in range(60)]
    assert told == 50 * [sign * 0.03] + 10 * [0.0]


def test_it_corrects_three_times_at_most():
    begun, left, corrections, before = stopped(0.0), 0.01, 0, 0.0
    while (speed := step(begun, at(left))) is not None:
        corrections += bool(speed and not before)
        if before and not speed:
            left = -left  # each leads too far
        before = speed
    assert corrections == 3
    assert begun.correcting


@pytest.mark.parametrize(('way', 'sign'), [(0.01, 1), (0.01, -1), (0.1, 1)])
def test_a_correction_that_moves_nothing_is_none_and_the_next_is_faster(way, sign):
    begun, told, before = stopped(0.0), [], 0.0
    left = at(sign * way)
    while (speed := step(begun, left)) is not None:
        if speed and not before:
            told.append(speed)
        before = speed
        # The odometry believes that creeping moves the robot until a reading says otherwise.
        left = at(sign * (0.0 if speed and way > 0.02 else way), sign * 0.03 if speed else 0.0)
    assert told == pytest.approx(
        [sign * speed for speed in (0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.08, 0.08)])


def test_how_long_a_way_takes_at_most():
    ramps = 0.15 * (1 / 0.5 + 1 / 0.25)
    settling = 4 * (1.4 + 0.02 / 0.03)
    for way in (1.5, -1.5):
        assert approach(way=way).seconds() == pytest.approx(1.5 / TOP + ramps + settling)


def test_a_robot_that_stands_is_asked_how_far_it_went_until_a_reading_comes():
    begun = approach()
    assert step(begun, at(1.0)) > 0
    assert step(begun, at(0.0)) == 0.0
    told = [begun.step(at(0.0, dt=0.01, measured=frame == 20)) for frame in range(30)]
    assert told == 15 * [Velocity()] + 5 * [Instruction.MEASURE] + 10 * [None]
