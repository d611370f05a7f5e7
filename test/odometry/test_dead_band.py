# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the slowest speed lies that moves a wheel."""

import pytest

from create_oi_ros.odometry import states
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.dead_band import DeadBand, FASTEST, SLOWEST

SURE = 0.05
LONG, SHORT = 1.0, 0.015
"""Seconds for which a request has held."""


def believed(*parts: float, spread: float = SURE) -> Assumptions:
    """Return tracks that believe that right and left wheel move by these parts, 0 to 1."""
    rows = Assumptions.all()
    for index, part in zip(states.MOVES, parts):
        rows.clear(index, part, spread ** 2)
    return rows


def test_a_wheel_that_moves_and_one_that_stands_narrow_the_edge() -> None:
    band = DeadBand()
    assert band.ask(0.02, -0.005, LONG) == [None, None]
    rows = believed(0.95, 0.05)
    assert band.learn(rows, LONG) == [1]
    assert (band.stands, band.moves) == (0.005, 0.02)
    assert rows.means[0, states.MOVES].tolist() == [1.0, 0.0]
    assert band.ask(0.021, 0.004, LONG) == [1.0, 0.0]


@pytest.mark.parametrize(('part', 'spread'), [
    (0.5, SURE), (0.36, 0.14), (0.95, 0.2)], ids=['between', 'nearer to one', 'not sure'])
def test_a_wheel_stays_open_until_it_is_clear_whether_it_moves(part: float, spread: float) -> None:
    band = DeadBand()
    band.ask(0.01, 0.01, LONG)
    assert not band.learn(believed(part, part, spread=spread), LONG)
    assert band.open == [True, True]
    assert (band.stands, band.moves) == (SLOWEST, FASTEST)


def test_a_contradiction_opens_the_edge_again() -> None:
    """A slow request moved one wheel, a faster one did not move the other: neither is believed."""
    band = DeadBand()
    band.ask(0.012, 0.010, LONG)
    band.learn(believed(0.0, 1.0), LONG)
    assert (band.stands, band.moves) == (SLOWEST, FASTEST)
    assert band.ask(0.011, 0.011, LONG) == [None, None]


def test_a_reading_that_was_not_expected_opens_the_edge_only_under_slow_requests() -> None:
    band = DeadBand(stands=0.01, moves=0.012)
    band.ask(0.3, 0.0, LONG)
    band.doubt()
    assert (band.stands, band.moves) == (0.01, 0.012)
    band.ask(0.3, -0.011, LONG)
    band.doubt()
    assert (band.stands, band.moves) == (SLOWEST, FASTEST)


RIGHT, LEFT = states.MOVES


@pytest.mark.parametrize(('right', 'left', 'together'), [
    (0.01, 0.01, 0.225), (0.01, -0.01, 0.225), (0.01, 0.02, 0.0), (0.02, 0.01, 0.0)])
def test_wheels_that_are_asked_for_one_slow_speed_move_or_stand_together(
        right: float, left: float, together: float) -> None:
    band, rows = DeadBand(), believed(1.0, 1.0)
    answers = band.ask(right, left, LONG)
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
    band.decide(rows, band.ask(right, left, LONG))
    for wheel, index in enumerate((RIGHT, LEFT)):
        assert (rows.means[:, index] == means[wheel]).all()
        assert rows.p[:, index, index] == pytest.approx(variances[wheel])
    assert not rows.p[:, RIGHT, LEFT].any()


def test_before_the_first_request_nothing_is_learned_or_doubted() -> None:
    band = DeadBand(stands=0.01, moves=0.012)
    band.doubt()
    assert band.learn(believed(0.0, 0.0), LONG) == []
    assert band.learn(believed(1.0, 1.0), LONG) == []
    assert (band.stands, band.moves) == (0.01, 0.012)


def test_the_best_track_decides() -> None:
    band, rows = DeadBand(), believed(0.95, 0.05)
    for index, part in zip(states.MOVES, (0.05, 0.95)):
        rows.means[1:, index] = part
    band.ask(0.02, 0.005, LONG)
    assert band.learn(rows, LONG) == [1]


def test_the_edge_is_looked_for_where_creates_have_it() -> None:
    band = DeadBand()
    assert band.ask(0.0254, 0.0256, LONG) == [None, 1.0]
    assert band.ask(1e-6, 0.0, LONG) == [None, 1.0]


def passed(band: DeadBand, *speeds: float) -> None:
    """Let the right wheel's requests pass through these speeds, a frame each."""
    band.ask(0.0, 0.3, LONG)
    for number, speed in enumerate(speeds):
        band.ask(speed, 0.3, SHORT)
        assert band.goes_on == (number > 0)


def test_requests_that_pass_quickly_share_an_answer_until_a_reading_or_another_answer() -> None:
    band = DeadBand()
    passed(band, 0.008, 0.015, 0.023)
    band.ask(0.03, 0.3, SHORT)
    assert not band.goes_on and band.open == [False, False]
    passed(band, 0.023, 0.015)
    band.learn(believed(0.5, 1.0), SHORT)
    band.ask(0.008, 0.3, SHORT)
    assert not band.goes_on and band.open == [True, False]


@pytest.mark.parametrize(('right', 'left', 'held'), [
    (0.012, 0.3, 0.06), (0.012, 0.02, 0.015), (0.012, 0.005, 0.015)],
    ids=['the one before held for long', 'the other wheel opens', 'the other wheel stands'])
def test_other_requests_get_an_answer_of_their_own(
        right: float, left: float, held: float) -> None:
    band = DeadBand(stands=0.006)
    passed(band, 0.008, 0.010)
    band.ask(right, left, held)
    assert not band.goes_on and band.open[0]


def test_wheels_that_are_asked_for_one_speed_do_not_share_with_those_that_are_not() -> None:
    band = DeadBand()
    band.ask(0.01, 0.01, LONG)
    band.ask(0.012, 0.012, SHORT)
    assert band.goes_on
    band.ask(0.014, 0.013, SHORT)
    assert not band.goes_on


def test_a_shared_answer_decides_once_the_last_request_has_held_for_most_of_the_time() -> None:
    band = DeadBand()
    passed(band, 0.008, 0.015, 0.02)
    assert band.learn(believed(0.95, 1.0), 0.16) == [] and not band.open[0]
    assert band.moves == 0.02


def test_a_shared_answer_that_tells_of_no_request_is_asked_for_again() -> None:
    """Else a part that wheels moved by under several requests would count for the last one."""
    band, rows = DeadBand(), believed(0.95, 1.0)
    passed(band, 0.008, 0.015, 0.02)
    assert band.learn(rows, 0.14) == [] and band.open[0]
    assert (band.stands, band.moves) == (SLOWEST, FASTEST)
    assert (rows.means[:, RIGHT] == 0.5).all() and (rows.means[:, LEFT] == 1.0).all()
    rows.clear(RIGHT, 0.05, SURE ** 2)
    assert band.learn(rows, 0.14) == [0]
    assert band.stands == 0.02
