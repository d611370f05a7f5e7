# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions frame by frame: their legs, what is left, how long they may take, what they say."""

from dataclasses import replace
from math import atan2, cos, pi, sin

import pytest

from create_oi_ros.driver.goals import Code, Ending, Malformed, Phase, Progress
from create_oi_ros.driver.goals.goal import check_amount, check_positive, docked, Over, Running
from create_oi_ros.odometry import Estimate
from support.goals import angle, arc, distance, place
from support.views import LIMITS, view

FREE = replace(LIMITS, linear_acceleration=0.0, angular_acceleration=0.0, max_wheel_speed=0.5)
SETTLING = 4 * (1.4 + 0.02 / 0.03)


def at(x: float = 0.0, y: float = 0.0, yaw: float = 0.0, **more):
    """Return a view of a robot that is somewhere."""
    return view(0.1, estimate=Estimate(x=x, y=y, yaw=yaw, linear=0.2, angular=1.0), limits=FREE,
                **more)


def begun(goal, **where: float):
    """Return a goal that has begun and taken its first step."""
    assert goal.begin(at(**where)) is None
    goal.step(at(**where))
    return goal


def seconds(wheel: float, top: float) -> float:
    """Return how long a way of the faster wheel takes at most, m and m/s."""
    return wheel / top + top / 2 * (1 / 0.5 + 1 / 0.25) + SETTLING


@pytest.mark.parametrize(('goal', 'expected'), [
    (distance(-1.5), seconds(1.5, 0.3)), (angle(180), seconds(pi / 8, 1.9 / 8)),
    (arc(-180, 0.5), seconds(pi * 0.625, 0.3 * 1.25)),
    (place(0.3, 0.4), seconds(atan2(0.4, 0.3) / 8, 1.9 / 8) + seconds(0.5, 0.3)),
    (place(0.3, 0.4, 90), seconds(atan2(0.4, 0.3) / 8, 1.9 / 8) + seconds(0.5, 0.3)
     + seconds(pi / 16, 1.9 / 8)), (place(0.001, 0.0), 0.0)])
def test_a_motion_may_take_twice_what_it_should(goal, expected):
    goal.begin(at())
    assert goal.allowance == pytest.approx(2 * expected)


def test_a_time_that_was_given_is_kept_and_said():
    for seconds in (3.0, 0.5):
        goal = distance(1.0, allowance=seconds)
        goal.begin(at())
        assert goal.timed_out() == Over(Code.TIMEOUT, f'time_allowance of {seconds} s is over: '
                                        'allow more time, or a higher speed')
    assert 'twice what it should take' in distance(1.0).timed_out().text
    with pytest.raises(Malformed, match='time_allowance = -0.1 s; allowed: 0 or more'):
        distance(1.0, allowance=-0.1)


def test_what_is_left_and_how_far_it_got_are_told():
    for metres in (1.0, -1.0):
        goal = distance(metres)
        assert goal.way(9.0) == 'at the start' and goal.progress.distance == 0.0
        begun(goal)
        goal.step(at(x=metres / 4))
        assert goal.progress.distance == pytest.approx(0.75)
        assert goal.progress.angle == 0.0
        assert goal.way(9.0) == 'after 0.25 m'
    for goal in (angle(-90), arc(-90, 0.5)):
        begun(goal)
        goal.step(at(yaw=-pi / 8))
        assert goal.progress.angle == pytest.approx(3 * pi / 8)
        assert goal.way(9.0) == 'after 22 degrees'


def arrived(goal, **where: float) -> Over:
    """Let a goal arrive; return how it ended."""
    order = None
    for pace in (0.2, -0.2, *(58 * [0.0])):
        here = at(**where)
        order = goal.step(here._replace(
            estimate=here.estimate._replace(linear=pace, angular=pace), measured=True))
        if isinstance(order, Over):
            break
    return order


@pytest.mark.parametrize(('goal', 'where', 'says'), [
    (distance(0.5), {'x': 0.499}, 'drove 0.499 m'),
    (distance(-0.5), {'x': -0.499}, 'drove -0.499 m'),
    (angle(45), {'yaw': 0.784}, 'turned by 0.784 rad (44.9 degrees)'),
    (arc(45, 0.5), {'yaw': 0.784}, 'turned by 0.784 rad (44.9 degrees) on a radius of 0.5 m')])
def test_what_was_done_is_said(goal, where, says):
    begun(goal)
    assert arrived(goal, **where) == Over(Code.NONE, says)


def test_a_place_is_turned_to_driven_to_and_turned_at():
    goal = begun(place(1.3, 2.4, 90), x=1.0, y=2.0, yaw=3.0)
    assert goal.progress.phase is Phase.TURNING_TO_PLACE
    assert goal.progress.angle == pytest.approx(3.0 - atan2(0.4, 0.3))
    assert goal.way(9.0) == '0.50 m from the goal'
    heading = atan2(0.4, 0.3)
    for _ in range(30):
        goal.step(at(1.0, 2.0, heading)._replace(
            estimate=Estimate(x=1.0, y=2.0, yaw=heading), measured=True))
    assert goal.progress.phase is Phase.DRIVING
    assert goal.progress.distance == pytest.approx(0.5)
    for _ in range(30):
        goal.step(at()._replace(estimate=Estimate(x=1.3, y=2.4, yaw=heading), measured=True))
    assert goal.progress.phase is Phase.TURNING_TO_HEADING
    assert goal.progress.angle == pytest.approx(pi / 2 - heading)
    over = arrived(goal, x=1.3, y=2.39, yaw=pi / 2)
    assert over == Over(Code.NONE, 'at x 1.300 m, y 2.390 m, 0.010 m from the goal')


def test_a_place_is_driven_to_from_where_the_turn_has_ended():
    goal = begun(place(1.0, 0.0), yaw=0.5)
    for _ in range(30):
        goal.step(at()._replace(estimate=Estimate(x=0.0, y=1.0), measured=True))
    assert goal.progress.distance == pytest.approx(2 ** 0.5)
    order = goal.step(at()._replace(estimate=Estimate(x=0.1, y=0.9, yaw=-pi / 4)))
    assert goal.progress.distance == pytest.approx(0.9 * 2 ** 0.5)
    assert order.angular == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(('goal', 'said'), [
    (distance(1.0, speed=0.6), ['0.50 m/s: max_translation_speed = 0.6']),
    (distance(1.0, speed=0.5), []), (angle(9, speed=4.0), []),
    (angle(9, speed=4.1), ['4.00 rad/s: max_rotation_speed = 4.1']),
    (arc(9, 0.5, speed=0.41), ['0.40 m/s: max_translation_speed = 0.41']),
    (arc(9, 0.5, speed=0.4), [])])
def test_speeds_beyond_the_wheels_are_said_with_what_is_driven_instead(goal, said):
    assert goal._slower(FREE) == [
        f'; slowed to {each} is beyond max_wheel_speed' for each in said]


def test_of_a_place_both_speeds_are_looked_at():
    slow = replace(FREE, max_wheel_speed=0.2)
    assert len(place(1.0, 1.0)._slower(slow)) == 2


@pytest.mark.parametrize(('goal', 'ends'), [
    (distance(1.0), True), (distance(-1.0), False), (angle(9), False), (arc(9, 0.5), True),
    (arc(9, 0.5, direction=-1), False), (place(1.0, 0.0), False)])
def test_a_bumper_that_is_pressed_keeps_a_motion_from_leading_ahead(goal, ends):
    over = goal.begin(at(bumps_and_wheel_drops=1))
    assert (over is not None) == ends


@pytest.mark.parametrize(('goal', 'ends'), [
    (distance(0.5), True), (distance(-0.5), False), (angle(9), True), (arc(9, 0.5), True),
    (arc(9, 0.5, direction=-1), False), (place(1.0, 0.0), True)])
def test_a_cliff_keeps_a_motion_from_beginning_unless_it_leads_back(goal, ends):
    over = goal.begin(at(cliff_left=1))
    assert (over is not None) == ends


def test_a_thousand_turns_are_the_most():
    angle(359999)
    with pytest.raises(Malformed, match='allowed: -6283.19 to 6283.19'):
        angle(360001)


def test_a_robot_without_a_dock_sensor_is_on_no_dock():
    assert not docked(view().readings)
    assert not docked(view(charging_sources=1).readings)
    assert docked(view(charging_sources=3).readings)


def test_an_arc_may_be_as_long_as_a_distance():
    arc(180, 318.0)
    with pytest.raises(Malformed, match='length of the arc = 1002'):
        arc(180, 319.0)


def test_a_leg_that_leads_ahead_ends_at_a_bumper_that_was_pressed():
    goal = begun(distance(1.0))
    assert goal.step(at(bumps_and_wheel_drops=1)).code is Code.BUMP
    goal = begun(distance(-1.0))
    assert goal.step(at(bumps_and_wheel_drops=1)).code is Code.BUMP  # it was not at the start
    goal = distance(-1.0)
    goal.begin(at(bumps_and_wheel_drops=1))
    for _ in range(3):
        assert not isinstance(goal.step(at(bumps_and_wheel_drops=1)), Over)


def test_limits_are_allowed_themselves():
    check_amount('way', 1000.0, 1000.0, 'm')
    check_amount('way', -1000.0, 1000.0, 'm')
    with pytest.raises(Malformed, match='way = 1000.1 m; allowed: -1000 to 1000'):
        check_amount('way', 1000.1, 1000.0, 'm')
    check_positive('speed', 0.5, 'm/s')
    with pytest.raises(Malformed, match='speed = 0 m/s; allowed: above 0'):
        check_positive('speed', 0.0, 'm/s')


def test_endings_have_the_numbers_of_the_actions_and_say_nothing_by_default():
    assert [code.name for code in sorted(Code)] == [
        'NONE', 'TIMEOUT', 'BUMP', 'CLIFF', 'WHEEL_DROP', 'STALL', 'MODE', 'NO_ROBOT', 'LINK',
        'NO_DOCK', 'SUPERSEDED', 'STOPPED', 'CANCELED']
    assert [int(code) for code in sorted(Code)] == list(range(13))
    assert Progress() == (0.0, 0.0, None, 0)
    assert Ending(Code.NONE, '')[2:] == (Estimate(), 0.0, False)


@pytest.mark.parametrize(('goal', 'progress'), [
    (distance(1.0), Progress(distance=0.6)), (angle(180), Progress(angle=pi - 0.3))])
def test_a_correction_of_what_was_wrong_before_the_start_is_no_way_and_no_turn(goal, progress):
    """The robot went 0.4 m and turned by 0.3 rad; the place where it began has moved, too."""
    begun(goal, x=1.0, y=2.0)
    turned = 0.0 if isinstance(goal, type(distance(1.0))) else 0.3
    mark = 1.2, 1.9, 0.5
    goal.step(at(1.2 + 0.4 * cos(0.5), 1.9 + 0.4 * sin(0.5), 0.5 + turned, mark=mark))
    assert goal.progress.distance == pytest.approx(progress.distance)
    assert goal.progress.angle == pytest.approx(progress.angle)


def test_a_place_is_one_of_the_odometry_whatever_was_wrong_before():
    goal = begun(place(2.0, 0.0), x=0.0)
    goal.step(at(0.0, 0.0, 0.0, mark=(0.5, 0.0, 0.0)))
    goal.step(at(0.5, 0.0, 0.0, mark=(0.5, 0.0, 0.0)))
    assert goal.way(1.0) == '1.50 m from the goal'


def test_whoever_waits_for_the_end_of_a_goal_is_told_once():
    running, early, late = Running(), [], []
    ended, again = Ending(Code.NONE, 'there'), Ending(Code.TIMEOUT, 'too late')
    running.then(early.append)
    assert early == []
    running.end(ended)
    running.end(again)
    running.then(late.append)
    assert early == late == [ended]
    assert running.ending is ended
