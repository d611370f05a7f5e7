# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What tracks make of frames that were lost or came early."""

from math import sqrt

import numpy as np
import pytest

from create_oi_ros.odometry import Geometry
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions, SIGNS
from create_oi_ros.odometry.filter import came_since
from create_oi_ros.odometry.tracks import Tracks
from support.ride import SLOT

SPEED = 0.2


@pytest.fixture
def tracks() -> Tracks:
    """Return tracks of wheels that run evenly."""
    tracks = Tracks(Geometry())
    for _ in range(100):
        tracks.advance(SLOT, SPEED, SPEED)
    return tracks


def test_a_reading_of_what_came_since_a_lost_one_is_known_by_its_size(tracks: Tracks) -> None:
    for _ in range(400):
        tracks.advance(SLOT, SPEED, SPEED)
    began = tracks.held
    for _ in range(10):
        tracks.advance(SLOT, SPEED, SPEED)
    ended = tracks.held
    for _ in range(200):
        tracks.advance(SLOT, SPEED, SPEED)
    since, before = (round(1000 * (tracks.held[0] - held[0])) for held in (ended, began))
    assert came_since(began, ended, since, 0, tracks)
    assert came_since(began, ended, before, 0, tracks)
    assert not came_since(began, ended, since - 10, 0, tracks)
    assert not came_since(began, ended, before + 10, 0, tracks)
    assert not came_since(began, ended, since, 10, tracks)  # and it has turned, which nothing lost


def test_a_reading_that_is_expected_is_not_taken_for_part_of_one(tracks: Tracks) -> None:
    held = round(1000 * tracks.held[0])
    assert not came_since((0.0, 0.0), (0.0, 0.0), held, 0, tracks)


def doubt_of_change(dt: float) -> float:
    """Return the doubt of the place after a request that came in a frame of this length, m."""
    tracks = Tracks(Geometry())
    tracks.rows.p[:] = 0.0  # all else is known
    tracks.reset()
    tracks.advance(dt, SPEED, SPEED)
    for _ in range(150):
        tracks.advance(SLOT, SPEED, SPEED)
    return sqrt(tracks.pose_covariance()[0])


def test_the_longer_the_frame_the_less_is_known_of_when_its_request_came() -> None:
    early, even, late = (doubt_of_change(dt) for dt in (0.01, SLOT, 10 * SLOT))
    assert early <= even < late
    assert late > SPEED * 10 * SLOT / 12 ** 0.5 / 2 ** 0.5


def test_a_mean_pose_that_was_asked_for_is_worked_out_anew_when_it_changes(tracks: Tracks) -> None:
    tracks.mark()
    before = tracks.pose()
    assert before == tracks.pose() and before[0] > 0
    tracks.advance(SLOT, SPEED, SPEED)
    tracks.mark()
    assert tracks.pose()[0] > before[0]
    tracks.reset()
    assert tracks.pose() == (0.0, 0.0, 0.0)


def test_signs_are_told_apart_when_a_rolling_wheel_is_asked_for_another(tracks: Tracks) -> None:
    """Which sign the encoder of a wheel counts by makes no difference before."""
    new = len(tracks.rows.weights)
    for right, left in ((0.2, 0.1), (0.0, 0.0)):
        drive(tracks, right, left)
    drive(tracks, 0.1, -0.1)  # from rest, and both signs have turned before the wheel does
    assert tracks.rows.open_signs and len(tracks.rows.weights) == new
    tracks.advance(SLOT, 0.1, 0.0)  # is it forwards that the wheel rolls out?
    assert not tracks.rows.open_signs and len(tracks.rows.weights) == new * len(SIGNS)
    drive(tracks, 0.0, 0.0)
    tracks.read(0, 30)


def test_tracks_that_were_told_apart_are_where_they_would_be_had_they_always_been() -> None:
    late, always = Tracks(Geometry()), Tracks(Geometry(), Assumptions.all())
    for tracks in (late, always):
        drive(tracks, 0.2, 0.1)
        tracks.read(280, 45)
        drive(tracks, -0.1, 0.1)
        tracks.read(20, -90)
        drive(tracks, 0.1, 0.0)
    assert len(late.rows.weights) == len(always.rows.weights)
    assert late.pose() == pytest.approx(always.pose(), abs=0.01)
    assert late.pose_covariance() == pytest.approx(always.pose_covariance(), rel=0.2, abs=1e-4)


@pytest.mark.parametrize('slow', [(0.01, 0.01), (0.01, 0.2), (-0.01, 0.0), (0.0, 0.01)])
def test_copies_go_on_where_it_becomes_open_whether_a_request_moves_the_wheels(
        slow: tuple[float, float]) -> None:
    going, anew = Tracks(Geometry()), Tracks(Geometry())
    for tracks in (going, anew):
        drive(tracks, 0.2, 0.1)
        tracks.advance(SLOT, *slow, to_read=tracks is going)
        drive(tracks, *slow)
        tracks._close()
    assert going.band.open == anew.band.open == [0 < abs(speed) < 0.1 for speed in slow]
    assert going.rows.means == pytest.approx(anew.rows.means, abs=1e-6)
    moves = list(s.MOVES)
    assert going.rows.p[:, moves] == pytest.approx(anew.rows.p[:, moves], rel=1e-2, abs=1e-6)
    assert (np.abs(going.rows.p[0, moves, s.DISTANCE]) > 1e-4).tolist() == going.band.open


def drive(tracks: Tracks, right: float, left: float, seconds: float = 2.0) -> None:
    """Let time pass under these requests."""
    for _ in range(round(seconds / SLOT)):
        tracks.advance(SLOT, right, left)
