# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the robot was at a mark: learned on, as three more states would be."""

from math import radians

import numpy as np
import pytest

from create_oi_ros.odometry import accumulators, Geometry, Increment, Odometry
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.mark import MarkedPose
from create_oi_ros.odometry.noise import MOVED
from create_oi_ros.odometry.odometry import _nearer, STEP, TWIST
from create_oi_ros.odometry.tracks import Tracks
from support.ride import SLOT

POSE = list(s.POSE)


def doubtful(seed: int = 1) -> Assumptions:
    """Return two tracks whose states all have something to do with each other."""
    random, rows = np.random.default_rng(seed), Assumptions.all()
    rows.keep([0, 1])
    rows.means = random.normal(size=(2, s.SIZE))
    roots = random.normal(size=(2, s.SIZE, s.SIZE)) * 0.1
    rows.p = roots @ roots.transpose(0, 2, 1)
    rows.mark = MarkedPose(rows.means, rows.p)
    return rows


def joint(rows: Assumptions) -> tuple[np.ndarray, np.ndarray]:
    """Return means and covariances of the states with the mark as three states more."""
    means = np.concatenate([rows.means, rows.means[:, POSE]], axis=1)
    p = np.block([[rows.p, rows.p[:, :, POSE]],
                  [rows.p[:, POSE], rows.p[:, POSE][:, :, POSE]]])
    return means, p


def test_a_mark_is_learned_on_as_three_more_states_would_be():
    rows = doubtful()
    means, p = joint(rows)
    move = np.tile(np.eye(s.SIZE), (2, 1, 1))
    move[:, MOVED] += 0.1 * np.random.default_rng(2).normal(size=move[:, MOVED].shape)
    whole = np.tile(np.eye(s.SIZE + 3), (2, 1, 1))
    whole[:, :s.SIZE, :s.SIZE] = move
    rows.p = move @ rows.p @ move.transpose(0, 2, 1)
    rows.mark.advance(move[:, MOVED])
    p = whole @ p @ whole.transpose(0, 2, 1)
    means[:, :s.SIZE] = rows.means
    for index, value in ((s.ANGLE, 0.3), (s.GAIN_RIGHT, 1.1)):
        column = p[:, :, index]
        scale = column[:, index, None]
        means = means + column * (value - means[:, index, None]) / scale
        p = p - column[:, :, None] * column[:, None, :] / scale[:, :, None]
        rows.settle(index, value)
        assert rows.means == pytest.approx(means[:, :s.SIZE], abs=1e-9)
        assert rows.mark.poses == pytest.approx(means[:, s.SIZE:], abs=1e-9)


def test_a_reading_moves_the_mark_by_what_it_has_to_do_with_the_reading():
    rows = doubtful(3)
    before, p = rows.mark.poses.copy(), rows.p.copy()
    variances = p[:, s.DISTANCE, s.DISTANCE] + accumulators.TICKS[0] ** 2
    apart = np.array([0.2, 0.0])
    ends = rows.means[:, s.DISTANCE] + apart + np.array([[-5e-10], [5e-10]])
    accumulators._cut(rows, s.DISTANCE, ends, accumulators.TICKS[0])
    moved = p[:, POSE, s.DISTANCE] * (apart / variances)[:, None]
    assert rows.mark.poses - before == pytest.approx(moved, rel=1e-3, abs=1e-8)


def learn(rows: Assumptions, index: int) -> None:
    """Let all tracks learn of a state."""
    one = np.ones(len(rows.roundings))
    rows.mark.cut(rows.p[:, :, index], index, one, one)


def test_what_a_reading_takes_out_tells_nothing_more_of_the_mark():
    rows = doubtful()
    before = rows.mark.poses.copy()
    accumulators.take_out(rows, (1, 1))
    learn(rows, s.ANGLE)
    rows.clear(s.YAW)
    learn(rows, s.YAW)
    assert (rows.mark.poses == before).all()


def test_a_track_keeps_its_mark_and_one_that_joins_has_that_of_the_best():
    rows = doubtful()
    poses = rows.mark.poses.copy()
    rows.keep([1, 0])
    assert (rows.mark.poses == poses[[1, 0]]).all()
    others = Assumptions.all()
    rows.join(others, 0.01)
    assert len(rows.mark.poses) == 2 + len(others.roundings)
    assert (rows.mark.poses[2:] == poses[1]).all()
    learn(rows, s.GAIN_LEFT)
    assert (rows.mark.poses[2:] == poses[1]).all()
    learn(rows, s.YAW)
    assert (rows.mark.poses[2:] != poses[1]).any(axis=1).all()


def test_the_mean_is_that_of_the_shares():
    mark = doubtful().mark
    assert mark.mean(np.array([0.25, 0.75])) == pytest.approx(
        tuple(0.25 * mark.poses[0] + 0.75 * mark.poses[1]))


def test_an_error_from_before_the_mark_moves_the_mark_and_leaves_what_came_since():
    """A gain that turns out wrong corrects the turn before the mark and the one after it."""
    rows = Assumptions.new()
    rows.keep([0])
    for index in range(s.SIZE):
        rows.clear(index, float(rows.means[0, index]))
    for index, value in ((s.LAG, 0.004), (s.SLOW_LAG, 0.0), (s.FAST_LAG, 0.0), (s.RAMP, 0.0),
                         (s.DEAD_TIME, 0.0)):
        rows.clear(index, value)
    rows.clear(s.SEPARATION, 0.0, 0.05 ** 2)
    tracks = Tracks(Geometry(), rows)
    for _ in range(200):
        tracks.advance(SLOT, 0.1, -0.1)
    tracks.mark()
    marked = rows.mark.mean(rows.shares())[2]
    for _ in range(200):
        tracks.advance(SLOT, 0.1, -0.1)
    expected = tracks.pose()[2]
    tracks.read(0, round(1.02 * expected / radians(1)))
    after, moved = tracks.pose()[2], rows.mark.mean(rows.shares())[2]
    assert after / expected == pytest.approx(1.02, abs=0.01)
    assert moved / marked == pytest.approx(after / expected, abs=1e-3)


def test_the_odometry_tells_where_the_mark_is_until_it_is_unmarked():
    odometry = Odometry(window=1.0)
    assert odometry.marked is None
    for _ in range(50):
        odometry.update(Increment(SLOT, right=0.2, left=0.1, driven=True))
    odometry.mark()
    assert odometry.marked == odometry.estimate[:3] != (0.0, 0.0, 0.0)
    odometry.tracks.rows.mark.poses += [0.001, 0.0, 0.01]
    for _ in range(100):
        odometry.update(Increment(SLOT, right=0.2, left=0.1, driven=True))
    assert odometry.marked == pytest.approx(odometry.tracks.rows.mark.mean(
        odometry.tracks.rows.shares()), abs=1e-5)
    assert not odometry._plan.sparing
    odometry.unmark()
    assert odometry.marked is None
    odometry.mark(sparing=True)
    assert odometry._plan.sparing
    odometry.unmark()
    assert not odometry._plan.sparing
    odometry.mark()
    odometry.reset()
    assert odometry.marked is None


def test_an_odometry_that_believes_each_frame_corrects_no_mark():
    odometry = Odometry()
    odometry.mark()
    odometry.update(Increment(SLOT, right=0.2, left=0.2, driven=True, distance=5, angle=0))
    odometry.update(Increment(SLOT, right=0.2, left=0.2, driven=True, distance=5, angle=0))
    assert odometry.estimate.x > 0
    assert odometry.marked == (0.0, 0.0, 0.0)
    assert not odometry.seeks_rounding


def test_a_new_odometry_seeks_the_rounding_until_one_is_left():
    odometry = Odometry(window=1.0)
    assert odometry.seeks_rounding
    odometry.tracks.rows.keep([0])
    odometry.tracks._spread()
    assert not odometry.seeks_rounding


def test_a_correction_of_the_mark_is_blended_in_no_faster_than_the_estimate():
    near = _nearer((0.0, 0.0, 0.0), (1.0, 0.0, radians(20)), 0.1)
    assert near == pytest.approx((0.1 * STEP, 0.0, 0.1 * TWIST))
    assert _nearer((1.0, 2.0, 3.0), (1.0, 2.0, 3.0), 0.1) == (1.0, 2.0, 3.0)
