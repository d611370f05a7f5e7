# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What tracks say of a robot of which all is known, by sums done by hand."""

from math import cos, radians, sin, sqrt

import numpy as np
import pytest

from create_oi_ros.odometry import Geometry
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.tracks import FAMILIAR, NEAR, RESTLESS, Tracks
from create_oi_ros.odometry.wheel_model import ARRIVED
from create_oi_ros.robot import FIRMWARE_SEPARATION, Rounding
from support.ride import SLOT

MM, DEGREE = 1e-3, radians(1)


def sure(rounding: Rounding = Rounding.CARRY, scales: tuple[float, float] = (1.0, 1.0)) -> Tracks:
    """Return a single track that knows its robot: steady wheels without lag."""
    tracks = Tracks(Geometry(linear_scale=scales[0], angular_scale=scales[1], slip=0.0))
    rows = tracks.rows
    rows.keep([next(i for i, each in enumerate(rows.roundings) if each is rounding)])
    for index in range(s.SIZE):
        rows.clear(index, float(rows.means[0, index]))
    for index, value in ((s.LAG, 0.004), (s.SLOW_LAG, 0.0), (s.FAST_LAG, 0.0), (s.RAMP, 0.0),
                         (s.DEAD_TIME, 0.0), (s.DISTANCE, 0.0), (s.ANGLE, 0.0)):
        rows.clear(index, value)
    rows.steadiness[:, 1:] = -np.inf
    tracks._open_window()
    return tracks


def driven(tracks: Tracks, right: float, left: float, seconds: float) -> Tracks:
    """Let time pass under a request, slot by slot."""
    for _ in range(round(seconds / SLOT)):
        tracks.advance(SLOT, right, left)
    return tracks


RATE = 0.2 / FIRMWARE_SEPARATION
"""rad/s of wheels that run at 0.3 and 0.1 m/s."""


@pytest.mark.parametrize('scales', [(1.0, 1.0), (1.1, 0.9)])
def test_a_robot_that_drives_evenly_drives_an_arc(scales):
    tracks = driven(sure(scales=scales), 0.3, 0.1, 1.5)
    x, y, yaw = tracks.pose()
    assert tracks.rates == pytest.approx((0.2, RATE))
    for _ in range(3):
        driven(tracks, 0.3, 0.1, 0.6)
        turn = 0.6 * RATE * scales[1]
        chord = 0.12 * scales[0] * sin(turn / 2) / (turn / 2)
        x, y, yaw = x + chord * cos(yaw + turn / 2), y + chord * sin(yaw + turn / 2), yaw + turn
        assert tracks.pose() == pytest.approx((x, y, yaw), abs=1e-6)
    tracks._catch_up()
    assert tracks.pose() == pytest.approx((x, y, yaw), abs=1e-6)


def test_accumulators_hold_what_came_since_the_last_reading():
    tracks = driven(sure(), 0.3, 0.1, 1.5)
    before = tracks.held
    driven(tracks, 0.3, 0.1, 0.6)
    far, turn = (now - was for now, was in zip(tracks.held, before))
    assert (far, turn) == pytest.approx((0.12, 0.6 * RATE))
    tracks.read(round(tracks.held[0] / MM), round(tracks.held[1] / DEGREE))
    assert abs(tracks.held[0]) < MM and abs(tracks.held[1]) < DEGREE  # fractions are carried
    dropped = driven(sure(Rounding.TRUNCATE), 0.3, 0.1, 1.5)
    dropped.read(int(dropped.held[0] / MM), int(dropped.held[1] / DEGREE))
    assert dropped.held == (0.0, 0.0)


def test_a_reading_that_spans_an_unknown_time_empties_the_accumulators_and_teaches_nothing():
    tracks = driven(sure(), 0.3, 0.1, 1.5)
    pose = tracks.pose()
    tracks.discard()
    assert tracks.held == (0.0, 0.0)
    assert tracks.pose() == pytest.approx(pose)
    assert tracks.rows.readings == 0


def test_goals_are_what_the_wheels_make_of_requests():
    tracks = sure()
    for index, value in ((s.GAIN_RIGHT, 1.1), (s.GAIN_LEFT, 0.9), (s.OFFSET_RIGHT, 0.01),
                         (s.OFFSET_LEFT, -0.02)):
        tracks.rows.clear(index, value)
    assert tracks.goals(0.2, 0.1) == pytest.approx((0.23, 0.07))
    assert tracks.goals(-0.2, -0.1) == pytest.approx((-0.23, -0.07))
    assert tracks.goals(0.0, 0.0) == (0.0, 0.0)


def test_wheels_in_the_air_count_and_move_nothing():
    tracks = driven(sure(), 0.3, 0.1, 1.5)
    pose, held = tracks.pose(), tracks.held
    tracks.lift(True)
    driven(tracks, 0.3, 0.1, 0.6)
    assert tracks.pose() == pytest.approx(pose)
    assert tracks.held[0] - held[0] == pytest.approx(0.12)
    tracks.lift(False)
    driven(tracks, 0.3, 0.1, 0.6)
    assert tracks.pose()[2] - pose[2] == pytest.approx(0.6 * RATE)


def test_free_wheels_may_do_anything_and_bound_ones_run_as_asked():
    tracks = driven(sure(), 0.3, 0.1, 1.5)
    tracks.free(True)
    assert tracks.is_free and tracks.rates == (0.0, 0.0) and not tracks.rests
    assert tracks.rows.p[0, s.SPEED_LEFT, s.SPEED_LEFT] == pytest.approx(0.03 ** 2)
    tracks.free(False)
    assert not tracks.is_free
    assert tracks.rates == pytest.approx((0.2, RATE))
    tracks.resume(0.1, 0.3)
    assert tracks.requests == (0.1, 0.3)
    assert tracks.rates == pytest.approx((0.2, -RATE))


def test_what_moves_neither_rests_nor_is_settled_at_once():
    tracks = sure()
    assert not tracks.rests and not tracks.settled
    driven(tracks, 0.0, 0.0, 0.6)
    assert tracks.rests and tracks.settled
    driven(tracks, 0.3, 0.1, 0.03)
    assert not tracks.rests
    driven(tracks, 0.3, 0.1, 0.9)
    assert tracks.settled and not tracks.rests


def speeds(tracks: Tracks) -> np.ndarray:
    """Return the speeds that the tracks believe the wheels to have."""
    return tracks.wheels.speed[:, :, 0]


def test_wheels_that_run_steadily_run_at_their_new_goals_after_a_reading():
    tracks = driven(Tracks(Geometry()), 0.3, 0.1, 3.0)
    before = speeds(tracks).copy()
    assert tracks.wheels.settled
    tracks.read(880, 120)
    assert tracks.wheels.settled and not tracks.rests
    after = speeds(tracks).copy()
    assert (after != before).all()
    means = tracks.rows.means
    gains, offsets = (
        means[:, [right, left]].T
        for right, left in ((s.GAIN_RIGHT, s.GAIN_LEFT), (s.OFFSET_RIGHT, s.OFFSET_LEFT)))
    assert after == pytest.approx(gains * [[0.3], [0.1]] + offsets)
    driven(tracks, 0.3, 0.1, 0.3)
    tracks.pose_covariance()
    assert (speeds(tracks) == after).all()


def test_wheels_that_change_their_speed_go_on_to_do_so_after_a_reading():
    tracks = driven(Tracks(Geometry()), 0.3, 0.1, 3.0)
    tracks.read(880, 120)
    driven(tracks, 0.1, 0.3, 0.15)
    tracks.read(30, 8)
    assert not tracks.wheels.settled
    before = speeds(tracks).copy()
    driven(tracks, 0.1, 0.3, 0.15)
    tracks.pose_covariance()
    assert (speeds(tracks) != before).all()


def test_a_reading_of_nothing_at_rest_teaches_nothing():
    tracks = driven(sure(), 0.0, 0.0, 0.9)
    tracks.read(0, 0)
    assert tracks.rows.readings == 0
    tracks.read(0, 1)
    assert tracks.rows.readings == 1


@pytest.mark.parametrize(('distance', 'angle'), [(0, 20), (50, 0), (-50, -20), (1, 0)])
def test_a_reading_that_spans_an_unknown_motion_is_believed(distance, angle):
    tracks = driven(sure(), 0.0, 0.0, 0.3)
    tracks.rows.clear(s.SPEED_RIGHT, 0.0, 1e-6)  # else they rest, and nothing is read
    tracks.read(distance, angle, doubted=True)
    rows = tracks.rows
    assert rows.means[0, s.X] == pytest.approx(distance * MM, abs=1.5 * MM)
    assert rows.means[0, s.YAW] == pytest.approx(angle * DEGREE, abs=1.5 * DEGREE)
    assert (rows.p[0].diagonal()[[s.X, s.YAW]] > 0).all()


def test_wheels_that_nobody_drives_or_pushes_may_still_begin_to_move():
    tracks = driven(sure(), 0.0, 0.0, 0.3)
    tracks.free(True)
    driven(tracks, 0.0, 0.0, 0.3)
    tracks.read(0, 0, driven=False)
    assert tracks.rows.p[0].diagonal()[[*s.SPEEDS]] == pytest.approx(RESTLESS ** 2)


def test_wheels_that_cease_to_obey_keep_their_speed():
    tracks = driven(Tracks(Geometry()), 0.3, 0.1, 0.2)
    assert tracks.wheels.rates.any()  # of springs, which swing
    tracks.free(True)
    assert not tracks.rows.rates.any()


def test_wheels_are_settled_before_they_are_quite_at_their_goals():
    tracks = driven(Tracks(Geometry()), 0.3, 0.1, 0.4)
    while not tracks.settled:
        driven(tracks, 0.3, 0.1, SLOT)
    assert not tracks.wheels.settled
    assert ARRIVED < tracks.wheels.farthest < NEAR


def test_a_reset_puts_the_origin_where_the_robot_is():
    tracks = driven(sure(), 0.3, 0.1, 1.5)
    held = tracks.held
    tracks.reset()
    assert tracks.pose() == (0.0, 0.0, 0.0)
    assert tracks.held == pytest.approx(held)
    assert not tracks.rows.p[0, s.X:s.YAW + 1].any()


@pytest.mark.parametrize(('rounding', 'taught', 'doubt', 'known'), [
    (Rounding.TRUNCATE, 0, 1.0, 0.0), (Rounding.TRUNCATE, FAMILIAR / 2, 1.0, 0.5),
    (Rounding.ROUND, 90, 5.0, 1.0), (Rounding.TRUNCATE, FAMILIAR, 5.1, 0.0),
    (Rounding.CARRY, FAMILIAR, 1.0, 0.0)])
def test_a_robot_is_familiar_after_some_readings(rounding, taught, doubt, known):
    tracks = sure(rounding)
    tracks.rows.taught, tracks.rows.doubt[:] = taught, doubt
    tracks.reset()
    assert tracks.known == known


def test_readings_teach_how_wheels_run_by_the_time_between_them():
    tracks = sure()
    for seconds, taught in (0.5, 0.5), (0.015, 0.515), (3.0, 1.515):
        tracks = driven(tracks, 0.3, 0.1, seconds)
        tracks.read(round(tracks.held[0] / MM), round(tracks.held[1] / DEGREE))
        assert tracks.rows.taught == pytest.approx(taught, abs=0.01)


@pytest.mark.parametrize(('distance', 'angle', 'explained'), [
    (0, 0, True), (5, 0, True), (-5, 0, True), (6, 0, False), (-6, 0, False),
    (0, 5, True), (0, 6, False), (0, -6, False)])
def test_a_reading_within_four_deviations_and_a_unit_is_explained(distance, angle, explained):
    tracks = sure()
    rows = tracks.rows
    rows.clear(s.DISTANCE, 0.0, MM ** 2)
    rows.clear(s.ANGLE, 0.0, DEGREE ** 2)
    assert tracks.explains(distance, angle) == explained
    rows.weights = np.array([1e-3])
    assert not tracks.explains(0, 0)


def test_covariances_of_pose_and_twist_are_those_of_the_states():
    tracks = driven(sure(), 0.3, 0.1, 1.5)
    tracks.reset()
    rows = tracks.rows
    for index, variance in ((s.X, 4e-4), (s.Y, 9e-4), (s.YAW, 1e-4), (s.DISTANCE, 16e-6),
                            (s.ANGLE, DEGREE ** 2 / 4)):
        rows.clear(index, float(rows.means[0, index]), variance)
    covariance = np.array(tracks.pose_covariance()).reshape(3, 3)
    assert covariance == pytest.approx(np.diag([4e-4, 9e-4, 1e-4]), abs=1e-12)
    assert tracks.blur == pytest.approx(2.0)  # 4 mm; half a degree is less
    rows.clear(s.ANGLE, 0.0, (3 * DEGREE) ** 2)
    tracks.pose_covariance()
    assert tracks.blur == pytest.approx(3.0)
    for index, variance in ((s.SPEED_RIGHT, 1e-4), (s.SPEED_LEFT, 2e-4), (s.GAIN_RIGHT, 1e-2),
                            (s.GAIN_LEFT, 3e-2)):
        rows.clear(index, float(rows.means[0, index]), variance)
    both = 3e-4 + 1e-2 * 0.09 + 3e-2 * 0.01
    assert tracks.twist_variance() == pytest.approx(
        (both / 4 + 1e-6, both / FIRMWARE_SEPARATION ** 2 + 1e-6), rel=1e-3)


def test_a_glance_at_the_covariance_changes_nothing():
    tracks, other = (driven(Tracks(Geometry()), 0.3, 0.1, 1.5) for _ in range(2))
    for each in tracks, other:
        each.pose_covariance()
        driven(each, -0.2, 0.3, 0.105)
    blur, behind, before = tracks.blur, tracks.wheels.behind, speeds(tracks).copy()
    seen = tracks.pose_covariance(glance=True)
    assert (tracks.blur, tracks.wheels.behind) == (blur, behind)
    assert behind and (speeds(tracks) == before).all()
    looked = other.pose_covariance()
    assert [seen[i] for i in (0, 4, 8)] == pytest.approx([looked[i] for i in (0, 4, 8)], rel=0.3)
    assert other.blur != blur and not other.wheels.behind
    assert tracks.pose_covariance() == looked


def test_the_pose_of_wheels_that_overshoot_is_less_sure_than_their_filter_is():
    tracks = driven(sure(), 0.3, 0.1, 1.5)
    tracks.rows.clear(s.YAW, 0.0, 1e-4)
    believed, blur = np.array(tracks.pose_covariance()), tracks.blur
    tracks.rows.springs[:], tracks.rows.readings = True, 30
    assert tracks.pose_covariance() == pytest.approx(believed)  # it is new
    tracks.rows.readings = 31
    assert tracks.pose_covariance() == pytest.approx(1.5 * believed)
    assert tracks.blur == blur


def test_doubt_of_the_heading_becomes_doubt_of_the_place_as_the_robot_drives():
    tracks = driven(sure(), 0.2, 0.2, 1.5)
    tracks.reset()
    tracks.rows.clear(s.YAW, 0.0, 1e-4)
    tracks._open_window()
    driven(tracks, 0.2, 0.2, 1.5)
    *_, yy, ya, _, _, aa = tracks.pose_covariance()
    assert aa == pytest.approx(1e-4, rel=1e-2)
    assert sqrt(yy) == pytest.approx(0.3 * 0.01, rel=1e-2)
    assert ya == pytest.approx(0.3 * 1e-4, rel=1e-2)
