# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a reading does to what is believed of the accumulators, figure by figure."""

from math import log, radians, sqrt

import numpy as np
import pytest

from create_oi_ros.odometry import states
from create_oi_ros.odometry.accumulators import empty, innovation, learn, take_out, UNLIKELY
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.robot import Rounding

KINDS = (Rounding.CARRY, Rounding.TRUNCATE, Rounding.ROUND)
D, A, X = states.DISTANCE, states.ANGLE, states.X
MM, DEGREE = 0.001, radians(1)
WIDE = 0.1
"""Metres or radians: so unsure that a reading decides alone."""


def believed(distance: float = 0.0, angle: float = 0.0, *, spread: float = 1e-6) -> Assumptions:
    """Return a track of each rounding that believes these, in m and rad."""
    rows = Assumptions.all()
    order = [rows.roundings.index(kind) for kind in KINDS]
    rows = Assumptions(list(KINDS), rows.signs, rows.springs[order], rows.weights[order],
                       rows.doubt[order], rows.means[order], rows.p[order], rows.rates[order])
    rows.clear(D, distance, spread ** 2)
    rows.clear(A, angle, spread ** 2)
    return rows


def test_how_far_a_reading_is_from_what_was_expected() -> None:
    rows = believed(0.010, 0.1, spread=0.002)
    gaps, spreads = innovation(rows, (20, -3))
    assert gaps[0] == pytest.approx([0.0105, 0.0105, 0.010])
    assert gaps[1] == pytest.approx([-3.5 * DEGREE - 0.1, -3.5 * DEGREE - 0.1, -3 * DEGREE - 0.1])
    assert spreads[0] == pytest.approx(
        [sqrt(0.002 ** 2 + (0.15 * MM) ** 2 + MM ** 2 / 12)] * 3)
    assert spreads[1] == pytest.approx(
        [sqrt(0.002 ** 2 + (0.05 * DEGREE) ** 2 + DEGREE ** 2 / 12)] * 3)


def test_a_reading_of_nothing_is_wider_where_numbers_are_cut() -> None:
    rows = believed(spread=0.002)
    _, spreads = innovation(rows, (0, 0))
    wide, narrow = (sqrt(0.002 ** 2 + (0.15 * MM) ** 2 + (n * MM) ** 2 / 12) for n in (2, 1))
    assert spreads[0] == pytest.approx([wide, wide, narrow])


def test_a_track_that_knew_nothing_believes_the_reading() -> None:
    rows = believed(spread=WIDE)
    learn(rows, (20, -3))
    assert rows.means[:, D] == pytest.approx([0.0205, 0.0205, 0.020], abs=1e-6)
    assert rows.means[:, A] == pytest.approx(
        [-3.5 * DEGREE, -3.5 * DEGREE, -3 * DEGREE], abs=2e-4)
    assert np.sqrt(rows.p[:, D, D]) == pytest.approx([MM / sqrt(12)] * 3, rel=0.3)
    assert np.sqrt(rows.p[:, A, A]) == pytest.approx([DEGREE / sqrt(12)] * 3, rel=0.05)


def test_what_goes_with_the_distance_is_learned_with_it() -> None:
    rows = believed(spread=WIDE)
    rows.clear(X, 1.0, WIDE ** 2)
    rows.p[:, X, D] = rows.p[:, D, X] = 0.5 * WIDE ** 2
    learn(rows, (20, 0))
    assert rows.means[:, X] == pytest.approx(1.0 + 0.5 * rows.means[:, D], abs=1e-6)
    assert rows.p[:, X, X] == pytest.approx([0.75 * WIDE ** 2] * 3, rel=1e-3)


def test_the_likelihood_is_the_part_of_the_belief_inside_the_reading() -> None:
    sure = believed(0.0203, 0.0, spread=1e-6)
    right, wrong = learn(sure, (20, 0)), learn(believed(0.0203, 0.0), (24, 0))
    # Half a millimetre on each side for ROUND, 0.3 mm below for the rest: a tick hides 0.15 mm.
    assert right[2] > log(0.9)
    assert right[0] == right[1] == pytest.approx(log(0.977 + UNLIKELY), abs=0.02)
    assert wrong == pytest.approx(np.array([log(UNLIKELY)] * 3), abs=0.02)
    both = learn(believed(0.0203, 0.0), (24, 9))
    assert both == pytest.approx(np.array([2 * log(UNLIKELY)] * 3), abs=0.02)


def test_only_a_robot_that_carries_keeps_the_rest_when_it_is_read() -> None:
    rows = believed(0.0203, -0.05, spread=0.002)
    rows.p[:, X, D] = rows.p[:, D, X] = 1e-3
    take_out(rows, (20, -2))
    assert rows.means[:, D] == pytest.approx([0.0003, 0.0, 0.0])
    assert rows.means[:, A] == pytest.approx([2 * DEGREE - 0.05, 0.0, 0.0])
    assert rows.p[:, D, D] == pytest.approx([0.002 ** 2, 0.0, 0.0])
    assert rows.p[:, A, A] == pytest.approx([0.002 ** 2, 0.0, 0.0])
    assert rows.p[:, X, D] == pytest.approx([1e-3, 0.0, 0.0])
    assert rows.p[:, D, X] == pytest.approx([1e-3, 0.0, 0.0])


def test_an_accumulator_that_was_emptied_may_hold_a_rest_where_the_robot_carries() -> None:
    rows = believed(0.0203, -0.05, spread=0.002)
    empty(rows)
    assert not rows.means[:, [D, A]].any()
    assert rows.p[:, D, D] == pytest.approx([MM ** 2 / 3, 0.0, 0.0])
    assert rows.p[:, A, A] == pytest.approx([DEGREE ** 2 / 3, 0.0, 0.0])
