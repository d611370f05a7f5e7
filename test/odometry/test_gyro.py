# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The odometry of a robot with a gyro: where wheels slip, and where the gyro fails."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from functools import cache
from itertools import cycle
from math import degrees, isfinite, nan, pi, radians
from random import Random

import pytest

from create_oi_ros.driver import Settings
from create_oi_ros.odometry import GyroSettings, Increment, Knowledge, Odometry
from create_oi_ros.odometry.gyro import STEP
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.world import World
from support.loop import Loop

SLOT = 0.015
SEED = 4


class Ride:
    """A robot with a gyro, and odometries with and without it that read it as asked."""

    def __init__(self, volts: Callable[[float], float] = lambda volts: volts, *,
                 known: Knowledge | None = None, **config) -> None:
        self.body = Body(World(), config=replace(DEFAULT_BODY, gyro=True, **config), seed=SEED)
        self.gyro = Odometry(window=1.0, gyro=GyroSettings(), robot=known)
        self.wheels = Odometry(window=1.0, robot=known)
        self.volts = volts
        self.steps: list[float] = []

    def go(self, seconds: float, linear: float = 0.0, angular: float = 0.0, *,
           lifted: bool = False) -> 'Ride':
        """Drive for a while."""
        right, left = (round(linear + sign * angular * 0.129, 3) for sign in (1, -1))
        for _ in range(round(seconds / SLOT)):
            self.body.drive(right=right, left=left)
            due, before = self.gyro.reading_due, self.gyro.estimate.yaw
            self.body.step(SLOT)
            increment = Increment(
                SLOT, right, left, lifted=lifted,
                distance=self.body.take_distance() if due else None,
                angle=self.body.take_angle() if due else None,
                analog=self.volts(self.body.sense().analog * STEP))
            self.gyro.update(increment)
            self.wheels.update(increment)
            self.steps.append(abs(self.gyro.estimate.yaw - before))
        return self

    def prove(self) -> 'Ride':
        """Stand, and turn until the gyro is believed."""
        self.go(10)
        for sign in (1, -1, 1, -1):
            self.go(2.5, 0.0, sign * 1.2).go(1.5)
        return self

    @property
    def off(self) -> tuple[float, float]:
        """Degrees by which the heading is off with the gyro, and without."""
        truth = self.body.truth().turned
        return (degrees(self.gyro.estimate.yaw - truth), degrees(self.wheels.estimate.yaw - truth))


@cache
def first_proof() -> Ride:
    """Return a robot whose gyro is believed; no test drives it, each one a copy."""
    return Ride().prove()


def proven() -> Ride:
    """Return a robot of its own whose gyro is believed."""
    return deepcopy(first_proof())


def known() -> Knowledge:
    """Return what is learned of a robot whose gyro is believed."""
    return first_proof().gyro.knowledge


def test_a_turn_in_which_wheels_slip_is_that_of_the_gyro():
    ride = proven()
    assert ride.gyro.gyro.believed
    before = ride.off
    ride.body.slip(right=0.5, left=0.0, seconds=2.0)
    ride.go(4.0, 0.2).go(3.0)
    with_gyro, without = (now - was for now, was in zip(ride.off, before))
    assert abs(with_gyro) < 1.0 < 20.0 < abs(without)
    assert ride.gyro.gyro.slips


def test_a_robot_that_is_lifted_and_turned_knows_its_heading():
    ride = proven()
    before = ride.off
    ride.body.lift(True)
    ride.body.push(speed=0.0, rate=1.0, seconds=1.5)
    ride.go(3.0, lifted=True)
    ride.body.lift(False)
    ride.go(3.0)
    with_gyro, without = (now - was for now, was in zip(ride.off, before))
    assert abs(with_gyro) < 1.5 < 80.0 < abs(without)
    assert max(ride.steps) < 1.1 * SLOT + radians(1), 'no jump'


def test_a_robot_that_is_turned_slowly_by_its_bumper_knows_its_heading():
    loop = Loop(Settings(gyro=GyroSettings(), robot=known()),
                config=replace(DEFAULT_BODY, gyro=True))
    loop.run(30)
    assert loop.driver.health(loop.now).gyro.believed
    before = loop.estimate.yaw
    loop.body.force(bump_left=1)
    loop.forged = {'analog_signal': loop.body.sense().analog + 20}
    loop.run(30)
    assert loop.estimate.yaw - before == pytest.approx(30 * 20 * STEP * radians(80), rel=0.1)
    assert loop.driver.health(loop.now).gyro.slips == 0
    loop.forged = {'analog_signal': 1024}  # a value that no Create has
    loop.run(1)
    loop.forged = {}
    loop.run(1)
    assert isfinite(loop.estimate.yaw)


def test_a_gyro_that_was_checked_is_believed_once_the_robot_has_stood():
    assert known().gyro.scale.value == pytest.approx(80, rel=0.06)
    again = Ride(known=known(), right_slip=0.1, left_slip=0.1).go(10)
    assert again.gyro.gyro.believed
    before = again.off
    for _ in range(4):
        again.go(pi / 2 / 1.2, 0.0, 1.2).go(1.0)
    with_gyro, without = (now - was for now, was in zip(again.off, before))
    assert abs(with_gyro) < 3 < 20 < abs(without)


def test_a_heading_that_nobody_measures_is_not_moved_by_noise():
    ride = proven().go(20)
    ride.steps.clear()
    ride.go(10)
    assert sum(ride.steps) < radians(0.3)
    assert ride.gyro.estimate.pose_covariance[8] > 0


FLOATING = Random(1)


@pytest.mark.parametrize(('volts', 'why'), [
    (lambda volts: 2.5, 'stays at 2.50 V'),
    (lambda volts: 0.0, 'beyond its range'),
    (lambda volts: 5.0, 'beyond its range'),
    (lambda volts: FLOATING.randrange(1024) * STEP, 'jumps'),
    (lambda volts: 2.5 + FLOATING.choice((0, STEP)), 'does not follow'),
    (lambda volts: nan, 'without packet 33'),
], ids=['constant', '0 V', '5 V', 'floating', 'noise only', 'not in the frames'])
def test_a_gyro_that_cannot_be_right_changes_nothing(volts, why):
    ride = Ride(volts).prove()
    ride.go(2.0, 0.0, 1.2)
    assert why in ride.gyro.gyro.problem
    assert ride.gyro.estimate == ride.wheels.estimate
    assert ride.gyro.knowledge.gyro is None


def test_a_gyro_that_is_upside_down_is_noticed():
    ride = Ride(lambda volts: 5 - volts).prove().prove()
    assert ride.gyro.gyro.believed
    assert ride.gyro.knowledge.gyro.scale.value < 0


def test_a_gyro_that_falls_off_is_not_believed_any_more():
    broken = Random(2)
    ride = proven()
    before = ride.off[0]
    ride.volts = lambda volts: broken.randrange(1024) * STEP
    ride.go(2.0, 0.0, 1.2).go(4.0, 0.1).go(3.0)
    assert 'jumps' in ride.gyro.gyro.problem
    assert abs(ride.off[0] - before) < 3


def test_a_turn_beyond_the_range_is_that_of_the_wheels():
    ride = proven()
    before = ride.off[0]
    ride.go(2.0, 0.0, 3.5).go(3.0)
    assert abs(ride.off[0] - before) < 3


def test_a_zero_that_has_moved_is_learned_anew():
    ride = proven()
    ride.volts = lambda volts: volts + 0.1
    ride.go(30)
    before = ride.gyro.estimate.yaw
    ride.go(20)
    assert ride.gyro.gyro.believed
    assert abs(ride.gyro.estimate.yaw - before) < radians(1)


def test_another_pose_is_where_it_goes_on():
    ride = proven().go(0.5, 0.0, 1.0)
    ride.gyro.reset(1.0, 2.0, 0.5)
    ride.gyro.start_trip()  # no frame has come since
    was = ride.body.truth().turned
    assert ride.gyro.estimate[:3] == (1.0, 2.0, 0.5)
    ride.go(3.0, 0.0, 1.0).go(2.0)
    assert ride.gyro.estimate.yaw - 0.5 == pytest.approx(ride.body.truth().turned - was, abs=0.03)


def test_frames_without_the_voltage_do_not_end_the_belief_in_a_gyro():
    missing = cycle((True, *19 * (False,)))
    ride = Ride(lambda volts: nan if next(missing) else volts).prove()
    assert ride.gyro.gyro.believed and all(map(isfinite, ride.gyro.estimate.pose_covariance))


@pytest.mark.parametrize('part', [0.56, 1.5, 0.75])
def test_another_gyro_than_the_known_one_must_prove_itself(part):
    ride = Ride(lambda volts: 2.5 + part * (volts - 2.5), known=known()).go(10)
    for _ in range(6):
        ride.go(pi / 2 / 1.2, 0.0, 1.2).go(2.5)
        assert abs(ride.off[0]) < 5.0
    assert ride.gyro.gyro.problem is not None


def test_a_run_without_the_gyro_keeps_what_is_known_of_it():
    odometry = Odometry(window=1.0, robot=replace(known(), readings=321))
    odometry.update(Increment(SLOT, 0.1, 0.1))
    assert odometry.knowledge.gyro == known().gyro
    assert odometry.knowledge.readings == 321
