# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""At which moments the robot is asked for distance and angle."""

from math import degrees, inf

import numpy as np
import pytest

from create_oi_ros.odometry import Geometry
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.reading_plan import ReadingPlan
from create_oi_ros.odometry.tracks import Tracks
from create_oi_ros.robot import Rounding
from support.ride import Ride, SLOT

RIGHT, FAST, LEFT = 0.06, 0.12, 0.04
"""m/s of turns, of 0.07 and 0.27 degrees a frame."""


def turning(rounding: Rounding, vague: float) -> Tracks:
    """Return tracks that turn slowly; nothing but the angle is unknown, by so many degrees."""
    tracks = Tracks(Geometry())
    for _ in range(200):
        tracks.advance(SLOT, RIGHT, LEFT)
    tracks.read(180, 10)
    rows = tracks.rows
    rows.roundings[:] = [rounding] * len(rows.roundings)
    rows.taught = 100.0
    rows.steadiness[:, 1:] = -np.inf  # wheels that run steadily
    rows.p[:] = 0.0
    rows.p[:, s.ANGLE, s.ANGLE] = (vague * s.DEGREE) ** 2
    tracks.reset()
    tracks.pose_covariance()
    return tracks


@pytest.mark.parametrize(('rounding', 'edge'), [(Rounding.TRUNCATE, 0.0), (Rounding.ROUND, 0.5)])
def test_a_reading_tells_much_where_another_whole_degree_begins(
        rounding: Rounding, edge: float) -> None:
    tracks = turning(rounding, 0.3)
    told = set()
    for _ in range(150):
        tracks.advance(SLOT, RIGHT, LEFT)
        angle = degrees(tracks.held[1])
        way = abs((angle - edge + 0.5) % 1 - 0.5)  # to the nearest edge
        if angle > 1 and abs(way - 0.15) > 0.01:
            told.add(way < 0.15)
            assert (tracks.tells_in(0.0) == 0) == (way < 0.15)
    assert told == {True, False}


def test_the_first_degree_of_a_robot_that_cuts_off_has_no_edge_at_zero() -> None:
    tracks = turning(Rounding.TRUNCATE, 0.3)
    assert abs(degrees(tracks.held[1])) < 0.1
    assert tracks.tells_in(0.0) > 0


def test_a_prediction_that_is_sure_needs_no_moment() -> None:
    tracks = turning(Rounding.TRUNCATE, 0.05)
    assert all(tracks.tells_in(ahead * SLOT) == inf for ahead in range(100))


def test_the_moment_is_that_of_the_answer() -> None:
    tracks, later = turning(Rounding.TRUNCATE, 0.3), []
    expected = [tracks.tells_in(frames * SLOT) == 0 for frames in range(1, 60)]
    for _ in expected:
        tracks.advance(SLOT, RIGHT, LEFT)
        later.append(tracks.tells_in(0.0) == 0)
    assert sum(a != b for a, b in zip(expected, later)) <= 2  # at edges, to a frame


@pytest.mark.parametrize('rounding', [Rounding.TRUNCATE, Rounding.ROUND])
@pytest.mark.parametrize(('right', 'left'), [(RIGHT, LEFT), (LEFT, RIGHT), (-LEFT, -0.07)])
def test_it_is_known_how_long_nothing_will_be_told(
        rounding: Rounding, right: float, left: float) -> None:
    """Never too long; and where the next edge is ahead, hardly too short."""
    tracks = turning(rounding, 0.3)
    for _ in range(100):
        tracks.advance(SLOT, right, left)
    expected, waited = [], 0
    for _ in range(400):
        expected.append(tracks.tells_in(0.0))
        tracks.advance(SLOT, right, left)
    for frame, seconds in enumerate(expected):
        ahead = round(seconds / SLOT)
        if seconds and frame + ahead < len(expected):
            assert expected[frame + ahead] <= 2 * SLOT
            assert all(expected[frame + k] for k in range(ahead - 1))
            waited = max(waited, ahead)
    assert waited > 4


@pytest.mark.parametrize('latency', [1, 2, 3])
def test_a_slow_line_is_asked_as_much_earlier(latency: int) -> None:
    """What is asked for is answered near an edge, however many frames later."""
    tracks, plan, ways = turning(Rounding.TRUNCATE, 0.3), ReadingPlan(1.0), []
    tracks.advance(SLOT, FAST, LEFT)
    coming = [False] * latency
    for _ in range(1500):
        tracks.advance(SLOT, FAST, LEFT)
        plan.step(SLOT, steady=True, tracks=tracks)
        if coming.pop(0):
            plan.came()
            angle = degrees(tracks.held[1])
            ways.append(abs((angle + 0.5) % 1 - 0.5))
        coming.append(plan.due)
    assert len(ways) > 10
    assert max(ways[2:]) < 0.16


def test_whoever_is_in_a_hurry_gets_the_next_reading_at_once() -> None:
    ride = Ride()
    ride.go(5, 0.1, 0.1)
    while ride.odometry.reading_due:
        ride.go(SLOT, 0.1, 0.1)
    ride.go(10 * SLOT, 0.1, 0.1)
    assert not ride.odometry.reading_due
    ride.odometry.hurry()
    ride.go(SLOT, 0.1, 0.1)
    assert ride.odometry.reading_due
