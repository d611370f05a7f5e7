# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How the estimate follows what is believed: it moves along, and corrections are blended in."""

from math import cos, exp, hypot, pi, radians, sin

import pytest

from create_oi_ros.odometry import Estimate, Geometry, Increment, Odometry
from support.ride import Ride, SLOT

DT = 0.02
GEOMETRY = Geometry(wheel_separation=0.25, wheel_radius=0.04)
TOP, TOP_TURN = 0.515, 2 * 0.515 / 0.258
PART = 1 - exp(-0.2)
"""What is blended in of a small correction in this time."""
SURE = (4.0, 1.0, 0.5, 1.0, 9.0, -0.7, 0.5, -0.7, 2.0)


def odometry(goal: tuple[float, float, float], yaw: float = 0.0, hasty: float = 0.0,
             free: bool = False) -> Odometry:
    """Return an odometry at the origin whose tracks believe the robot to be at a goal."""
    made = Odometry(GEOMETRY, window=1.0)
    made.estimate = Estimate(yaw=yaw, right_wheel=1.0, left_wheel=2.0)
    made._goal, made._hasty, made._covariance = goal, hasty, SURE
    made._twist_variance = (0.3, 0.4)
    made.tracks.wheels.free = free
    return made


def test_without_a_correction_it_moves_as_the_robot_does():
    turn, far = 0.04, 0.008
    x, y = far * cos(0.6 + turn / 2), far * sin(0.6 + turn / 2)
    made = odometry((x, y, 0.6 + turn), yaw=0.6)
    after = made._followed(DT, far, turn)
    assert (after.x, after.y, after.yaw) == pytest.approx((x, y, 0.6 + turn))
    assert (after.linear, after.angular) == pytest.approx((0.4, 2.0))
    right, left = (far + turn / 8) / 0.04, (far - turn / 8) / 0.04
    assert (after.right_wheel, after.left_wheel) == pytest.approx((1 + right, 2 + left))
    assert (after.right_wheel_speed, after.left_wheel_speed) == pytest.approx(
        (right / DT, left / DT))
    floor = [1e-9 * (place in (0, 4, 8)) for place in range(9)]
    assert after.pose_covariance == pytest.approx([a + b for a, b in zip(SURE, floor)])
    assert after.twist_covariance == (0.3, 0.4)
    assert not made._caught_up


# A correction of 5 mm is blended in within 0.1 s; of more, 6.7 cm in a second; one that is farther
# than 3 cm, as fast as a robot can move, less what it moves now.
@pytest.mark.parametrize(('far', 'went', 'step'), [
    (0.005, 0.0, 0.005 * PART), (0.02, 0.0, 0.067 * DT), (0.029, 0.0, 0.067 * DT),
    (0.031, 0.0, 0.031 * PART), (0.2, 0.006, TOP * DT - 0.006), (0.2, -0.006, TOP * DT - 0.006),
    (0.2, 0.0103, 0.067 * DT)])
@pytest.mark.parametrize('way', [0.0, 2.0])
def test_a_correction_of_the_place_is_blended_in(far, went, step, way):
    goal = went + far * cos(way), far * sin(way), 0.0
    after = odometry(goal)._followed(DT, went, 0.0)
    assert (after.x - went, after.y) == pytest.approx((step * cos(way), step * sin(way)))
    assert after.linear == pytest.approx(went / DT)
    assert hypot(after.x - went, after.y) <= far * PART + 1e-12
    x, y = goal[0] - after.x, goal[1] - after.y
    xx, xy, _, _, yy, *_ = after.pose_covariance
    assert (xx, xy, yy) == pytest.approx((4 + x * x + 1e-9, 1 + x * y, 9 + y * y + 1e-9))
    forward = after.x / 0.04
    assert (after.right_wheel, after.left_wheel) == pytest.approx((1 + forward, 2 + forward))


@pytest.mark.parametrize(('askew', 'hasty', 'free', 'turned', 'step'), [
    (0.5, 0.0, False, 0.0, 0.5 * PART), (4.9, 9.0, True, 0.0, 0.16), (40.0, 0.0, False, 0.0, 0.16),
    (40.0, 0.01, False, 0.0, 0.0), (40.0, 0.0, True, 0.02, 0.0), (5.1, 0.01, False, 0.0, 0.0)])
@pytest.mark.parametrize('sign', [1, -1])
def test_a_correction_of_the_heading_is_blended_in(askew, hasty, free, turned, step, sign):
    """By 8 degrees a second; as fast as a robot turns where it may have turned unseen."""
    fast = TOP_TURN * DT - turned
    expected = sign * (radians(step) if step else min(fast, radians(askew) * PART))
    made = odometry((0.0, 0.0, sign * (turned + radians(askew))), hasty=hasty, free=free)
    after = made._followed(DT, 0.0, sign * turned)
    assert after.yaw == pytest.approx(sign * turned + expected)
    assert after.angular == pytest.approx(sign * turned / DT)
    rest = sign * (turned + radians(askew)) - after.yaw
    assert after.pose_covariance[8] == pytest.approx(2 + rest ** 2 + 1e-9)
    assert after.right_wheel - 1 == pytest.approx(after.yaw / 8 / 0.04)
    assert after.left_wheel - 2 == pytest.approx(-after.yaw / 8 / 0.04)


def test_what_is_left_of_both_corrections_is_doubt_of_both():
    after = odometry((0.004, 0.002, 0.01))._followed(DT, 0.0, 0.0)
    rest = 1 - PART
    _, _, xa, _, _, ya, xa2, ya2, _ = after.pose_covariance
    assert (xa, ya) == pytest.approx((0.5 + rest ** 2 * 4e-5, -0.7 + rest ** 2 * 2e-5))
    assert (xa2, ya2) == (xa, ya)


@pytest.mark.parametrize('sign', [1, -1])
def test_it_is_never_faster_than_a_robot(sign):
    after = odometry((sign * 9.0, 0.0, 0.0))._followed(DT, sign * 9.0, 0.0)
    assert after.linear == pytest.approx(sign * TOP)
    after = odometry((0.0, 0.0, sign * 9.0))._followed(DT, 0.0, sign * 9.0)
    assert after.angular == pytest.approx(sign * TOP_TURN)


@pytest.mark.parametrize(('goal', 'went', 'turned', 'caught_up'), [
    ((0.0, 0.0, 0.0), 0.0, 0.0, True), ((9e-8, 0.0, 9e-8), 0.0, 0.0, True),
    ((2e-7, 0.0, 0.0), 0.0, 0.0, False), ((0.0, 2e-7, 0.0), 0.0, 0.0, False),
    ((0.0, 0.0, -2e-7), 0.0, 0.0, False), ((1e-8, 0.0, 0.0), 1e-8, 0.0, False),
    ((0.0, 0.0, 1e-8), 0.0, 1e-8, False)])
def test_it_rests_where_the_tracks_rest(goal, went, turned, caught_up):
    made = odometry(goal)
    made._followed(DT, went, turned)
    assert made._caught_up == caught_up


def test_a_reset_keeps_the_wheels_and_puts_all_else_to_the_origin():
    made = odometry((1.0, 2.0, pi))
    made.reset()
    assert made.estimate == Estimate(right_wheel=1.0, left_wheel=2.0)
    assert made._goal == pytest.approx((0.0, 0.0, 0.0))


def test_without_a_window_every_frame_carries_a_reading():
    assert Odometry().window == 0.0 and Odometry().reading_due


def test_a_robot_that_turned_drives_where_it_looks():
    made = Odometry(GEOMETRY, window=1.0)
    for right, left, frames in ((0.1, -0.1, 100), (0.0, 0.0, 50), (0.2, 0.2, 100)):
        for _ in range(frames):
            made.update(Increment(0.015, right, left, driven=True))
    assert made.estimate.yaw > 0.8
    assert made.estimate.linear == pytest.approx(0.2, abs=0.005)
    assert made.estimate.y > 0.8 * made.estimate.x > 0


def test_haste_ends_with_time():
    made = odometry((0.0, 0.0, 0.0), hasty=1.0)
    made.update(Increment(DT, 0.0, 0.0, driven=True))
    assert made._hasty == pytest.approx(1.0 - DT)


def test_there_is_no_haste_to_correct_what_was_no_motion_until_it_is_small():
    made = odometry((0.0, 0.0, radians(40)), hasty=9.0, free=True)
    made._patient = True
    assert made._followed(DT, 0.0, 0.0).yaw == pytest.approx(radians(0.16))
    assert made._patient
    made._goal = 0.0, 0.0, radians(4)
    made._followed(DT, 0.0, 0.0)
    assert not made._patient


@pytest.mark.parametrize('slots', [0, 20])
def test_a_robot_that_is_held_is_not_turned_back_in_a_leap(slots):
    ride = Ride()
    ride.learn()
    ride.begin()
    ride.go(slots * SLOT, 0.1, -0.1)
    ride.body.drive(right=0, left=0)  # held: it still says that it is asked to turn
    ride.right, ride.left = 0.1, -0.1
    for _ in range(400):
        ride.hear(ride.odometry.reading_due)
    heard = ride.estimates[-400:]
    corrections = [b.yaw - a.yaw - b.angular * SLOT for a, b in zip(heard, heard[1:])]
    assert sum(corrections) < radians(-10)
    assert min(corrections) > radians(-8.1) * SLOT
