# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The copies of the wheels roll some frames at once; nobody who asks in between may notice."""

from collections.abc import Iterator
from itertools import pairwise
from math import hypot, radians
from random import Random

import numpy as np
import pytest

from create_oi_ros.odometry import Estimate, Geometry, Increment, Odometry
from create_oi_ros.odometry.request_history import RECENT
from create_oi_ros.odometry.tracks import Tracks
from support.ride import SLOT

Speeds = tuple[float, float]


def steered(random: Random, frames: int) -> Iterator[Speeds]:
    """Change both speeds as fast as a driver does, for some frames, then hold them for some."""
    right = left = 0.0
    more, less = 0, 0
    for frame in range(frames):
        if not frame % 40:
            more, less = random.randint(-15, 15), random.randint(-15, 15)
        if frame % 40 < random.choice((12, 25)):
            right = max(-0.4, min(0.4, right + more / 1000))
            left = max(-0.4, min(0.4, left + less / 1000))
        yield right, left


def stepped(random: Random, frames: int) -> Iterator[Speeds]:
    """Ask for other speeds at once, at any time, most often when the last are no longer recent."""
    speeds, until = (0.0, 0.0), 0.0
    for frame in range(frames):
        if frame * SLOT >= until:
            speeds = random.choice((-0.3, 0.0, 0.015, 0.2)), random.choice((-0.2, 0.0, 0.02, 0.4))
            until = frame * SLOT + random.choice((2 * SLOT, RECENT - SLOT, RECENT, RECENT + SLOT))
        yield speeds


def nudged(random: Random, frames: int) -> Iterator[Speeds]:
    """Ask for a little more or less just when the last request ceases to be recent."""
    right, left, until = 0.2, 0.2, RECENT
    for frame in range(frames):
        if frame * SLOT >= until:
            right, left = (random.choice((0.18, 0.2, 0.22)) for _ in range(2))
            until = frame * SLOT + RECENT + random.randint(-2, 3) * SLOT
        yield right, left


@pytest.mark.parametrize('seed', range(8))
@pytest.mark.parametrize('ask', [steered, stepped, nudged])
def test_wheels_that_roll_late_come_to_the_same_place(ask, seed):
    late, prompt = Tracks(Geometry()), Tracks(Geometry())
    compared, off = 0, np.zeros(2)
    for speeds in ask(Random(seed), 600):
        for tracks in (late, prompt):
            tracks.advance(SLOT, *speeds)
        assert np.isfinite(prompt.held).all()  # asking lets them roll now
        if not late.wheels.behind:
            compared += 1
            (x, y, yaw), (there_x, there_y, there_yaw) = late.pose(), prompt.pose()
            off = np.maximum(off, (hypot(x - there_x, y - there_y), abs(yaw - there_yaw)))
    assert compared > 100
    assert off[0] < 0.002 and off[1] < radians(0.7)


def told(speeds: Iterator[float]) -> list[Estimate]:
    """Let an odometry that nobody answers hear frames of both wheels asked for one speed."""
    odometry = Odometry(window=1.0)
    return [odometry.update(Increment(dt=SLOT, right=speed, left=speed, driven=True))
            for speed in speeds]


def test_the_speed_of_a_robot_that_speeds_up_evenly_grows_evenly():
    heard = told(min(0.3, frame * SLOT) for frame in range(80))
    growth = [after.linear - before.linear for before, after in pairwise(heard)]
    changes = [abs(after - before) for before, after in pairwise(growth[8:])]
    assert max(changes) < 0.012
    assert sum(changes) / len(changes) < 0.002


def test_a_mean_pose_goes_on_along_the_arc_while_nothing_rolls():
    tracks = Tracks(Geometry())
    for _ in range(400):
        tracks.advance(SLOT, 0.3, 0.1)
    assert tracks.settled
    x, y, yaw = tracks.pose()
    for _ in range(200):
        tracks.advance(SLOT, 0.3, 0.1)
    ahead = tracks.pose()
    assert np.isfinite(tracks.held).all()
    assert tracks.pose() == pytest.approx(ahead, abs=0.02)
    assert hypot(ahead[0] - x, ahead[1] - y) > 0.2


@pytest.mark.parametrize(('right', 'left'), [(1.0, 0.1), (-0.1, -1.0), (0.5, 0.9)])
def test_between_two_steps_a_mean_that_speeds_up_goes_on_as_its_wheels_do(right, left):
    tracks, compared = Tracks(Geometry()), 0
    for frame in range(30):
        seconds = frame * SLOT
        tracks.advance(SLOT, right * seconds, left * seconds)
        if frame > 17 and tracks.wheels.behind:  # the wheels follow
            ahead = tracks.pose()
            assert np.isfinite(tracks.held).all()  # now they roll
            x, y, yaw = tracks.pose()
            assert hypot(ahead[0] - x, ahead[1] - y) < 1e-5
            assert abs(ahead[2] - yaw) < 1e-4
            compared += 1
    assert compared > 10
