# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Odometry that believes what the robot reports, by sums done by hand."""

from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest

from create_oi_ros.odometry import Estimate, Geometry, Increment
from create_oi_ros.odometry.plain import PlainOdometry
from create_oi_ros.robot import WHEEL_RADIUS, WHEEL_SEPARATION

GEOMETRY = Geometry(wheel_separation=0.25, wheel_radius=0.03, linear_scale=1.1, angular_scale=0.9)
P = np.array([[4.0, 1.0, 0.5], [1.0, 9.0, -0.7], [0.5, -0.7, 2.0]])
BEFORE = Estimate(1.0, 2.0, 0.6, pose_covariance=tuple(P.ravel().tolist()), right_wheel=5.0,
                  left_wheel=7.0)


def frame(distance: int | None, angle: int | None = 0, *, dt: float = 0.5, right: float = 0.0,
          left: float = 0.0) -> Increment:
    """Return what a frame says."""
    return Increment(dt, right, left, driven=True, distance=distance, angle=angle)


def after(distance: int, angle: int = 0, **more: float) -> Estimate:
    """Return the estimate after one frame."""
    return PlainOdometry(GEOMETRY).after(BEFORE, frame(distance, angle, **more))


def test_an_arc_is_driven_along_its_chord():
    found, turn = after(500, 90), radians(81)
    chord = 0.55 * sin(turn / 2) / (turn / 2)
    assert found.x == pytest.approx(1.0 + chord * cos(0.6 + turn / 2))
    assert found.y == pytest.approx(2.0 + chord * sin(0.6 + turn / 2))
    assert found.yaw == pytest.approx(0.6 + turn)
    assert (found.linear, found.angular) == pytest.approx((0.55 / 0.5, turn / 0.5))
    right, left = (0.55 + turn / 8) / 0.03, (0.55 - turn / 8) / 0.03
    assert (found.right_wheel, found.left_wheel) == pytest.approx((5 + right, 7 + left))
    assert (found.right_wheel_speed, found.left_wheel_speed) == pytest.approx(
        (2 * right, 2 * left))


def test_a_straight_line_is_as_long_as_it_says():
    found = after(-200)
    assert (found.x, found.y) == pytest.approx((1.0 - 0.22 * cos(0.6), 2.0 - 0.22 * sin(0.6)))
    assert found.yaw == 0.6


@pytest.mark.parametrize(('reading', 'more', 'grows'), [
    ((500, 90), {}, 1), ((0, 0), {'right': 0.1}, 1), ((0, 0), {'left': -0.1}, 1),
    ((1, 0), {}, 1), ((0, 1), {}, 1), ((0, 0), {}, 0)])
def test_covariance_is_carried_along_and_grows_by_what_a_reading_drops(reading, more, grows):
    found = after(*reading, **more)
    dx, dy = found.x - 1.0, found.y - 2.0
    f = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
    lost = np.diag([1e-6 / 3, 1e-6 / 3, radians(1) ** 2 / 3])
    assert np.array(found.pose_covariance).reshape(3, 3) == pytest.approx(
        f @ P @ f.T + grows * lost, rel=1e-12, abs=1e-15)
    assert found.twist_covariance == pytest.approx(
        (1e-6 / 3 / 0.5 ** 2, radians(1) ** 2 / 3 / 0.5 ** 2))


def test_between_readings_it_stays_and_time_adds_up():
    odometry = PlainOdometry(GEOMETRY)
    for lacking in (frame(None, 5), frame(5, None), frame(None, None)):
        assert odometry.after(BEFORE, lacking) is BEFORE
    assert odometry.after(BEFORE, frame(100)).linear == pytest.approx(0.11 / 2.0)
    assert odometry.after(BEFORE, frame(100)).linear == pytest.approx(0.11 / 0.5)


def test_a_robot_that_nobody_calibrated_is_as_it_was_built_and_begins_at_the_origin():
    geometry = Geometry()
    assert (geometry.wheel_separation, geometry.wheel_radius) == (WHEEL_SEPARATION, WHEEL_RADIUS)
    assert (geometry.linear_scale, geometry.angular_scale) == (1.0, 1.0)
    assert 0 < geometry.slip < 0.002
    numbers = [value for value in Estimate() if isinstance(value, float)]
    assert not any(numbers) and len(numbers) == 9
    assert Estimate().gyro is None
    covariance = np.array(Estimate().pose_covariance).reshape(3, 3)
    assert (covariance == 1e-9 * np.eye(3)).all()
    assert Estimate().twist_covariance == (1e-6, 1e-6)


def test_a_frame_says_nothing_that_it_does_not_say():
    assert Increment(0.1, 0.0, 0.0, True)[4:] == (None, None, False, False, None, False)
    assert hash(GEOMETRY) == hash(replace(GEOMETRY))
