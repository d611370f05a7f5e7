# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which readings show that wheels do not do what was requested, to the last millimetre."""

from math import exp

import pytest

from create_oi_ros.odometry import Geometry
from create_oi_ros.odometry.obedience import ExpectedTravel
from create_oi_ros.odometry.tracks import Tracks
from create_oi_ros.robot import FIRMWARE_SEPARATION

FREE, BOUND = True, False
DEGREES_PER_METRE = 2 / FIRMWARE_SEPARATION * 57.29578
"""By how much a robot turns on the spot whose wheels go a metre each."""


@pytest.fixture
def tracks() -> Tracks:
    """Return tracks that are sure of everything: they explain no reading but their own."""
    sure = Tracks(Geometry())
    sure.rows.p[:] = 0.0
    sure.reset()
    return sure


def went(tracks: Tracks, *requests: tuple[float, float, float]) -> ExpectedTravel:
    """Return what is expected after requests: right, left and seconds."""
    expected = ExpectedTravel()
    for right, left, seconds in requests:
        expected.step(seconds, right, left, tracks)
    return expected


def judged(expected: ExpectedTravel, tracks: Tracks, distance: int, angle: int,
           before: bool) -> bool:
    """Return whether wheels are free after a reading."""
    if tracks.is_free != before:
        tracks.free(before)
    expected.judge(distance, angle, tracks)
    return tracks.is_free


# A second at 0.2 m/s: within 200 mm, 4 mm, a quarter of the way (50 mm) and 0.3 s of the change
# of both wheels (0.4 m/s: 120 mm) wheels may obey; within 2 mm, 0.06 of it (12) and 0.2 s (80)
# wheels that were free obey again.
@pytest.mark.parametrize(('distance', 'before', 'free'), [
    (200 + 173, BOUND, BOUND), (200 + 175, BOUND, FREE),
    (200 - 173, BOUND, BOUND), (200 - 175, BOUND, FREE),
    (200 + 93, FREE, BOUND), (200 + 95, FREE, FREE),
    (200 - 93, FREE, BOUND), (200 - 95, FREE, FREE)])
def test_a_distance_frees_wheels_or_binds_them(tracks, distance, before, free):
    assert judged(went(tracks, (0.2, 0.2, 1.0)), tracks, distance, 0, before) == free


@pytest.mark.parametrize(('slack', 'way', 'before'), [(4, 0.17, BOUND), (2, 0.092, FREE)])
@pytest.mark.parametrize('sign', [1, -1])
def test_an_angle_frees_wheels_or_binds_them(tracks, slack, way, before, sign):
    turn = sign * 0.4 / FIRMWARE_SEPARATION * 57.29578
    most = slack + way * DEGREES_PER_METRE
    for more, free in ((most - 1, BOUND), (most + 1, FREE)):
        expected = went(tracks, *(4 * [(sign * 0.2, -sign * 0.2, 0.25)]))
        assert judged(expected, tracks, 0, round(turn + more), before) == free
        expected = went(tracks, (sign * 0.2, -sign * 0.2, 1.0))
        assert judged(expected, tracks, 0, round(turn - more), before) == free


@pytest.mark.parametrize(('seconds', 'free'), [(0.19, BOUND), (0.21, FREE)])
def test_a_window_of_a_fifth_of_a_second_tells(tracks, seconds, free):
    assert judged(went(tracks, (0.0, 0.0, seconds)), tracks, 900, 0, BOUND) == free


def test_ways_there_and_back_add_up(tracks):
    """Half a second each way: 0 mm away, 200 mm of path, and changes of 0.4 and 0.8 m/s."""
    requests = (0.2, 0.2, 0.5), (-0.2, -0.2, 0.5)
    most = 2 + 0.06 * 200 + 0.2 * 1200
    assert judged(went(tracks, *requests), tracks, round(most) - 1, 0, FREE) is BOUND
    assert judged(went(tracks, *requests), tracks, round(most) + 1, 0, FREE) is FREE


@pytest.mark.parametrize('later', [0.03, 0.15, 0.3, 9.0])
def test_wheels_still_follow_what_changed_just_before_the_window(tracks, later):
    recent = exp(-(0.01 + later) / 0.3)
    expected = went(tracks, (0.2, 0.2, 0.01), (0.2, 0.2, later))
    expected.restart()
    expected.step(1.0, 0.2, 0.2, tracks)
    most = 2 + 0.06 * 200 + 0.2 * 400 * recent
    assert judged(expected, tracks, 200 + round(most) - 1, 0, FREE) is BOUND
    expected = went(tracks, (0.2, 0.2, 0.01), (0.2, 0.2, later))
    expected.restart()
    expected.step(1.0, 0.2, 0.2, tracks)
    assert judged(expected, tracks, 200 + round(most) + 1, 0, FREE) is FREE


def test_a_reading_that_a_plausible_track_expected_frees_nothing():
    unsure = Tracks(Geometry())
    for _ in range(67):
        unsure.advance(0.015, 0.2, 0.2)
    expected = went(unsure, *(67 * [(0.2, 0.2, 0.015)]))
    held = round(1000 * unsure.held[0])
    assert judged(expected, unsure, held, 0, BOUND) is BOUND
