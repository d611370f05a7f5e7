# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the slowest speed lies that moves a wheel."""

import pytest

from create_oi_ros.odometry import states
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.dead_band import DeadBand, FASTEST, SLOWEST

SURE = 0.05


def believed(*parts: float, spread: float = SURE) -> Assumptions:
    """Return tracks that believe that right and left wheel move by these parts, 0 to 1."""
    rows = Assumptions.all()
    for index, part in zip(states.MOVES, parts):
        rows.clear(index, part, spread ** 2)
    return rows


def test_a_wheel_that_moves_and_one_that_stands_narrow_the_edge() -> None:
    band = DeadBand()
    assert band.ask(0.02, -0.005) == [None, None]
    rows = believed(0.95, 0.05)
    assert band.learn(rows) == [1]
    assert (band.stands, band.moves) == (0.005, 0.02)
    assert rows.means[0, states.MOVES].tolist() == [1.0, 0.0]
    assert band.ask(0.021, 0.004) == [1.0, 0.0]


@pytest.mark.parametrize(('part', 'spread'), [
    (0.5, SURE), (0.36, 0.14), (0.95, 0.2)], ids=['between', 'nearer to one', 'not sure'])
def test_a_wheel_stays_open_until_it_is_clear_whether_it_moves(part: float, spread: float) -> None:
    band = DeadBand()
    band.ask(0.01, 0.01)
    assert not band.learn(believed(part, part, spread=spread))
    assert band.open == [True, True]
    assert (band.stands, band.moves) == (SLOWEST, FASTEST)


def test_a_contradiction_opens_the_edge_again() -> None:
    """A slow request moved one wheel, a faster one did not move the other: neither is believed."""
    band = DeadBand()
    band.ask(0.012, 0.010)
    band.learn(believed(0.0, 1.0))
    assert (band.stands, band.moves) == (SLOWEST, FASTEST)
    assert band.ask(0.011, 0.011) == [None, None]


def test_a_reading_that_was_not_expected_opens_the_edge_only_under_slow_requests() -> None:
    band = DeadBand(stands=0.01, moves=0.012)
    band.ask(0.3, 0.0)
    band.doubt()
    assert (band.stands, band.moves) == (0.01, 0.012)
    band.ask(0.3, -0.011)
    band.doubt()
    assert (band.stands, band.moves) == (SLOWEST, FASTEST)


RIGHT, LEFT = states.MOVES


@pytest.mark.parametrize(('right', 'left', 'together'), [
    (0.01, 0.01, 0.225), (0.01, -0.01, 0.225), (0.01, 0.02, 0.0), (0.02, 0.01, 0.0)])
def test_wheels_that_are_asked_for_one_slow_speed_move_or_stand_together(
        right: float, left: float, together: float) -> None:
    band, rows = DeadBand(), believed(1.0, 1.0)
    answers = band.ask(right, left)
    assert answers == [None, None]
    band.decide(rows, answers)
    assert (rows.means[:, [RIGHT, LEFT]] == 0.5).all()
    assert rows.p[:, RIGHT, RIGHT] == pytest.approx(0.25) == rows.p[:, LEFT, LEFT]
    assert rows.p[:, RIGHT, LEFT] == pytest.approx(together) == rows.p[:, LEFT, RIGHT]


@pytest.mark.parametrize(('right', 'left', 'means', 'variances'), [
    (0.3, 0.01, (1.0, 0.5), (0.0, 0.25)), (-0.001, 0.3, (0.0, 1.0), (0.0, 0.0)),
    (0.3, 0.3, (1.0, 1.0), (0.0, 0.0)), (0.0, 0.01, (1.0, 0.5), (0.0, 0.25))])
def test_what_is_known_of_a_wheel_is_certain(
        right: float, left: float, means: tuple[float, float],
        variances: tuple[float, float]) -> None:
    band, rows = DeadBand(stands=0.002), believed(0.3, 0.3)
    band.decide(rows, band.ask(right, left))
    for wheel, index in enumerate((RIGHT, LEFT)):
        assert (rows.means[:, index] == means[wheel]).all()
        assert rows.p[:, index, index] == pytest.approx(variances[wheel])
    assert not rows.p[:, RIGHT, LEFT].any()


def test_before_the_first_request_nothing_is_learned_or_doubted() -> None:
    band = DeadBand(stands=0.01, moves=0.012)
    band.doubt()
    assert band.learn(believed(0.0, 0.0)) == []
    assert band.learn(believed(1.0, 1.0)) == []
    assert (band.stands, band.moves) == (0.01, 0.012)


def test_the_best_track_decides() -> None:
    band, rows = DeadBand(), believed(0.95, 0.05)
    for index, part in zip(states.MOVES, (0.05, 0.95)):
        rows.means[1:, index] = part
    band.ask(0.02, 0.005)
    assert band.learn(rows) == [1]


def test_the_edge_is_looked_for_where_creates_have_it() -> None:
    band = DeadBand()
    assert band.ask(0.0254, 0.0256) == [None, 1.0]
    assert band.ask(1e-6, 0.0) == [None, 1.0]
