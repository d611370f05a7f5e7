# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the odometry learns of the wheels, and that it follows any."""

from dataclasses import replace
from itertools import product
from math import hypot, radians, sqrt

import pytest

from create_oi_ros.odometry import Geometry, Odometry, SignSource, states
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig, EncoderSign, IDEAL
from create_oi_ros.sim.body.wheels import Response, TimeConstant
from create_oi_ros.sim.world import World
from support.bodies import LAGGING
from support.measuring import UNMEASURED
from support.ride import Ride, ROUNDINGS, SLOT

pytestmark = UNMEASURED

REVERSALS = [(0.3, 0.2), (0.1, -0.1), (0.0, 0.0), (-0.2, -0.15), (-0.2, 0.2), (0.25, 0.3)]


@pytest.mark.parametrize('rounding', ROUNDINGS)
@pytest.mark.parametrize(('config', 'most'), [
    (LAGGING, 10),
    (replace(LAGGING, encoder_sign=EncoderSign.TRUE, response=Response.RAMP, braking=2.0), 10),
    (replace(LAGGING, encoder_sign=EncoderSign.COMMAND, dead_time=0.12,
             right_speed_gain=0.96), 10),
    (replace(LAGGING, response=Response.SECOND_ORDER, time_constant=TimeConstant(0.05),
             overshoot=0.3, dead_time=0.1), 6)],
    ids=['a constant lag', 'true signs, hard brakes', 'signs of the command', 'overshoot'])
def test_any_wheels_are_followed(
        config: BodyConfig, most: float, rounding: Rounding) -> None:
    """Also those that swing back when they stop, which their encoders count forwards."""
    ride = Ride(rounding, config=config)
    for right, left in REVERSALS * 7:
        ride.go(2.1, right, left)
    ride.go(3)
    assert ride.miss[1] < most  # of some 2600
    assert ride.miss[0] < 0.4  # of 14 m


def test_wheels_that_overshoot_and_brake_softly_are_followed() -> None:
    """Such a wheel swings back far when it stops; its encoder counts that forwards."""
    missed = []
    for rounding, seconds, overshoot in product(ROUNDINGS, (0.05, 0.07), (0.2, 0.3)):
        ride = Ride(rounding, config=replace(
            LAGGING, response=Response.SECOND_ORDER, time_constant=TimeConstant(seconds),
            overshoot=overshoot, dead_time=0.07, braking=0.4))
        for right, left in REVERSALS * 7:
            ride.go(2.1, right, left)
        ride.go(3)
        missed.append(ride.miss[1])
    assert hypot(*missed) < 8 * sqrt(len(missed))  # of some 2600 in each of twelve drives


def test_yaw_is_never_corrected_by_more_than_five_degrees_in_half_a_second() -> None:
    ride = Ride(config=LAGGING)
    for right, left in REVERSALS * 3:
        ride.go(2.1, right, left)
    corrections = [b.yaw - a.yaw - b.angular * SLOT
                   for a, b in zip(ride.estimates, ride.estimates[1:])]
    half = round(0.5 / SLOT)
    assert max(abs(sum(corrections[i:i + half])) for i in range(len(corrections))) < radians(5)


@pytest.mark.parametrize('rounding', ROUNDINGS)
def test_finds_out_rounding_gains_and_acceleration(rounding: Rounding) -> None:
    ride = Ride(rounding, config=replace(IDEAL,
        wheel_acceleration=0.7, right_speed_gain=1.02, left_speed_gain=0.98))
    for right, left in [(0.3, 0.1), (0.05, -0.05), (-0.2, -0.3), (0.18, 0.18), (0.0, 0.0)] * 4:
        ride.go(2.5, right, left)
    tracks = ride.odometry.tracks
    assert tracks.rows.roundings[0] is rounding
    assert 1 / tracks.rows.means[0, states.RAMP] == pytest.approx(0.7, rel=0.03)
    assert tracks.goals(0.2, 0.2) == pytest.approx((0.204, 0.196), abs=0.0006)


def test_wheels_that_are_slow_to_stop_are_known_once_they_have_stopped() -> None:
    """Nobody takes them for wheels that stand, and then believes what they count backwards."""
    missed = 0.0
    for rounding, braking in product(ROUNDINGS, (0.3, 0.37, 0.5)):
        ride = Ride(rounding, config=replace(
            LAGGING, response=Response.RAMP, wheel_acceleration=0.9, braking=braking,
            dead_time=0.02))
        for seconds, right, left in [(8, 0.3, 0.28), (2, 0.0, 0.0), (2, 0.2, -0.2), (2, 0.0, 0.0)]:
            ride.go(seconds, right, left)
        missed += ride.miss[1]
    assert missed < 13  # of nine drives


def test_velocities_are_those_of_the_robot() -> None:
    ride = Ride(config=replace(IDEAL, right_speed_gain=0.97, left_speed_gain=0.97))
    for _ in range(4):
        ride.go(5, 0.2, 0.2)
        ride.go(2, -0.1, 0.1)
    estimate = ride.go(5, 0.2, 0.2)
    assert estimate.linear == pytest.approx(0.194, abs=0.001)
    assert estimate.angular == pytest.approx(0.0, abs=0.01)


def test_wheels_turn_as_the_base_moves() -> None:
    geometry, missed = Geometry(), []
    for rounding, more in product(ROUNDINGS, (0.15, 0.25)):
        ride = Ride(rounding, geometry=geometry)
        ride.learn()
        ride.go(2.5, more, -more)  # what is left of an error differs from lesson to lesson
        ride.go(2)
        begun, before = ride.estimates[-1], ride.body.truth().travelled
        estimate = ride.go(10, 0.2, 0.1)
        right = (estimate.right_wheel - begun.right_wheel) * geometry.wheel_radius
        left = (estimate.left_wheel - begun.left_wheel) * geometry.wheel_radius
        assert (right - left) / geometry.wheel_separation == pytest.approx(
            estimate.yaw - begun.yaw, abs=1e-6)
        assert estimate.right_wheel_speed * geometry.wheel_radius == pytest.approx(0.2, abs=0.005)
        assert estimate.left_wheel_speed * geometry.wheel_radius == pytest.approx(0.1, abs=0.005)
        missed.append((right + left) / 2 - (ride.body.truth().travelled - before))
    assert hypot(*missed) < 0.005 * sqrt(len(missed))


def test_scales_that_calibration_found_are_applied() -> None:
    config = replace(IDEAL, right_wheel_scale=1.05, left_wheel_scale=1.05)
    ride = Ride(config=config, geometry=Geometry(linear_scale=1.05, angular_scale=1.05))
    ride.go(20, 0.2, 0.15)
    ride.go(3)
    assert ride.miss[0] < 0.05
    assert ride.miss[1] < 1.5


def test_reset_begins_at_the_origin_and_keeps_what_was_learned() -> None:
    ride = Ride(Rounding.ROUND)
    for right, left in [(0.3, 0.1), (0.05, -0.05), (-0.2, -0.3), (0.0, 0.0)] * 4:
        ride.go(2.5, right, left)
    learned = ride.odometry.tracks.rows.roundings[0]
    wheel = ride.estimates[-1].right_wheel
    ride.odometry.reset()
    estimate = ride.odometry.estimate
    assert (estimate.x, estimate.y, estimate.yaw) == (0.0, 0.0, 0.0)
    assert estimate.right_wheel == wheel
    assert ride.odometry.tracks.rows.roundings[0] is learned
    before = ride.body.truth()
    estimate = ride.go(5, 0.2, 0.2)
    after = ride.body.truth()
    assert estimate.x == pytest.approx(after.travelled - before.travelled, abs=0.005)
    assert estimate.y == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize(('rounding', 'config', 'is_learned'), [
    (Rounding.TRUNCATE, replace(LAGGING, response=Response.RAMP, wheel_acceleration=0.4,
                                encoder_sign=EncoderSign.COMMAND), SignSource.REQUEST),
    (Rounding.CARRY, replace(LAGGING, encoder_sign=EncoderSign.TRUE), SignSource.MOTION)],
    ids=['ramps', 'true signs'])
def test_a_robot_that_is_another_one_for_good_is_learned_again(
        rounding: Rounding, config: BodyConfig, is_learned: SignSource) -> None:
    """Nobody told the odometry: its model explains nothing any more, so it tries all again."""
    ride = Ride(config=LAGGING)
    for right, left in REVERSALS * 10:
        ride.go(2.1, right, left)
    ride.body = Body(World(), rounding=rounding, config=config)
    for right, left in REVERSALS * 6:
        ride.go(2.1, right, left)
    assert ride.odometry.knowledge is not None
    assert ride.odometry.knowledge.likeliest == (rounding, is_learned)
    ride.begin()
    for right, left in REVERSALS * 3:
        ride.go(2.1, right, left)
    assert ride.miss[1] < 3  # of more than 1100


def test_a_request_that_moves_no_wheel_is_found_out() -> None:
    ride = Ride(config=replace(LAGGING, dead_band=0.01))
    ride.learn()
    ride.begin()
    ride.go(20, 0.006, 0.006)
    assert ride.odometry.tracks.requests == (0.006, 0.006)
    assert ride.odometry.tracks.rates == (0.0, 0.0)
    ride.go(20, 0.016, 0.016)
    ride.go(3)
    assert ride.miss[0] < 0.005  # of 0.3 m
    assert ride.odometry.knowledge is not None
    stands, moves = ride.odometry.knowledge.dead_band
    assert stands == 0.006
    assert moves == 0.016


def test_what_one_odometry_has_learned_another_can_start_with() -> None:
    config = replace(LAGGING, right_speed_gain=1.03, left_speed_gain=0.97)
    taught = Ride(config=config)
    assert Odometry(window=1.0).knowledge is None
    for right, left in REVERSALS * 5:
        taught.go(2.1, right, left)
    robot = taught.odometry.knowledge
    assert robot is not None
    assert robot.certain
    assert robot.likeliest == (Rounding.TRUNCATE, SignSource.DRIVE)
    for name, number in robot.numbers.items():
        least, most = number.range
        assert least <= getattr(robot, name).value <= most
    doubt = []
    for known in (None, robot):
        ride = Ride(config=config)
        ride.odometry = Odometry(window=1.0, robot=known)
        ride.go(5, 0.2, 0.2)
        ride.go(3, 0.1, -0.1)
        doubt.append(ride.go(3).pose_covariance[8])
        assert ride.miss[1] < 1.5
    assert doubt[1] < doubt[0] / 2
