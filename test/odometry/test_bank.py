# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The bank of Kalman filters, and what an integer says."""

import numpy as np
import pytest

from create_oi_ros.odometry import Geometry
from create_oi_ros.odometry.bank import _cumulative, _cut, Bank, interval, Motion
from create_oi_ros.robot import Rounding


@pytest.mark.parametrize(('value', 'ends'), [
    (3.0, {Rounding.TRUNCATE: (3, 4), Rounding.CARRY: (3, 4), Rounding.ROUND: (2.5, 3.5)}),
    (-3.0, {Rounding.TRUNCATE: (-4, -3), Rounding.CARRY: (-4, -3), Rounding.ROUND: (-3.5, -2.5)}),
    (0.0, {Rounding.TRUNCATE: (-1, 1), Rounding.CARRY: (-1, 1), Rounding.ROUND: (-0.5, 0.5)})])
def test_a_whole_number_is_an_interval(value, ends):
    assert {each: interval(value, each) for each in Rounding} == ends


@pytest.mark.parametrize(('low', 'high'), [(-0.5, 0.5), (0.2, 1.5), (-3.0, 1.0), (-9.0, 9.0)])
def test_a_normal_distribution_that_is_cut_has_the_mean_and_variance_of_its_samples(low, high):
    samples = np.random.default_rng(1).normal(size=400_000)
    inside = samples[(samples > low) & (samples < high)]
    mean, kept, log = _cut(np.array(low), np.array(high))
    assert mean == pytest.approx(inside.mean(), abs=0.005)
    assert kept == pytest.approx(inside.var(), abs=0.01)
    assert np.exp(log) == pytest.approx(len(inside) / len(samples), abs=0.005)


def test_far_outside_its_interval_a_prediction_is_drawn_to_it():
    mean, kept, log = _cut(np.array(8.0), np.array(9.0))
    assert 7 < mean < 9
    assert 0 < kept < 1
    assert log < -20
    assert _cumulative(np.array(50.0)) == 1.0


def test_absurd_readings_leave_finite_numbers():
    bank = Bank(Geometry())
    random = np.random.default_rng(1)
    for _ in range(40):
        bank.roll(random.uniform(0.002, 2.0), tuple(random.uniform(-0.5, 0.5, 2).tolist()))
        reading = random.integers(-32768, 32767, 2).astype(float)
        bank.read(reading, Motion(0.0, 0.0, 0.0, 0.0, 1.0))
        assert np.isfinite(bank.pose).all()
        assert np.isfinite(bank.covariance).all()
        assert (np.linalg.eigvalsh(bank.covariance) >= -1e-9).all()


def test_readings_in_a_row_weigh_roundings_and_nothing_else():
    """2 mm are read in each frame of 2.55 mm."""
    bank = Bank(Geometry())
    for _ in range(200):
        bank.roll(0.015, (0.17, 0.17))
    bank.read(np.array([0.0, 450.0]), Motion(0.45, 0.0, 0.0, 0.45, 3.0))
    before = bank.weights
    for _ in range(8):
        bank.roll(0.015, (0.17, 0.17))
        bank.read(np.array([0.0, 2.0]), Motion(0.00255, 0.0, 0.0, 0.00255, 0.015))
    assert bank.rounding[Rounding.CARRY] < 0.001
    within, after = (each / each.sum(axis=(0, 1, 3), keepdims=True)
                     for each in (before, bank.weights))
    assert after == pytest.approx(within)
