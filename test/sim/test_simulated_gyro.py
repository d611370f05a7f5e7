# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated gyro: an ADXRS613 on ten bits."""

from dataclasses import replace
from math import degrees, radians
from statistics import mean, stdev

import pytest

from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.body.gyro import Gyro
from create_oi_ros.sim.world import World

UNITS = 1023 / 5 * 0.0125
"""Of packet 33, for each degree a second."""
SEEDS = range(40)


def read(seed: int, rate: float, time: float = 0.0, count: int = 400) -> list[int]:
    gyro = Gyro(seed)
    return [gyro.read(radians(rate), time) for _ in range(count)]


def test_each_robot_has_another_zero_and_scale_within_the_tolerances_of_the_part():
    zeros = [mean(read(seed, 0.0)) for seed in SEEDS]
    scales = [(mean(read(seed, 100.0)) - zero) / 100 / UNITS for seed, zero in zip(SEEDS, zeros)]
    assert 490 < min(zeros) < 505 < 519 < max(zeros) < 534
    assert 0.948 < min(scales) < 0.98 < 1.02 < max(scales) < 1.052


def test_it_is_noisy_drifts_and_ends_at_its_range():
    assert stdev(read(1, 0.0)) == pytest.approx(1.0, abs=0.2)
    drift = (mean(read(1, 0.0, time=3600.0)) - mean(read(1, 0.0))) / UNITS
    assert abs(drift) == pytest.approx(0.02 * 60, abs=0.05)
    assert mean(read(1, 200.0)) == pytest.approx(mean(read(1, 150.0)), abs=0.2)
    assert mean(read(1, -200.0)) == pytest.approx(mean(read(1, -150.0)), abs=0.2)


def test_it_feels_wheels_and_hands_and_is_there_only_on_request():
    body = Body(World(), config=replace(DEFAULT_BODY, gyro=True))
    zero = body.sense().analog
    body.drive(right=0.1, left=-0.1)
    body.step(2.0)
    turning = body.sense().analog - zero
    assert turning / UNITS == pytest.approx(degrees(0.2 / 0.262), rel=0.1)
    body.drive(right=0.0, left=0.0)
    body.lift(True)
    body.push(speed=0.0, rate=-1.0, seconds=1.0)
    body.step(0.5)
    assert (body.sense().analog - zero) / UNITS == pytest.approx(-degrees(1.0), rel=0.1)
    assert Body(World()).sense().analog == 0
