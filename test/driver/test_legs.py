# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is left of a way, and how the robot is steered along it, by sums done by hand."""

from dataclasses import replace
from math import inf, pi, sqrt

import pytest

from create_oi_ros.driver.goals.approach import Learned
from create_oi_ros.driver.goals.legs import Arc, steering, Straight, Turn
from create_oi_ros.odometry import Estimate
from support.views import LIMITS, view

START = Estimate(x=1.0, y=2.0, yaw=pi / 2)
FREE = replace(LIMITS, linear_acceleration=0.0, angular_acceleration=0.0, max_wheel_speed=0.5)


def straight(distance: float, heading: float = pi / 2, top: float = 0.3) -> Straight:
    """Return a straight line from the start, to the north."""
    return Straight(START, distance, heading, top, Learned(), FREE)


def arc(angle: float, direction: int, limits=FREE) -> Arc:
    """Return a part of a circle of half a metre."""
    return Arc(START, angle, 0.5, direction, 0.2, Learned(), limits)


def told(leg, estimate: Estimate = START, dt: float = 0.1):
    """Return the velocity that a leg asks for."""
    return leg.step(view(dt, estimate=estimate))


@pytest.mark.parametrize(('speed', 'aside', 'off', 'turn'), [
    (0.0, 1.0, 1.0, 0.0),  # who stands is not steered
    (0.2, 0.05, 0.0, -0.4), (0.2, -0.05, 0.0, 0.4),  # 4 rad a metre, 2 rad/s a radian
    (0.2, 0.0, 0.1, -0.2), (0.2, 0.05, -0.2, 0.0),
    (-0.2, 0.05, 0.0, 0.4), (-0.2, 0.0, 0.1, -0.2),  # backwards the other way round
    (0.2, 9.0, 0.0, -0.8), (0.2, -9.0, 0.0, 0.8), (0.2, 9.0, -0.3, -0.4),  # half a radian
    (0.15, 0.0, 3.0, -0.6), (-0.15, 0.0, -3.0, 0.6), (0.4, 0.0, 3.0, -0.8)])  # not too sharply
def test_a_robot_is_steered_back_to_its_line(speed, aside, off, turn):
    assert steering(speed, aside, off) == pytest.approx(turn)


def test_of_a_straight_line_only_the_way_along_it_counts():
    leg = straight(1.0)
    told(leg, START._replace(x=0.9, y=2.25))
    assert leg.distance == pytest.approx(0.75)
    told(leg, START._replace(x=0.9, y=2.2))
    assert leg.distance == pytest.approx(0.8)
    assert leg.angle == 0.0
    back = straight(-1.0)
    told(back, START._replace(y=1.75))
    assert back.distance == pytest.approx(-0.75)
    assert (leg.forward, back.forward) == (True, False)


def test_a_straight_line_brings_the_robot_back_from_the_side_it_is_on():
    for x, yaw, turn in ((0.95, pi / 2, -0.2), (1.05, pi / 2, 0.2), (1.0, pi / 2 + 0.1, -0.2),
                         (1.0, pi / 2 - 2 * pi + 0.1, -0.2)):
        leg = straight(1.0)
        velocity = told(leg, START._replace(x=x, yaw=yaw))
        assert velocity.linear == pytest.approx(0.05)
        assert velocity.angular == pytest.approx(turn)
    both = straight(1.0)
    told(both, START._replace(x=0.98))
    velocity = told(both, START._replace(x=0.98))
    assert velocity == pytest.approx((0.1, -0.16))


def test_a_straight_line_backwards_is_driven_and_steered_backwards():
    assert told(straight(-1.0), START._replace(x=0.95)) == pytest.approx((-0.05, 0.2))


def test_no_leg_is_faster_than_its_wheels_or_its_speed():
    for top, most in ((0.3, 0.3), (0.9, 0.5)):
        leg = straight(9.0, top=top)
        assert max(told(leg).linear for _ in range(30)) == pytest.approx(most)
    for top, most in ((2.0, 2.0), (9.0, 4.0)):
        turn = Turn(START, 9.0, top, Learned(), FREE)
        assert max(told(turn).angular for _ in range(30)) == pytest.approx(most)


def test_accelerations_are_those_of_the_wheels():
    limits = replace(FREE, linear_acceleration=0.2, angular_acceleration=0.8)
    leg = Straight(START, 1.0, pi / 2, 0.3, Learned(), limits)
    told(leg, dt=0.5)
    assert told(leg, dt=0.5).linear == pytest.approx(0.2)
    turn = Turn(START, 9.0, 2.0, Learned(), limits)
    told(turn, dt=0.5)
    assert told(turn, dt=0.5).angular == pytest.approx(0.8)
    # On a circle of half a metre the wheel outside runs at 0.625 of what its centre turns.
    for linear, angular, rate in ((0.1, 0.8, 0.2), (0.2, 0.1, 0.1), (0.1, 0.0, 0.2)):
        circle = arc(9.0, 1, replace(FREE, linear_acceleration=linear,
                                     angular_acceleration=angular))
        told(circle, dt=0.5)
        assert told(circle, dt=0.5).linear == pytest.approx(rate / 2)


@pytest.mark.parametrize('sign', [1, -1])
def test_a_turn_is_measured_by_its_heading_round_any_number_of_times(sign):
    turn = Turn(START, sign * 3 * pi, 2.0, Learned(), FREE)
    assert turn.angle == pytest.approx(sign * 3 * pi)
    for quarter in range(1, 5):
        velocity = told(turn, START._replace(yaw=pi / 2 + sign * quarter * pi / 2))
        assert velocity.linear == 0.0 and velocity.angular * sign > 0
    assert turn.angle == pytest.approx(sign * pi)
    assert turn.distance == 0.0
    told(turn, START._replace(x=5.0, yaw=pi / 2))
    assert turn.angle == pytest.approx(sign * pi)


@pytest.mark.parametrize(('angle', 'direction', 'linear', 'angular'), [
    (1.0, 1, 1, 1), (-1.0, 1, 1, -1), (1.0, -1, -1, 1), (-1.0, -1, -1, -1)])
def test_an_arc_turns_to_its_side_and_keeps_its_radius(angle, direction, linear, angular):
    leg = arc(angle, direction)
    velocity = told(leg)
    # The faster wheel begins with 0.05 m/s, 0.625 m from the centre of the circle.
    assert velocity == pytest.approx((linear * 0.04, angular * 0.08))
    assert leg.forward == (direction == 1)
    assert leg.angle == pytest.approx(angle)
    told(leg, START._replace(yaw=pi / 2 + angle / 4))
    assert leg.angle == pytest.approx(0.75 * angle)
    assert leg.distance == 0.0


@pytest.mark.parametrize('side', [1, -1])
@pytest.mark.parametrize('direction', [1, -1])
def test_an_arc_steers_back_to_its_circle(side, direction):
    """The robot is 5 cm outside its circle, after no motion: it bends towards the centre."""
    leg = arc(side * direction * 1.0, direction)
    velocity = told(leg, START._replace(x=1.0 + side * 0.05))
    plain = side * direction * 0.08
    # It drives at 0.04 m/s: 4 rad/s for each m/s are its most.
    assert velocity.angular - plain == pytest.approx(side * direction * 0.16)


def test_an_arc_that_heads_off_its_tangent_is_steered_back():
    leg = arc(2.0, 1)
    told(leg)
    velocity = told(leg, START._replace(yaw=pi / 2 + 0.1))
    assert velocity == pytest.approx((0.08, 0.16 - 0.2))


def test_an_arc_is_as_fast_as_its_centre_may_be_and_its_wheel_can_be():
    slow, quick = arc(9.0, 1), Arc(START, 9.0, 0.5, 1, 9.0, Learned(), FREE)
    assert max(told(slow).linear for _ in range(40)) == pytest.approx(0.2)
    assert max(told(quick).linear for _ in range(40)) == pytest.approx(0.4)


def covariance(xx: float = 0.0, xy: float = 0.0, yy: float = 0.0, aa: float = 0.0):
    """Return a covariance of x, y and yaw."""
    return (xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, aa)


@pytest.mark.parametrize(('make', 'grown'), [
    (lambda: straight(0.07, heading=0.0), covariance(xx=1e-4)),
    (lambda: straight(0.07), covariance(yy=1e-4)),
    (lambda: straight(0.07, heading=pi / 4), covariance(xx=1e-4, yy=1e-4)),
    (lambda: straight(0.07, heading=pi / 4), covariance(xy=1e-4)),
    (lambda: straight(0.07, heading=-pi / 4), covariance(xy=-1e-4)),
    (lambda: Turn(START, 0.56, 9.0, Learned(), FREE), covariance(aa=1e-4 * 8 ** 2)),
    (lambda: arc(0.112, 1), covariance(aa=1e-4 / 0.625 ** 2))],
    ids=['east', 'north', 'between', 'correlated', 'the other way', 'turn', 'arc'])
def test_only_doubt_that_grew_along_the_way_slows_the_robot(make, grown):
    """After a centimetre of standard deviation it creeps two centimetres earlier."""
    for earlier, spread in ((0.0, covariance()), (0.02, grown)):
        leg = make()
        told(leg, START._replace(pose_covariance=covariance()), dt=inf)
        velocity = told(leg, START._replace(pose_covariance=spread), dt=9.0)
        wheel = abs(velocity.linear) * (1.25 if isinstance(leg, Arc) else 1)
        assert wheel + (not wheel) * velocity.angular / 8 == pytest.approx(
            sqrt(0.0009 + 0.5 * (0.06 - earlier)))


def test_doubt_that_was_there_at_the_start_slows_nothing():
    leg = straight(0.07)
    unsure = START._replace(pose_covariance=covariance(1.0, 0.0, 1.0, 1.0))
    assert told(leg, unsure, dt=9.0).linear == pytest.approx(sqrt(0.0009 + 0.5 * 0.06))


def test_a_leg_ends_when_nothing_is_left():
    assert told(straight(0.0019)) is None
    assert told(straight(0.0021)) is not None
    assert told(Turn(START, 0.0087, 1.0, Learned(), FREE)) is None
    assert told(Turn(START, 0.0088, 1.0, Learned(), FREE)) is not None
    assert told(arc(0.0087, 1)) is None
    assert told(arc(0.0088, 1)) is not None


def test_a_leg_that_is_corrected_is_not_steered():
    leg = straight(0.5)
    told(leg)
    told(leg, START._replace(y=2.5))
    there = START._replace(y=2.49)
    for _ in range(20):
        told(leg, there)
        if leg._approach.correcting:
            break
    turned = there._replace(yaw=pi / 2 + 0.3)
    assert told(leg, turned) == pytest.approx((0.03, 0.0))
