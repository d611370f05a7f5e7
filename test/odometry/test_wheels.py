# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Hypotheses of wheels, simulated side by side."""

import numpy as np
import pytest

from create_oi_ros.odometry.hypotheses import (
    Hypothesis,
    numbers_of,
    Response,
    SIGNS,
    SignSource,
    STARTS,
    with_numbers,
)
from create_oi_ros.odometry.wheels import STEP, Wheels

LAG = Hypothesis(Response.LAG, 0.2, 0.0, 0.1, 1.0, 0.0, 0.005)
SPEED = 0.2


def rolled(row: Hypothesis, seconds: float, request=(SPEED, SPEED), dt: float = 0.015) -> Wheels:
    """Return wheels of one kind after some time under a request."""
    wheels = Wheels([row])
    for _ in range(round(seconds / dt)):
        wheels.roll(dt, request)
    wheels.flush()
    return wheels


@pytest.mark.parametrize(('row', 'late'), [
    (LAG, 0.2), (LAG._replace(dead_time=0.04), 0.24),
    (LAG._replace(time=0.15, of_speed=1.0), 0.075),
    (LAG._replace(response=Response.RAMP, time=1.0), 0.1),
    (LAG._replace(response=Response.SPRING, time=0.06, overshoot=0.3), 0.043)])
@pytest.mark.parametrize('dt', [0.002, 0.015, 0.015625])
def test_wheels_are_as_late_as_their_response_says(row, late, dt):
    wheels = rolled(row, 3.0, dt=dt)
    assert wheels.true[0, 0, 0] == pytest.approx(SPEED * (round(3 / dt) * dt - late), abs=5e-4)
    assert wheels.speed[0, 0, 0] == pytest.approx(SPEED, abs=2e-5)


@pytest.mark.parametrize('speed', [0.1, 0.2, 0.4])
def test_wheels_whose_time_goes_with_the_speed_coast_as_far_at_any(speed):
    row = LAG._replace(time=0.15, of_speed=1.0)
    wheels = rolled(row, 3.0, (speed, speed))
    wheels.begin_window()
    for _ in range(200):
        wheels.roll(0.015, (0.0, 0.0))
    assert wheels.true[0, 0, 0] == pytest.approx(0.015, abs=2e-4)
    assert wheels.rests


def test_a_request_below_the_dead_band_moves_nothing():
    assert not rolled(LAG._replace(dead_band=0.02), 1.0, (0.019, -0.019)).true.any()


@pytest.mark.parametrize('seconds', [0.3, 5.0])
def test_wheels_that_are_lifted_count_but_take_the_robot_nowhere(seconds):
    wheels = rolled(LAG, seconds)
    before, counted = wheels.true.copy(), wheels.counted.copy()
    for _ in range(20):
        wheels.roll(0.015, (SPEED, SPEED), lifted=True)
    wheels.flush()
    assert wheels.true == pytest.approx(before)
    assert (wheels.counted > counted + 0.01).all()


def after_turning_back(row: Hypothesis, source: SignSource, *requests: float) -> tuple:
    """Return what a wheel rolls, its counts and what of these is not sure, in a last frame."""
    wheels = rolled(row, 2.0, (requests[0], requests[0]))
    wheels.begin_window()
    wheels.roll(0.015, (requests[1], requests[1]))
    which = SIGNS.index(source)
    return (float(wheels.true[0, 0, 0]), float(wheels.counted[which, 0, 0, 0]),
            float(wheels.unsure[which, 0, 0, 0]))


@pytest.mark.parametrize(('source', 'counted'), [
    (SignSource.MOTION, 1), (SignSource.DRIVE, -1), (SignSource.LAST_REQUEST, -1),
    (SignSource.REQUEST, -1)])
def test_an_encoder_takes_its_sign_from_the_motion_or_the_request(source, counted):
    true, count, unsure = after_turning_back(LAG, source, SPEED, -SPEED)
    assert true > 0
    assert count == pytest.approx(counted * true)
    assert bool(unsure > 0) is (counted < 0)


@pytest.mark.parametrize(('source', 'counted'), [
    (SignSource.LAST_REQUEST, -1), (SignSource.REQUEST, 1)])
def test_a_wheel_told_to_stop_counts_as_before_or_forwards(source, counted):
    assert np.sign(after_turning_back(LAG, source, -SPEED, 0.0)[1]) == counted


def test_a_wheel_that_coasts_under_too_slow_a_request_backwards_has_an_unknown_sign():
    row = LAG._replace(dead_band=0.01)
    true, _, unsure = after_turning_back(row, SignSource.LAST_REQUEST, SPEED, -0.008)
    assert unsure >= true
    assert after_turning_back(row, SignSource.MOTION, SPEED, -0.008)[2] == 0


def test_steady_wheels_go_on_without_being_simulated():
    wheels = rolled(LAG, 5.0)
    before, counted = wheels.true.copy(), wheels.counted.copy()
    assert wheels.roll(0.5, (SPEED, SPEED)) is None
    wheels.flush()
    assert wheels.true == pytest.approx(before + SPEED * 0.5, abs=1e-5)
    assert wheels.counted == pytest.approx(counted + SPEED * 0.5, abs=1e-5)


@pytest.mark.parametrize('row', [
    LAG._replace(of_speed=0.5), LAG._replace(response=Response.SPRING, time=0.06, overshoot=0.3),
    LAG._replace(response=Response.RAMP, time=1.0)])
def test_a_copy_shows_what_another_number_would_do(row):
    """The way while a wheel speeds up, stops, and what a hypothesis with that number does."""
    def way(one: Hypothesis) -> np.ndarray:
        wheels = rolled(one, 0.4)
        for _ in range(20):
            wheels.roll(0.015, (0.0, 0.0))
        return wheels.true[0, :, 0].copy()
    copies, numbers = way(row), numbers_of(row)
    for i, step in enumerate(STEP):
        other = with_numbers(
            row, [each + step * (i == j) for j, each in enumerate(numbers)], row.sign)
        assert way(other)[0] == pytest.approx(copies[i + 1], abs=1e-9)


def test_wheels_that_believe_in_other_numbers_go_on_as_if_they_always_had():
    before, other = LAG._replace(of_speed=0.0), LAG._replace(time=0.21)
    wheels, there = rolled(before, 0.3), rolled(other, 0.3)
    wheels.begin_window()
    wheels.move(np.array([numbers_of(other)]), np.ones((1, 2)))
    assert wheels.speed[0, 0, 0] == pytest.approx(there.speed[0, 0, 0], abs=2e-4)


def test_some_hypotheses_and_sources_of_signs_are_kept():
    wheels = Wheels([LAG, LAG._replace(time=0.1)])
    wheels.roll(0.015, (SPEED, SPEED))
    fast = wheels.true[1].copy()
    wheels.keep(np.array([1]), np.array([1, 2]))
    assert wheels.true == pytest.approx(fast[None])
    assert wheels.counted.shape[:2] == (2, 1)
    wheels.roll(0.015, (SPEED, SPEED))
    assert wheels.true.shape[0] == 1 and wheels.counted.shape[:2] == (2, 1)


def test_hypotheses_at_the_start_have_every_response():
    assert {row.response for row in STARTS} == set(Response)
