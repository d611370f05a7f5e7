# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which of the things that may be assumed of a robot are kept."""

from math import exp

import numpy as np
import pytest

from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions, NEAR, SIGNS, YOUNG
from create_oi_ros.odometry.encoder_signs import LAST
from create_oi_ros.robot import Rounding


@pytest.mark.parametrize(('share', 'is_kept'), [(2 * NEAR, True), (NEAR / 2, False)])
def test_a_spring_is_kept_beside_the_best_lag_while_it_comes_near(
        share: float, is_kept: bool) -> None:
    rows = Assumptions.all()
    rows.weights = np.where(rows.springs, share, 1.0)
    rows.weights[0] *= 1.5
    rows.readings = YOUNG
    rows.weigh(np.zeros(len(rows.weights)))
    assert rows.springs.any() == is_kept
    kinds = len(Rounding) * len(SIGNS)
    assert (len(rows.roundings), len(rows.means)) == (kinds * (1 + is_kept),) * 2
    assert rows.weights.sum() == pytest.approx(1.0)
    assert rows.weights[0] == rows.weights.max()


def of_kinds(rows: Assumptions) -> dict[tuple, float]:
    """Return the weight of each kind of track."""
    return {(rounding, int(kind), bool(late), *mean): weight for rounding, kind, late, mean, weight
            in zip(rows.roundings, *rows.signs, rows.means.tolist(), rows.weights)}


def test_signs_that_are_told_apart_are_all_that_a_robot_may_have() -> None:
    rows, everything = Assumptions.new(), Assumptions.all()
    assert rows.open_signs and len(rows.weights) * len(SIGNS) == len(everything.weights)
    assert rows.weights.sum() == pytest.approx(1.0)
    rows.tell_signs_apart()
    assert not rows.open_signs
    assert of_kinds(rows) == pytest.approx(of_kinds(everything))
    for mine in (rows.doubt, rows.p, rows.means, rows.steadiness, rows.rates, rows.springs):
        assert len(mine) == len(everything.weights)


def test_each_track_goes_on_with_what_it_knows_when_signs_are_told_apart() -> None:
    rows = Assumptions.new()
    rows.keep([3, 1])
    rows.doubt = np.array([2.0, 5.0])
    rows.p[1] *= 3
    rows.steadiness[1] -= 1.0
    before = rows.p.copy(), rows.steadiness.copy(), rows.weights.copy()
    rows.tell_signs_apart()
    assert rows.doubt.tolist() == [2.0] * len(SIGNS) + [5.0] * len(SIGNS)
    for mine, was in zip((rows.p, rows.steadiness), before):
        assert (mine == np.repeat(was, len(SIGNS), axis=0)).all()
    assert rows.weights.reshape(2, -1).sum(axis=1) == pytest.approx(before[2])


def test_open_signs_stay_open_when_the_past_is_followed_again() -> None:
    rows = Assumptions.new()
    rows.keep([2])
    afresh = rows.afresh()
    assert afresh.open_signs
    assert sorted(afresh.roundings, key=str) == sorted(Rounding, key=str)


def test_all_are_kept_of_a_robot_that_is_new() -> None:
    rows = Assumptions.all()
    before = len(rows.roundings)
    rows.weigh(np.zeros(before))
    assert len(rows.roundings) == before


def of_two(*, weights: tuple[float, float] = (0.5, 0.5)) -> Assumptions:
    """Return tracks of two kinds, with weights, and numbers of their own."""
    rows = Assumptions.all()
    rows.keep([0, len(s.RESPONSES)])
    rows.weights = np.array(weights)
    rows.means = np.arange(2.0 * s.SIZE).reshape(2, s.SIZE)
    return rows


def test_what_was_reported_of_real_robots_is_likelier_at_first() -> None:
    rows = Assumptions.all()
    truncates = np.array([2.0 if each is Rounding.TRUNCATE else 1.0 for each in rows.roundings])
    sign = np.array([{(LAST, True): 4.0, (LAST, False): 2.0}.get((int(kind), bool(late)), 1.0)
                     for kind, late in zip(*rows.signs)])
    expected = truncates * sign * np.tile([1.0, 1.0, 1.0, 0.4, 0.1], 15)
    assert rows.weights == pytest.approx(expected / expected.sum())
    assert len(expected) == 3 * 5 * 5
    assert (rows.doubt == 1).all() and not rows.rates.any() and rows.readings == 0
    for row, spring in enumerate(rows.springs):
        response = s.RESPONSES[row % 5]
        assert (response in s.SPRINGS) == spring
        for index, prior in (s.COMMON | response).items():
            assert rows.means[row, index] == prior.mean
            assert rows.p[row, index, index] == prior.spread ** 2
    assert np.count_nonzero(rows.p) == sum(
        bool(prior.spread) for response in s.RESPONSES
        for prior in (s.COMMON | response).values()) * 15


def test_a_track_of_no_weight_has_no_share() -> None:
    assert of_two(weights=(1 - 9e-5, 9e-5)).shares().tolist() == [1.0, 0.0]
    assert of_two(weights=(0.9, 0.3)).shares() == pytest.approx([0.75, 0.25])
    assert of_two(weights=(1 - 1.1e-4, 1.1e-4)).shares()[1] > 0


@pytest.mark.parametrize(('logs', 'first'), [
    ((-1.0, -2.0), 1 / (1 + exp(-1))), ((7.0, 4.0), 1 / (1 + exp(-3))),
    ((-1.0, -99.0), 1 / (1 + exp(-4)))])
def test_a_reading_weighs_tracks_but_one_alone_decides_nothing(logs, first) -> None:
    rows = of_two()
    rows.weigh(np.array(logs))
    assert rows.weights == pytest.approx([first, 1 - first])
    assert rows.readings == 1


def test_the_best_track_comes_first_with_all_that_belongs_to_it() -> None:
    rows = of_two()
    rows.doubt, rows.rates = np.array([1.0, 2.0]), np.array([[1.0, 2.0], [3.0, 4.0]])
    rows.p[1, 0, 0] = 7.0
    rows.weigh(np.array([-1.0, 0.0]))
    assert rows.weights[0] > rows.weights[1]
    assert rows.means[:, 0].tolist() == [s.SIZE, 0]
    assert (rows.doubt.tolist(), rows.rates[0].tolist()) == ([2.0, 1.0], [3.0, 4.0])
    assert rows.p[0, 0, 0] == 7.0


@pytest.mark.parametrize(('weight', 'kept'), [(9e-7, 1), (1.1e-6, 2)])
def test_an_implausible_track_is_given_up_even_where_right_ones_may_be_faint(
        weight, kept) -> None:
    rows = of_two(weights=(1.0, weight))
    rows.patient = True
    rows.weigh(np.zeros(2))
    assert len(rows.weights) == kept


@pytest.mark.parametrize(('first', 'second', 'weight', 'patient', 'kept'), [
    ('lag', 'lag', 1.1e-4, False, 2), ('lag', 'lag', 9e-5, False, 1),
    ('spring', 'spring', 9e-5, False, 1), ('lag', 'spring', 9e-5, False, 2),
    ('spring', 'lag', 9e-5, False, 2), ('lag', 'lag', 9e-5, True, 2)])
def test_a_faint_track_is_given_up_for_one_of_its_kind_unless_it_may_be_right(
        first, second, weight, patient, kept) -> None:
    rows = of_two(weights=(1 - weight, weight))
    rows.springs = np.array([kind == 'spring' for kind in (first, second)])
    rows.patient = patient
    rows.weigh(np.zeros(2))
    assert len(rows.weights) == kept


@pytest.mark.parametrize(('readings', 'kept'), [(29, 4), (30, 1)])
def test_of_one_kind_only_the_best_response_is_kept_once_a_robot_is_not_new(
        readings, kept) -> None:
    rows = Assumptions.all()
    rows.keep([0, 1, 2, 3])
    rows.weights = np.array([0.1, 0.9, 0.2, 8e-4])
    rows.readings = readings
    rows.weigh(np.zeros(4))
    assert len(rows.weights) == kept
    assert rows.means[0, s.RAMP] == s.LAGS[1][s.RAMP].mean


def test_a_spring_is_kept_beside_a_lag_that_is_much_likelier() -> None:
    rows = Assumptions.all()
    rows.keep([0, 3, 4])
    rows.weights = np.array([0.9, 2e-3, 1e-3])
    rows.readings = 30
    rows.weigh(np.zeros(3))
    assert rows.springs.tolist() == [False, True]
    assert rows.means[1, s.BRAKING] == 0.0


def test_a_state_that_becomes_known_teaches_the_others_what_they_share_with_it() -> None:
    rows = of_two()
    a, b = s.MOVES_RIGHT, s.SPEED_RIGHT
    rows.means[:, a], rows.means[:, b] = 0.5, 0.2
    rows.p[:, a, a], rows.p[:, b, b] = 0.25, 0.04
    rows.p[:, a, b] = rows.p[:, b, a] = 0.08
    rows.settle(a, 1)
    assert rows.means[:, [a, b]] == pytest.approx(np.array([[1.0, 0.36]] * 2))
    assert rows.p[:, b, b] == pytest.approx([0.04 - 0.08 ** 2 / 0.25] * 2)
    assert not rows.p[:, a].any() and not rows.p[:, :, a].any()


def test_a_state_that_is_set_shares_nothing_with_others() -> None:
    rows = of_two()
    rows.p[:] = 1.0
    rows.clear(3, 0.5, 4.0)
    assert (rows.means[:, 3] == 0.5).all()
    expected = np.ones((s.SIZE, s.SIZE))
    expected[3], expected[:, 3] = 0.0, 0.0
    expected[3, 3] = 4.0
    assert (rows.p == expected).all()


def test_unknowns_stay_where_they_can_be() -> None:
    rows = Assumptions.all()
    for far, end in ((-9.0, 'low'), (9.0, 'high')):
        rows.means[:] = far
        rows.bound()
        for index, prior in (s.COMMON | s.LAGS[0]).items():
            found = rows.means[~rows.springs][:, index]
            assert (found == getattr(prior, end)).all()
        damping = rows.means[rows.springs][:, s.DAMPING]
        assert (damping == getattr(s.SPRING[s.DAMPING], end)).all()
        assert (rows.means[:, s.X] == far).all()


def test_others_are_tried_beside_with_a_weight_of_their_own() -> None:
    rows, others = of_two(), Assumptions.all()
    others.doubt[:] = 3.0
    rows.join(others, 0.1)
    assert rows.weights[:2] == pytest.approx([0.45, 0.45])
    assert rows.weights[2:] == pytest.approx(0.1 * others.weights)
    for mine in (rows.roundings, rows.signs.kinds, rows.signs.late, rows.springs, rows.doubt,
                 rows.means, rows.p, rows.rates):
        assert len(mine) == 2 + len(others.weights)
    assert rows.doubt.tolist() == 2 * [1.0] + len(others.weights) * [3.0]
    assert rows.roundings[2:] == others.roundings
    assert (rows.springs[2:] == others.springs).all()


def test_what_is_known_of_steadiness_stays_with_its_track() -> None:
    rows = of_two()
    rows.steadiness[:] = [[0.0, -1.0, -2.0, -3.0], [0.0, -4.0, -5.0, -6.0]]
    rows.keep([1, 0])
    assert rows.steadiness[0] == pytest.approx([0.0, -4.0, -5.0, -6.0])
    others = of_two()
    rows.join(others, 0.5)
    assert rows.steadiness.shape == (4, 4)
    assert rows.unsteady[2:] == pytest.approx(others.unsteady)


def test_copies_are_off_by_a_standard_deviation_and_those_of_lags_brake_softer() -> None:
    rows = of_two()
    rows.springs = np.array([False, True])
    rows.p = np.array([np.diag(np.arange(1.0, s.SIZE + 1)), np.diag(np.zeros(s.SIZE))])
    lag, spring = rows.steps()
    assert np.abs(lag) == pytest.approx(np.sqrt(np.arange(1.0, s.UNKNOWNS + 1)))
    assert [index for index in range(s.UNKNOWNS) if lag[index] < 0] == [s.BRAKING]
    assert spring.tolist() == [1e-5] * s.UNKNOWNS


@pytest.mark.parametrize(('response', 'index', 'spread'), [
    (0, s.GAIN_RIGHT, 0.035), (0, s.RAMP, 0.8), (0, s.LAG, 0.08), (3, s.DAMPING, 0.15),
    (3, s.DEAD_TIME, 0.05), (4, s.BRAKING, 0.5)])
def test_a_part_of_what_was_learned_of_the_wheels_counts_afresh(
        response: int, index: int, spread: float) -> None:
    rows = Assumptions.all()
    rows.keep([response])
    rows.p[0] = np.eye(s.SIZE) * 1e-4
    p = rows.afresh().p
    assert p[0, index, index] == pytest.approx(1 / (0.45 / 1e-4 + 0.55 / spread ** 2))
    assert not p[:, s.SEPARATION + 1:].any()
