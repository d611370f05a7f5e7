# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How readings that were not expected become doubt of the model, by sums done by hand."""

from math import cos, exp, sin

import numpy as np
import pytest

from create_oi_ros.odometry import accumulators
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.doubt import Doubt
from create_oi_ros.odometry.states import DEGREE, MM

SCALES = 1.1, 0.9
YAW = 0.6


def one_track(doubt: float = 2.0, readings: int = 0) -> Assumptions:
    """Return a track that expects a reading of zero."""
    rows = Assumptions.all()
    rows.keep([20])  # one that carries fractions or rounds: zero is in the middle of its interval
    rows.p[:] = 0.0
    rows.p[:, s.DISTANCE, s.DISTANCE], rows.p[:, s.ANGLE, s.ANGLE] = MM ** 2, DEGREE ** 2
    rows.means[:, s.YAW] = YAW
    rows.doubt[:], rows.readings = doubt, readings
    return rows


def met(rows: Assumptions, z: tuple[float, float], share: float = 0.5) -> tuple[Doubt, np.ndarray]:
    """Meet a reading of zero that is so many standard deviations from what is expected."""
    _, spreads = accumulators.innovation(rows, (0, 0))
    rows.means[:, [s.DISTANCE, s.ANGLE]] = -np.array(z) * spreads[:, 0]
    gaps, spreads = accumulators.innovation(rows, (0, 0))
    middle = gaps[:, 0] / spreads[:, 0] - np.array(z)  # of an interval that is not even
    rows.means[:, [s.DISTANCE, s.ANGLE]] += middle * spreads[:, 0]
    doubt = Doubt()
    return doubt, doubt.meet(rows, (0, 0), share * spreads ** 2, SCALES)


@pytest.mark.parametrize(('z', 'growth'), [
    ((1.0, 1.0), 0.0), ((0.0, 0.0), -1.0), ((2.0, 1.0), 1.5), ((1.0, -2.0), 1.5),
    ((2.0, 2.0), 3.0), ((2.9, 1.0), 3.0), ((0.5, 1.0), -0.375)])
@pytest.mark.parametrize('before', [1.0, 2.0])
def test_doubt_follows_the_squares_of_innovations_and_fades(z, growth, before):
    rows = one_track(before)
    doubt, left = met(rows, z)
    assert rows.doubt == pytest.approx([before ** 0.96 * exp(0.3 * growth)])
    assert not doubt.is_surprised and not left.any()
    assert np.count_nonzero(rows.p) == 2


@pytest.mark.parametrize(('readings', 'z', 'growth'), [
    (31, (2.5, 0.0), 0.2 * 2.25), (30, (2.5, 0.0), 0.0), (31, (2.0, 0.0), 0.0),
    (31, (9.0, 9.0), 0.2 * 12)])
def test_what_is_odd_is_doubt_once_a_robot_is_not_new(readings, z, growth):
    rows = one_track(readings=readings)
    met(rows, z, share=0.0)
    assert rows.doubt == pytest.approx([2.0 ** 0.96 * exp(0.3 * growth)])


@pytest.mark.parametrize(('doubt', 'z', 'end'), [(0.3, 0.0, 0.3), (1e4, 9.0, 1e4)])
def test_doubt_has_bounds(doubt, z, end):
    rows = one_track(doubt)
    met(rows, (z, z))
    assert rows.doubt.tolist() == [end]


def test_a_surprise_leaves_two_deviations_of_itself():
    rows = one_track()
    before = rows.p[0].copy()
    doubt, left = met(rows, (4.0, 2.9))
    assert doubt.is_surprised and left == pytest.approx([-2.0])
    _, spreads = accumulators.innovation(one_track(), (0, 0))
    more = 3 * spreads[0, 0] ** 2  # (4 / 2)² - 1
    g = np.zeros(s.SIZE)
    g[s.X], g[s.Y], g[s.DISTANCE] = 1.1 * cos(YAW), 1.1 * sin(YAW), 1.0
    assert rows.p[0] - before == pytest.approx(more * np.outer(g, g))


def test_a_surprise_of_the_angle_leaves_the_way_alone():
    rows = one_track()
    before = rows.p[0].copy()
    doubt, left = met(rows, (0.0, -3.4))
    assert doubt.is_surprised and left == pytest.approx([-0.8])
    _, spreads = accumulators.innovation(one_track(), (0, 0))
    g = np.zeros(s.SIZE)
    g[s.YAW], g[s.ANGLE] = 0.9, 1.0
    assert rows.p[0] - before == pytest.approx(
        (1.7 ** 2 - 1) * spreads[1, 0] ** 2 * np.outer(g, g))


def test_a_surprise_costs_a_track_three_at_most():
    assert met(one_track(), (99.0, 0.0))[1].tolist() == [-3.0]


def rethought(doubts: list[float], *, free: bool = False) -> list[int]:
    """Return after which readings everything is tried again."""
    doubt, again = Doubt(), []
    for reading, each in enumerate(doubts, 1):
        rows = one_track(each)
        doubt.rethink(rows, free=free)
        if len(rows.weights) > 1:
            again.append(reading)
    return again


def test_all_is_tried_again_when_twelve_readings_in_a_row_were_not_explained():
    assert rethought(12 * [4.1]) == [12]
    assert rethought(11 * [4.1]) == rethought(40 * [4.0]) == []
    assert rethought(11 * [9.0] + [1.0] + 11 * [9.0]) == []
    assert rethought(40 * [9.0], free=True) == []


def test_and_not_again_before_fifty_two_readings_more():
    assert rethought(12 * [9.0] + 60 * [9.0]) == [12, 12 + 52]
    assert rethought(12 * [9.0] + 5 * [1.0] + 60 * [9.0]) == [12, 12 + 5 + 52]


def test_what_is_tried_again_starts_where_the_robot_is():
    rows, doubt = one_track(9.0, readings=77), Doubt()
    rows.means[:], rows.rates[:] = 0.5, 0.25
    rows.p[:] = 0.125
    for _ in range(12):
        doubt.rethink(rows, free=False)
    others = Assumptions.all()
    assert len(rows.weights) == 1 + len(others.weights)
    assert rows.weights[0] == pytest.approx(0.99)
    assert rows.weights[1:].sum() == pytest.approx(0.01)
    assert (rows.doubt == 1.0).all() and rows.readings == 0 and rows.patient
    assert (rows.rates == 0.25).all()
    outside = slice(s.MOVES_RIGHT, s.DISTANCE)
    assert (rows.means[:, outside] == 0.5).all()
    assert (rows.p[:, outside, outside] == 0.125).all()
    assert (rows.means[1:, :s.MOVES_RIGHT] == others.means[:, :s.MOVES_RIGHT]).all()
    assert (rows.means[1:, s.DISTANCE:] == 0).all()


def test_the_rounding_that_was_learned_stays_likely_when_all_is_tried_again():
    """Steady wheels have told it, and a model of the rest that fails is no reason to forget it."""
    rows, doubt, others = one_track(9.0), Doubt(), Assumptions.all()
    for _ in range(12):
        doubt.rethink(rows, free=False)
    alike = np.array([each is rows.roundings[0] for each in others.roundings])
    expected = others.weights * np.where(alike, 1.0, 0.03)
    assert rows.weights[1:] == pytest.approx(0.01 * expected / expected.sum())
    assert 0 < alike.sum() < len(alike)


UNSTEADY = np.array([0.0, 0.002, 0.005, 0.01])
LIKELY = 0.93, 0.04, 0.02, 0.01


@pytest.mark.parametrize(('believed', 'z', 'unsteadily'), [
    (0, 0.3, 0.0), (0, 6.0, 0.005), (0, 30.0, 0.0), (2, 0.3, 0.0), (2, 2.5, 0.005)])
@pytest.mark.parametrize('width', [0.2, 0.3])
def test_readings_tell_whether_wheels_run_unsteadily(believed, z, unsteadily, width):
    """Each degree of it is as likely as it makes the reading, but none explains a wheel held."""
    rows = one_track()
    assert rows.unsteady == [0.0]
    rows.steadiness[0, believed] += 5.0 * (believed > 0)
    before = UNSTEADY[believed] ** 2
    rows.p[:, s.DISTANCE, s.DISTANCE] += before * 2.0 / 4
    rows.p[:, s.ANGLE, s.ANGLE] += before * 2.0 / width ** 2
    logs = 0.97 * rows.steadiness[0] + 0.03 * np.log(LIKELY)
    doubt, _ = met(rows, (z, 0.0), share=0.0)
    gaps, spreads = doubt._gaps, doubt._spreads
    doubt.watch(rows, np.array([[1.5], [0.5]]), np.array([width]))
    for gap, spread, each in zip(gaps[:, 0], spreads[:, 0], (0.5, 2.0 / width ** 2)):
        variance = spread ** 2 + each * (UNSTEADY ** 2 - before)
        logs -= np.minimum(gap ** 2 / variance, 16.0) / 2 + np.log(variance) / 2
    assert rows.steadiness[0] == pytest.approx(np.maximum(logs - logs.max(), -8.0))
    assert rows.unsteady ** 0.5 == pytest.approx([unsteadily])


def test_what_was_learned_of_unsteady_wheels_fades():
    rows = one_track()
    rows.steadiness[:] = 0.0, -1.0, -2.0, -3.0
    doubt, _ = met(rows, (0.0, 0.0))
    doubt.watch(rows, np.zeros((2, 1)), np.array([0.25]))  # nothing is learned where nothing rolls
    logs = 0.97 * np.array([0.0, -1.0, -2.0, -3.0]) + 0.03 * np.log(LIKELY)
    assert rows.steadiness[0] == pytest.approx(logs - logs[0])
