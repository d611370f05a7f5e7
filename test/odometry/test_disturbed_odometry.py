# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Odometry of robots that are held, pushed or lifted, and over lines that lose readings."""

from dataclasses import replace
from math import degrees, hypot

import pytest

from create_oi_ros.odometry import Increment, Odometry
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import IDEAL
from create_oi_ros.sim.world import World
from support.ride import assert_smooth, Ride, ROUNDINGS, SLOT


def test_a_reversal_just_before_a_reading_is_no_disobedience() -> None:
    ride = Ride(config=replace(IDEAL, wheel_acceleration=1.0))
    ride.learn()
    for right in (0.4, -0.4) * 6:
        while not ride.odometry.reading_due:
            ride.go(SLOT, right, -right)
        for _ in range(60):
            ride.go(SLOT, -right, right)
            assert not ride.odometry.tracks.is_free


def test_after_an_interruption_it_goes_on_from_where_it_was_without_a_jump() -> None:
    ride = Ride()
    ride.go(5, 0.2, 0.2)
    ride.odometry.interrupted()
    ride.body.step(2.0)
    ride.go(8, 0.2, 0.2)
    ride.go(3)
    assert_smooth(ride.estimates)
    assert ride.miss[0] < 0.05


def test_an_interruption_in_which_the_robot_moved_unseen_leaves_doubt() -> None:
    ride = Ride()
    ride.learn()
    ride.odometry.reset()
    ride.go(5, 0.2, 0.2)
    before = ride.estimates[-1].pose_covariance
    ride.odometry.interrupted()
    ride.body.push(speed=0.2, rate=1.0, seconds=3.0)
    ride.body.step(3.0)
    after = ride.go(3).pose_covariance
    assert after[0] + after[4] > 10 * (before[0] + before[4])


def test_the_first_reading_may_hold_travel_from_before() -> None:
    body = Body(World())
    body.drive(right=0.3, left=0.3)
    body.step(10.0)
    odometry = Odometry(window=1.0)
    odometry.update(Increment(dt=SLOT, right=0.0, left=0.0, driven=True,
                              distance=body.take_distance(), angle=body.take_angle()))
    assert (odometry.estimate.x, odometry.estimate.yaw) == (0.0, 0.0)


def test_a_held_robot_is_believed_to_stand() -> None:
    ride = Ride()
    ride.go(20, 0.2, 0.2)
    ride.body.hold(right=True, left=True)
    held = ride.body.truth().travelled
    estimate = ride.go(10, 0.2, 0.2)
    assert estimate.x == pytest.approx(held, abs=0.02)
    assert abs(estimate.linear) < 0.02
    ride.body.hold(right=False, left=False)
    ride.go(10, 0.2, 0.2)
    assert ride.miss[0] < 0.03
    assert_smooth(ride.estimates)


def test_a_pushed_robot_is_followed() -> None:
    ride = Ride()
    ride.go(20, 0.18, 0.16)
    ride.driven = False
    ride.body.drive(right=0.0, left=0.0)
    ride.go(3)
    ride.body.push(speed=0.2, rate=0.1, seconds=5.0)
    ride.go(9)
    assert ride.miss[0] < 0.1
    assert ride.miss[1] < 5
    assert_smooth(ride.estimates)


def test_a_lifted_robot_goes_nowhere() -> None:
    odometry = Odometry(window=1.0)
    for frame in range(200):
        estimate = odometry.update(Increment(
            dt=SLOT, right=0.3, left=0.2, driven=True, lifted=True,
            distance=300 if frame % 66 == 65 else None, angle=20 if frame % 66 == 65 else None))
    assert hypot(estimate.x, estimate.y) < 0.01


def test_a_reading_that_was_lost_on_the_line_does_not_take_travel_back() -> None:
    ride = Ride()
    ride.go(20, 0.3, 0.25)
    while not ride.odometry.reading_due:
        ride.go(SLOT, 0.3, 0.25)
    ride.body.step(SLOT)
    ride.body.take_distance(), ride.body.take_angle()
    ride.hear(False, lost=True)
    ride.go(5, 0.3, 0.25)
    ride.go(3)
    assert ride.miss[0] < 0.08
    assert ride.miss[1] < 3


def doubt_after(ride: Ride, seconds: float) -> float:
    """Return how little the yaw is known, degrees, after a reading in the last second of many."""
    ride.go(seconds)
    return degrees(min(each.pose_covariance[8] for each in ride.estimates[-70:]) ** 0.5)


@pytest.mark.parametrize('rounding', ROUNDINGS)
def test_a_robot_that_stands_in_passive_stays_where_it_is_known_to_be(rounding: Rounding) -> None:
    """Nothing drives it. It may be pushed, but readings of zero say that it is not."""
    ride = Ride(rounding)
    ride.driven = False
    before = doubt_after(ride, 10)
    assert doubt_after(ride, 600) < before + 0.1
    ride.body.push(speed=0.2, rate=0.5, seconds=3.0)
    pushed = doubt_after(ride, 10)
    assert pushed > before + 2
    assert doubt_after(ride, 600) < pushed + 0.1


def test_the_time_before_the_first_frame_moves_nothing_from_the_origin() -> None:
    """Nobody knows what a robot did that nothing drove, but the origin is where it is now."""
    odometry = Odometry(window=1.0)
    odometry.update(Increment(dt=SLOT, right=0.0, left=0.0, driven=False, distance=0, angle=0))
    assert odometry.estimate.pose_covariance[8] < 1e-8


def test_a_held_robot_is_not_taken_for_one_whose_reading_was_lost() -> None:
    """No frame is missing; the line was just too slow for the question."""
    ride = Ride()
    ride.go(20, 0.2, 0.2)
    while not ride.odometry.reading_due:
        ride.go(SLOT, 0.2, 0.2)
    ride.go(SLOT, 0.2, 0.2)
    ride.body.hold(right=True, left=True)
    for speed, frames in ((0.2, 70), (0.0, 70)):
        ride.right = ride.left = speed
        for _ in range(frames):
            ride.body.step(SLOT)
            ride.hear(False)
    ride.go(3)
    assert ride.miss[0] < 0.02
    assert_smooth(ride.estimates)


def test_a_reading_behind_a_gap_is_believed_if_it_holds_all_since_the_last_one() -> None:
    """A frame was lost before the answer came; it may have carried an answer of its own."""
    for taken in (False, True):
        ride = Ride()
        ride.learn()
        ride.begin()
        ride.go(4, 0.3, 0.25)
        while not ride.odometry.reading_due:
            ride.go(SLOT, 0.3, 0.25)
        if taken:
            ride.body.take_distance(), ride.body.take_angle()
        ride.body.step(SLOT)
        ride.hear(True, lost=True)
        ride.go(5, 0.3, 0.25)
        ride.go(3)
        assert ride.miss[0] < 0.03
        assert ride.miss[1] < 3


def test_travel_that_the_robot_forgot_is_not_taken_back() -> None:
    """It waited for an angle in a script, and counts from there."""
    ride = Ride()
    ride.learn()
    ride.begin()
    ride.go(4, 0.3, 0.25)
    ride.body.take_distance(), ride.body.take_angle()
    ride.odometry.recounted()
    ride.go(5, 0.3, 0.25)
    ride.go(3)
    assert ride.miss[0] < 0.01
    assert ride.miss[1] < 1
