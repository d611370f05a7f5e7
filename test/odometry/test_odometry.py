# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The odometry at its boundary: robots in memory, read as it asks."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from functools import cache
from itertools import cycle, pairwise
from math import degrees, hypot, isfinite, nan, pi, radians
from random import Random

import numpy as np
import pytest

from create_oi_ros.driver import Settings
from create_oi_ros.odometry import (
    Estimate,
    Geometry,
    GyroSettings,
    Increment,
    Knowledge,
    Odometry,
    Rounding,
)
from create_oi_ros.odometry.gyro import STEP
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import DEFAULT_BODY, EncoderSign
from create_oi_ros.sim.world import World
from odometry_cases import damaged_line
from support.loop import Loop

SLOT = 0.015


class Ride:
    """A robot, and an odometry that reads it two frames after it asks."""

    def __init__(self, rounding: Rounding = Rounding.TRUNCATE, config=DEFAULT_BODY,
                 slot: float = SLOT, **settings) -> None:
        self.body = Body(World(), rounding=rounding, config=config, seed=1)
        geometry = Geometry(angular_scale=config.encoder_separation / config.wheel_separation)
        self.odometry = Odometry(geometry, window=1.0, **settings)
        self.slot, self.steps, self.most = slot, [], 0.0
        self._due = [False, False]

    def go(self, right: float, left: float, seconds: float, *, lifted: bool = False,
           lost: bool = False) -> Estimate:
        """Drive for a while."""
        for _ in range(round(seconds / self.slot)):
            self.body.drive(right=right, left=left)
            self.body.step(self.slot)
            full = self._due.pop(0)
            estimate = self.odometry.update(Increment(
                self.slot, right, left, self.body.take_distance() if full else None,
                self.body.take_angle() if full else None, lifted, lost))
            self._due.append(self.odometry.reading_due)
            self.steps.append(estimate)
            off = abs(estimate.yaw - self.body.truth().turned)
            self.most = max(self.most, off / estimate.pose_covariance[8] ** 0.5)
        return self.steps[-1]

    def mixed(self, seed: int, seconds: float) -> 'Ride':
        """Drive arcs, turns, reversals and stops."""
        random = Random(seed)
        while seconds > 0:
            lasts = random.uniform(0.6, 3.0)
            speed, turn = random.uniform(-0.3, 0.3), random.choice((0.0, 0.1, -0.1, 0.18, -0.18))
            self.go(round(speed + turn, 3), round(speed - turn, 3), lasts)
            seconds -= lasts
        self.go(0.0, 0.0, 2.0)
        return self

    @property
    def off(self) -> tuple[float, float]:
        """Degrees and metres by which the estimate is off."""
        truth, e = self.body.truth(), self.steps[-1]
        return (degrees(abs(e.yaw - truth.turned)),
                hypot(e.x - truth.pose.x, e.y - truth.pose.y))


@pytest.mark.parametrize('rounding', Rounding)
def test_a_minute_and_a_half_of_mixed_driving_is_followed_without_a_jump(rounding):
    ride = Ride(rounding).mixed(3, 90.0)
    yaw, place = ride.off
    assert yaw < 6.0
    assert place < 0.2
    assert ride.most < 4.0
    for before, after in pairwise(ride.steps):
        assert abs(after.x - before.x) < 0.01
        assert abs(after.yaw - before.yaw) < 0.08
    for estimate in ride.steps[::20]:
        p = np.array(estimate.pose_covariance).reshape(3, 3)
        assert p == pytest.approx(p.T)
        assert (np.linalg.eigvalsh(p) > 0).all()
        assert min(estimate.twist_covariance) > 0
    known = ride.odometry.knowledge
    assert known is not None
    assert known.likeliest[0] is rounding


def test_frames_of_a_create_2_are_followed_as_well():
    ride = Ride(slot=0.015625).mixed(4, 60.0)
    assert ride.off[0] < 10.0
    assert ride.most < 4.0


def test_requests_within_the_dead_band_move_nothing():
    ride = Ride()
    ride.go(0.006, -0.006, 20.0)
    assert ride.off[0] < 1.0


def test_reversals_in_each_second_are_followed():
    ride = Ride()
    for _ in range(20):
        ride.go(0.15, -0.15, 1.0)
        ride.go(-0.15, 0.15, 1.0)
    ride.go(0.0, 0.0, 2.0)
    assert ride.off[0] < 5.0  # 40 reversals; one counted backwards is some ten degrees


def test_a_wheel_that_is_five_per_cent_slow_is_learned():
    ride = Ride(config=replace(DEFAULT_BODY, left_speed_gain=0.95)).mixed(7, 60.0)
    known = ride.odometry.knowledge
    assert known is not None
    assert known.left_gain.value == pytest.approx(0.95, abs=0.015)
    assert known.right_gain.value == pytest.approx(1.0, abs=0.015)


def test_held_wheels_are_noticed_by_the_next_reading_and_teach_nothing():
    ride = Ride().mixed(8, 40.0)
    before = ride.odometry.knowledge
    ride.body.hold(right=True, left=True)
    ride.go(0.2, 0.2, 4.0)
    ride.body.hold(right=False, left=False)
    ride.go(0.0, 0.0, 6.0)
    after = ride.odometry.knowledge
    assert before is not None and after is not None
    assert ride.off[1] < 0.3
    assert after.right_gain.value == pytest.approx(before.right_gain.value, abs=0.02)


def test_a_robot_that_is_pushed_is_followed_by_its_readings():
    ride = Ride(Rounding.CARRY)
    ride.go(0.0, 0.0, 2.0)
    ride.body.push(speed=0.2, rate=0.3, seconds=3.0)
    ride.go(0.0, 0.0, 10.0)
    assert ride.body.truth().pose.x > 0.3
    assert ride.off[0] < 5.0
    assert ride.off[1] < 0.1


def test_a_robot_that_is_lifted_goes_nowhere():
    ride = Ride()
    ride.go(0.0, 0.0, 1.0)
    ride.body.lift(True)
    before = ride.steps[-1]
    after = ride.go(0.3, 0.3, 3.0, lifted=True)
    assert hypot(after.x - before.x, after.y - before.y) < 0.005


def test_a_robot_that_is_lifted_while_it_drives_goes_on_from_there():
    ride = Ride(Rounding.CARRY).mixed(12, 60.0)
    yaw, place = ride.off
    for _ in range(4):
        ride.go(0.2, 0.1, 2.0)
        ride.body.lift(True)
        ride.go(0.0, 0.0, 2.0, lifted=True)
        ride.body.lift(False)
    ride.go(0.0, 0.0, 2.0)
    assert ride.off[0] - yaw < 3.0
    assert ride.off[1] - place < 0.15


def test_a_reading_that_was_lost_is_no_held_robot():
    ride = Ride().mixed(9, 30.0)
    ride.go(0.2, 0.2, 3.0)
    ride.body.take_distance(), ride.body.take_angle()
    ride.go(0.2, 0.2, 0.015, lost=True)
    ride.go(0.2, 0.2, 3.0)
    ride.go(0.0, 0.0, 3.0)
    assert ride.off[1] < 0.3


def test_what_a_robot_that_carries_has_lost_is_not_missed_by_later_readings():
    assert damaged_line(Rounding.CARRY, seed=2) < 1.0  # per cent of the way


def test_a_reading_after_a_reset_does_not_move_a_robot_that_stands():
    ride = Ride()
    ride.go(0.2, 0.1, 0.6)
    while ride.go(0.0, 0.0, SLOT).linear:
        pass
    ride.odometry.reset(1.0, 2.0, 0.5)
    for _ in range(200):
        assert ride.go(0.0, 0.0, SLOT)[:3] == pytest.approx((1.0, 2.0, 0.5), abs=1e-7)


def test_a_known_robot_is_followed_from_its_first_second():
    config = replace(DEFAULT_BODY, right_speed_gain=1.04, encoder_sign=EncoderSign.DRIVE)
    known = Ride(config=config).mixed(11, 90.0).odometry.knowledge
    ride = Ride(config=config, robot=known)
    turned, rolled = ride.go(0.15, -0.15, 5.0), 0.15 * 5.0 / Geometry().wheel_radius
    assert turned.right_wheel == pytest.approx(rolled, rel=0.1)
    assert turned.left_wheel == pytest.approx(-rolled, rel=0.1)
    ride.go(0.0, 0.0, 2.0)
    assert ride.off[0] < 3.0
    assert ride.most < 5.0


def test_the_reading_after_counts_began_anew_is_not_used_and_that_after_a_gap_is_believed():
    ends = {}
    for name, missed in (('interrupted', (2.0,)), ('recounted', ())):
        odometry = Odometry(window=1.0)
        odometry.update(Increment(SLOT, 0.0, 0.0, 0, 0))
        getattr(odometry, name)(*missed)
        odometry.update(Increment(SLOT, 0.0, 0.0, 500, 20))
        for _ in range(600):
            estimate = odometry.update(Increment(SLOT, 0.0, 0.0))
        ends[name] = estimate.x, estimate.yaw
    assert ends['recounted'] == pytest.approx((0.0, 0.0), abs=1e-3)
    assert ends['interrupted'] == pytest.approx((0.49, 0.357), abs=0.02)


def test_hurry_asks_for_a_reading_soon():
    odometry = Odometry(window=1.0)
    asked = []
    for frame in range(200):
        if frame == 150:
            odometry.hurry()
        odometry.update(Increment(SLOT, 0.0, 0.0, *((0, 0) if frame == 3 else ())))
        asked.append(odometry.reading_due)
    assert True in asked[150:162]


@pytest.mark.parametrize('dt', [0.002, 0.015625, 0.2, 2.0])
def test_any_input_leaves_finite_numbers(dt):
    odometry, random = Odometry(window=1.0), Random(1)
    for _ in range(60):
        reading = (random.randint(-32768, 32767), random.randint(-32768, 32767))
        estimate = odometry.update(Increment(
            dt, random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
            *(reading if random.random() < 0.3 else (None, None)), random.random() < 0.1,
            random.random() < 0.1, by_itself=random.random() < 0.3))
        assert np.isfinite([*estimate[:5], *estimate.pose_covariance]).all()
        assert abs(estimate.yaw) < 1e3 * pi


# A robot with a gyro: where wheels slip, and where the gyro fails.




class GyroRide:
    """A robot with a gyro, and odometries with and without it that read it as asked."""

    def __init__(self, volts: Callable[[float], float] = lambda volts: volts, *,
                 known: Knowledge | None = None, **config) -> None:
        self.body = Body(World(), config=replace(DEFAULT_BODY, gyro=True, **config), seed=4)
        self.gyro = Odometry(window=1.0, gyro=GyroSettings(), robot=known)
        self.wheels = Odometry(window=1.0, robot=known)
        self.volts = volts
        self.steps: list[float] = []

    def go(self, seconds: float, linear: float = 0.0, angular: float = 0.0, *,
           lifted: bool = False) -> 'GyroRide':
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

    def prove(self) -> 'GyroRide':
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
def first_proof() -> GyroRide:
    """Return a robot whose gyro is believed; no test drives it, each one a copy."""
    return GyroRide().prove()


@pytest.fixture
def ride() -> GyroRide:
    """Return a robot of its own whose gyro is believed."""
    return deepcopy(first_proof())


def known() -> Knowledge:
    """Return what is learned of a robot whose gyro is believed."""
    return first_proof().gyro.knowledge


def test_a_turn_in_which_wheels_slip_is_that_of_the_gyro(ride):
    assert ride.gyro.gyro.believed
    before = ride.off
    ride.body.slip(right=0.5, left=0.0, seconds=2.0)
    ride.go(4.0, 0.2).go(3.0)
    with_gyro, without = (now - was for now, was in zip(ride.off, before))
    assert abs(with_gyro) < 1.0 < 20.0 < abs(without)
    assert ride.gyro.gyro.slips


def test_a_robot_that_is_lifted_and_turned_knows_its_heading(ride):
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
    again = GyroRide(known=known(), right_slip=0.1, left_slip=0.1).go(10)
    assert again.gyro.gyro.believed
    before = again.off
    for _ in range(4):
        again.go(pi / 2 / 1.2, 0.0, 1.2).go(1.0)
    with_gyro, without = (now - was for now, was in zip(again.off, before))
    assert abs(with_gyro) < 3 < 20 < abs(without)


def test_a_heading_that_nobody_measures_is_not_moved_by_noise(ride):
    ride.go(20)
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
    ride = GyroRide(volts).prove()
    ride.go(2.0, 0.0, 1.2)
    assert why in ride.gyro.gyro.problem
    assert ride.gyro.estimate == ride.wheels.estimate
    assert ride.gyro.knowledge.gyro is None


def test_a_gyro_that_is_upside_down_is_noticed():
    ride = GyroRide(lambda volts: 5 - volts).prove().prove()
    assert ride.gyro.gyro.believed
    assert ride.gyro.knowledge.gyro.scale.value < 0


def test_a_gyro_that_falls_off_is_not_believed_any_more(ride):
    broken = Random(2)
    before = ride.off[0]
    ride.volts = lambda volts: broken.randrange(1024) * STEP
    ride.go(2.0, 0.0, 1.2).go(4.0, 0.1).go(3.0)
    assert 'jumps' in ride.gyro.gyro.problem
    assert abs(ride.off[0] - before) < 3


def test_a_turn_beyond_the_range_is_that_of_the_wheels(ride):
    before = ride.off[0]
    ride.go(2.0, 0.0, 3.5).go(3.0)
    assert abs(ride.off[0] - before) < 3


def test_a_zero_that_has_moved_is_learned_anew(ride):
    ride.volts = lambda volts: volts + 0.1
    ride.go(30)
    before = ride.gyro.estimate.yaw
    ride.go(20)
    assert ride.gyro.gyro.believed
    assert abs(ride.gyro.estimate.yaw - before) < radians(1)


def test_another_pose_is_where_it_goes_on(ride):
    ride.go(0.5, 0.0, 1.0)
    ride.gyro.reset(1.0, 2.0, 0.5)
    ride.gyro.start_trip()  # no frame has come since
    was = ride.body.truth().turned
    assert ride.gyro.estimate[:3] == (1.0, 2.0, 0.5)
    ride.go(3.0, 0.0, 1.0).go(2.0)
    assert ride.gyro.estimate.yaw - 0.5 == pytest.approx(ride.body.truth().turned - was, abs=0.03)


def test_frames_without_the_voltage_do_not_end_the_belief_in_a_gyro():
    missing = cycle((True, *19 * (False,)))
    ride = GyroRide(lambda volts: nan if next(missing) else volts).prove()
    assert ride.gyro.gyro.believed and all(map(isfinite, ride.gyro.estimate.pose_covariance))


@pytest.mark.parametrize('part', [0.56, 1.5, 0.75])
def test_another_gyro_than_the_known_one_must_prove_itself(part):
    ride = GyroRide(lambda volts: 2.5 + part * (volts - 2.5), known=known()).go(10)
    for _ in range(6):
        ride.go(pi / 2 / 1.2, 0.0, 1.2).go(2.5)
        assert abs(ride.off[0]) < 5.0
    assert ride.gyro.gyro.problem is not None


def test_a_run_without_the_gyro_keeps_what_is_known_of_it():
    odometry = Odometry(window=1.0, robot=replace(known(), readings=321))
    odometry.update(Increment(SLOT, 0.1, 0.1))
    assert odometry.knowledge.gyro == known().gyro
    assert odometry.knowledge.readings == 321
