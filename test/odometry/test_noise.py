# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What motion adds to covariances, term by term, by sums done by hand."""

from math import cos, sin

import numpy as np
import pytest

from create_oi_ros.odometry import noise
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.noise import Stretch
from create_oi_ros.robot import SLOT

HEADING, WIDTH, SCALES, SLIP = 0.6, 0.25, (1.1, 0.9), 0.01
JITTER = SLOT ** 2 / 12
"""Variance of a moment that falls anywhere in a slot, s²."""
SIDES = pytest.mark.parametrize(('wheel', 'side'), [(0, 1), (1, -1)], ids=['right', 'left'])


def added(doubt: float = 1.0, *, seconds: float = 0.0, free: bool = False,
          unsteady: float = 0.0, **did: tuple[float, float]) -> np.ndarray:
    """Return what a stretch adds for one track; what is not given is zero, right first."""
    pairs = {name: np.array(did.get(name, (0.0, 0.0)), dtype=float)
             for name in ('changes', 'unsure', 'path', 'turned', 'miscounted')}
    stretch = Stretch(seconds, pairs['changes'], pairs['unsure'],
                      *(pairs[name][:, None] for name in ('path', 'turned', 'miscounted')), free)
    doubts, each = np.array([doubt]), np.array([unsteady])
    moved, = noise.of_motion(stretch, doubts, np.array([HEADING]), np.array([WIDTH]), SCALES, SLIP,
                             each)
    found = np.diag(noise.of_age(seconds, stretch.path, doubts, each)[0])
    found[noise.MOVED, noise.MOVED] += moved
    return found


def product(terms: dict[int, float]) -> np.ndarray:
    """Return the covariance of states that one disturbance moves by these."""
    g = np.zeros(s.SIZE)
    for index, value in terms.items():
        g[index] = value
    return np.outer(g, g)


def of_wheel(wheel: int, value: float) -> tuple[float, float]:
    """Return a value of one wheel, and none of the other one."""
    return (0.0, value) if wheel else (value, 0.0)


def pose(side: int) -> dict[int, float]:
    """Return where a metre of a wheel moves the robot: half a metre ahead, and round."""
    return {s.X: 0.55 * cos(HEADING), s.Y: 0.55 * sin(HEADING), s.YAW: 0.9 * side / 0.25}


def counts(side: int) -> dict[int, float]:
    """Return what its encoder makes of it."""
    return {s.DISTANCE: 0.5, s.ANGLE: side / 0.25}


@SIDES
def test_a_change_of_request_comes_at_any_moment_of_a_slot(wheel, side):
    for doubt in (1.0, 3.0):
        assert added(doubt, changes=of_wheel(wheel, 0.04)) == pytest.approx(
            doubt * JITTER * 0.04 * product({**pose(side), **counts(side)}))


@SIDES
def test_where_frames_were_lost_travel_is_unsure_whatever_the_doubt(wheel, side):
    assert added(7.0, unsure=of_wheel(wheel, 0.04)) == pytest.approx(
        0.04 * product({**pose(side), **counts(side)}))


@SIDES
def test_signs_that_were_counted_wrong_move_the_counts_alone(wheel, side):
    for doubt in (1.0, 3.0):
        assert added(doubt, miscounted=of_wheel(wheel, 2.0)) == pytest.approx(
            doubt * 0.06 ** 2 * product(counts(side)))
        assert added(doubt, turned=of_wheel(wheel, 0.09)) == pytest.approx(
            doubt * 4 * JITTER * 0.09 * product(counts(side)))


def test_free_wheels_may_run_at_any_speed():
    expected = sum((0.3 * 0.5) ** 2 * product(
        {**pose(side), **counts(side), speed: 2.0})
        for side, speed in ((1, s.SPEED_RIGHT), (-1, s.SPEED_LEFT)))
    assert added(7.0, seconds=0.5, free=True) == pytest.approx(expected)
    short = added(seconds=1e-9, free=True)
    assert short[s.SPEED_RIGHT, s.SPEED_RIGHT] == pytest.approx((0.3e-9 / SLOT) ** 2)


def rest_of(doubt: float, path: tuple[float, float]) -> np.ndarray:
    """Return what a path adds besides the slow change of what is known of the robot."""
    found = added(doubt, seconds=2.0, path=path)
    for index, prior in (s.COMMON | s.LAGS[0]).items():
        again = 0.03 * min(max(doubt - 1, 0), 10) / 10
        found[index, index] -= 2.0 * (prior.drift ** 2 + again * prior.spread ** 2)
    return found


@pytest.mark.parametrize('doubt', [0.5, 1.0, 3.0, 11.0, 50.0])
def test_a_path_slips_and_is_uneven_and_lets_what_is_known_grow_old(doubt):
    expected = sum(length ** 2 * doubt * 5e-4 ** 2 * product({**pose(side), **counts(side)})
                   + length * SLIP ** 2 * product(pose(side))
                   for side, length in ((1, 2.0), (-1, 3.0)))
    assert rest_of(doubt, (2.0, 3.0)) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize('side', [1, -1], ids=['right', 'left'])
def test_wheels_that_do_not_run_steadily_stray_with_the_root_of_their_way(side):
    """Whatever the doubt; and what is known of both gains grows old."""
    way = {'path': (2.0, 0.5) if side > 0 else (0.5, 2.0), 'seconds': 2.0}
    for doubt in (1.0, 3.0):
        more = added(doubt, unsteady=1e-4, **way) - added(doubt, **way)
        expected = 1e-4 * (2.0 * product({**pose(side), **counts(side)})
                           + 0.5 * product({**pose(-side), **counts(-side)}))
        for gain in (s.GAIN_RIGHT, s.GAIN_LEFT):
            expected[gain, gain] += 2.0 * 0.3 ** 2 * 1e-4
        assert more == pytest.approx(expected, abs=1e-14)


def test_a_robot_that_stands_does_not_change():
    assert not added(50.0, seconds=99.0, unsteady=1e-4).any()
