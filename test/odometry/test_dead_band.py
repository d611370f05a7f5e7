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
