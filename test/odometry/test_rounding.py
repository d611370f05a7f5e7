# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a whole number says about the amount behind it."""

from math import exp, inf, sqrt, tau

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.odometry.rounding import cut_normal, interval, telling_in
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.mechanics import Accumulator
from support.ride import ROUNDINGS


@given(st.floats(-60, 60), st.floats(1e-4, 50))
def test_what_is_cut_from_a_normal_lies_inside_the_cut(low: float, width: float) -> None:
    mean, variance, mass = cut_normal(low, low + width)
    slack = 1e-6 * (1 + abs(low))
    assert low - slack <= mean <= low + width + slack
    assert 0 < variance <= min(1.0, width * width / 12 * 1.01) + 1e-9
    assert 0 <= mass <= 1


@pytest.mark.parametrize(('low', 'high', 'mean', 'variance', 'mass'), [
    (-1.0, 1.0, 0.0, 0.291125, 0.682689), (2.0, 3.0, 2.315819, 0.06152, 0.0214),
    (-9.0, -8.0, -8.1212, 0.01415, 6.2e-16), (-50.0, 50.0, 0.0, 1.0, 1.0),
    (-20.00001, -20.0, -20.000005, 8.3e-12, 5.52e-93), (0.5, 0.5001, 0.50005, 8.3e-10, 3.52e-5),
    (-200.0, -10.0, -10.0981, 0.00944, 7.62e-24)])
def test_moments_of_a_cut_normal(
        low: float, high: float, mean: float, variance: float, mass: float) -> None:
    """The expected values were integrated numerically."""
    found = cut_normal(low, high)
    assert found[0] == pytest.approx(mean, abs=0.005)
    assert found[1] == pytest.approx(variance, abs=0.002)
    assert found[2] == pytest.approx(mass, rel=0.02, abs=0)


@pytest.mark.parametrize('high', [-30.0, -6.5, -0.5, 0.25, 7.0])
@pytest.mark.parametrize('width', [1e-6, 1e-5])
def test_a_narrow_piece_is_flat(high: float, width: float) -> None:
    mean, variance, mass = cut_normal(high - width, high)
    assert mean == pytest.approx(high - width / 2, abs=width / 100)
    assert variance == pytest.approx(width * width / 12, rel=0.01, abs=0)
    assert mass == pytest.approx(width * exp(-high * high / 2) / sqrt(tau), rel=0.01, abs=0)


@pytest.mark.parametrize('side', [1, -1])
def test_a_tail_without_end_falls_like_an_exponential(side: int) -> None:
    low, high = sorted((side * 10.0, side * 1e6))
    mean, variance, mass = cut_normal(low, high)
    assert mean == pytest.approx(side * 10.098, abs=0.003)
    assert variance == pytest.approx(0.0095, abs=0.0006)
    assert mass == pytest.approx(7.62e-24, rel=0.02, abs=0)


@pytest.mark.parametrize(('rounding', 'whole', 'ends'), [
    (Rounding.ROUND, 5, (4.5, 5.5)), (Rounding.ROUND, -5, (-5.5, -4.5)),
    (Rounding.ROUND, 0, (-0.5, 0.5)),
    *((rounding, whole, ends) for rounding in (Rounding.CARRY, Rounding.TRUNCATE)
      for whole, ends in ((5, (5.0, 6.0)), (1, (1.0, 2.0)), (0, (-1.0, 1.0)), (-1, (-2.0, -1.0)),
                          (-5, (-6.0, -5.0))))])
def test_an_interval_is_no_wider_than_its_number(
        rounding: Rounding, whole: int, ends: tuple[float, float]) -> None:
    assert interval(rounding, whole) == ends


@given(st.floats(-50, 50), st.sampled_from(ROUNDINGS))
def test_an_interval_holds_whatever_rounds_to_its_number(
        amount: float, rounding: Rounding) -> None:
    accumulator = Accumulator(rounding)
    accumulator.add(amount)
    low, high = interval(rounding, accumulator.take())
    assert low - 1e-5 <= amount <= high + 1e-5


@pytest.mark.parametrize(('rounding', 'amount', 'rate', 'seconds'), [
    (Rounding.TRUNCATE, 2.5, 0.5, 0.8), (Rounding.TRUNCATE, 2.5, -0.5, 0.8),
    (Rounding.TRUNCATE, -2.25, -0.5, 1.3), (Rounding.TRUNCATE, -2.25, 0.5, 0.3),
    (Rounding.TRUNCATE, 0.25, -0.5, 2.3),
    (Rounding.ROUND, 2.0, 0.5, 0.8), (Rounding.ROUND, -2.25, -0.5, 0.3),
    (Rounding.TRUNCATE, 2.7, -0.5, 1.2), (Rounding.ROUND, 2.7, 0.5, 1.4),
    (Rounding.TRUNCATE, 2.95, 0.5, 0.0), (Rounding.TRUNCATE, 2.05, 0.5, 0.0),
    (Rounding.ROUND, 2.5, 0.0, 0.0), (Rounding.ROUND, 2.0, 0.0, inf)])
def test_an_amount_tells_most_where_another_whole_number_begins(
        rounding: Rounding, amount: float, rate: float, seconds: float) -> None:
    assert telling_in(rounding, amount, rate, 0.1) == pytest.approx(seconds)
