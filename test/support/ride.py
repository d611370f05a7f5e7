# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A body that an odometry follows, frame by frame, without a driver."""

from math import cos, degrees, hypot, isfinite, radians, sin

from create_oi_ros.odometry import Estimate, Geometry, Increment, Odometry
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig, IDEAL
from create_oi_ros.sim.world import World

SLOT = 0.015
HALF_TRACK = 0.129
TOP = 0.5
ROUNDINGS = list(Rounding)
Request = tuple[float, float, float]
"""Seconds, and the speeds of the right and left wheel."""
LESSON = [(0.3, 0.1), (0.05, -0.05), (-0.2, -0.3), (0.18, 0.18), (-0.1, 0.15), (0.0, 0.0)]
"""What teaches an odometry most: speeds of the right and left wheel."""


class Ride:
    """A body that an odometry follows: the answer to a question comes in the next frame."""

    def __init__(self, rounding: Rounding = Rounding.TRUNCATE, *, window: float = 1.0,
                 geometry: Geometry | None = None, frame: int = 1,
                 config: BodyConfig | None = None) -> None:
        self.body = Body(World(), rounding=rounding, config=config or IDEAL)
        self.odometry = Odometry(geometry or Geometry(), window=window)
        self.frame = frame * SLOT
        self.right = self.left = 0.0
        self.driven = True
        self.estimates = [self.odometry.estimate]
        self.origin = self.body.truth()
        self.go(0.1)

    def go(self, seconds: float, right: float = 0.0, left: float = 0.0) -> Estimate:
        """Drive for a while."""
        self.right, self.left = right, left
        if self.driven:
            self.body.drive(right=right, left=left)
        for _ in range(round(seconds / self.frame)):
            self.body.step(self.frame)
            self.hear(self.odometry.reading_due)
        return self.estimates[-1]

    def hear(self, reading: bool, *, lost: bool = False) -> None:
        """Take the next frame in; `lost`: another may have been lost before it."""
        self.estimates.append(self.odometry.update(Increment(
            dt=self.frame, right=self.right, left=self.left, driven=self.driven, lost=lost,
            distance=self.body.take_distance() if reading else None,
            angle=self.body.take_angle() if reading else None)))

    def learn(self) -> None:
        """Drive until the odometry knows the robot."""
        for right, left in LESSON * 2:
            self.go(2.5, right, left)
        self.go(2)

    def begin(self) -> None:
        """Measure from here: the origin of the odometry is put where the robot is."""
        self.go(2)
        self.odometry.reset()
        self.origin = self.body.truth()

    @property
    def went(self) -> tuple[float, float]:
        """How far the robot has gone and turned since it began, m and rad."""
        truth = self.body.truth()
        return truth.travelled - self.origin.travelled, truth.turned - self.origin.turned

    @property
    def miss(self) -> tuple[float, float]:
        """How far off the estimate is, m and degrees."""
        (x, y, yaw), truth = self.origin.pose, self.body.truth()
        estimate = self.odometry.estimate
        east, north = truth.pose.x - x, truth.pose.y - y
        return (hypot(estimate.x - east * cos(yaw) - north * sin(yaw),
                      estimate.y - north * cos(yaw) + east * sin(yaw)),
                abs(degrees(estimate.yaw - truth.turned + self.origin.turned)))


def assert_smooth(estimates: list[Estimate], frame: float = SLOT) -> None:
    """No step is larger than what the robot can have moved, 1 mm and 0.2 degrees."""
    reach = TOP * 1.03 * frame
    for a, b in zip(estimates, estimates[1:]):
        assert hypot(b.x - a.x, b.y - a.y) <= reach + 1e-3
        assert abs(b.yaw - a.yaw) <= reach / HALF_TRACK + radians(0.2)


def assert_sound(estimate: Estimate) -> None:
    """Everything is finite, the covariance symmetric and positive definite."""
    a, b, c, d, e, f, g, h, i = estimate.pose_covariance
    assert all(map(isfinite, estimate.pose_covariance + estimate.twist_covariance))
    assert all(map(isfinite, (estimate.x, estimate.y, estimate.yaw, estimate.linear,
                              estimate.angular, estimate.right_wheel, estimate.left_wheel)))
    assert (b, c, f) == (d, g, h)
    assert a > 0 and a * e - b * b > 0
    assert a * (e * i - f * f) - b * (b * i - c * f) + c * (b * f - c * e) > 0
    assert min(estimate.twist_covariance) > 0
