# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The ways that motions are made of: a straight line, a turn in place, an arc.

A leg measures what is left of it and steers along it, by the odometry. All lengths that it gives
the approach are metres of the faster wheel, so that one profile fits all.
"""

from abc import ABC, abstractmethod
from math import atan2, copysign, cos, hypot, inf, pi, radians, remainder, sin, sqrt, tau

from ...odometry import Estimate
from ..events import MotionLimits
from ..motion import Velocity
from .approach import Approach, Learned, Remaining
from .goal import View

STRAIGHT_TOLERANCE, TURN_TOLERANCE = 0.002, radians(0.5)
"""m and rad."""
HEADING_GAIN, ASIDE_GAIN = 2.0, 4.0
"""rad/s per radian, and radians per metre, by which a robot is steered back to its line."""
STEEPEST = 0.5
"""Radians at most at which a robot drives back to its line."""
SHARPEST, MOST_BEND = 0.8, 4.0
"""rad/s of steering at most, and rad/s per m/s."""


class Leg(ABC):
    """One way, from where the robot is when the leg is made."""

    forward = False
    """Whether it leads forward."""

    def __init__(self, estimate: Estimate, way: float, approach: Approach) -> None:
        self._last = estimate
        self._left = way
        self._approach = approach
        self._least = inf
        """The least variance of the odometry since the start, m²."""

    def step(self, view: View) -> Velocity | None:
        """Return the velocity until the next frame; None: the robot is there."""
        self._left -= self._went(view.estimate)
        self._last = view.estimate
        variance = self._variance(view.estimate)
        self._least = min(self._least, variance)
        speed = self._approach.step(Remaining(
            self._left, self._pace(view.estimate), sqrt(max(0.0, variance - self._least)),
            view.dt, view.measured))
        if speed is None:
            return None
        velocity = self._velocity(speed)
        if self._approach.correcting:  # too short a way to steer
            return velocity
        return velocity._replace(
            angular=velocity.angular + self._steering(velocity.linear, view.estimate))

    def seconds(self) -> float:
        """Return how long what is left takes at most, about."""
        return self._approach.seconds(self._left)

    @property
    def wants_reading(self) -> bool:
        """Whether the robot stands, and only a reading can tell where."""
        return self._approach.wants_reading

    @property
    def distance(self) -> float:
        """Metres that are left, signed."""
        return 0.0

    @property
    def angle(self) -> float:
        """Radians that are left, signed."""
        return 0.0

    @abstractmethod
    def _went(self, estimate: Estimate) -> float:
        """Return by how much less is left since the last estimate."""

    @abstractmethod
    def _variance(self, estimate: Estimate) -> float:
        """Return how sure the odometry is of the way, m²."""

    @abstractmethod
    def _pace(self, estimate: Estimate) -> float:
        """Return how fast the robot moves along the leg."""

    @abstractmethod
    def _velocity(self, speed: float) -> Velocity:
        """Return the velocity for a speed along the leg."""

    def _steering(self, linear: float, estimate: Estimate) -> float:
        """Return the rad/s that bring the robot back to the leg, at m/s."""
        return 0.0


class Straight(Leg):
    """A straight line, forwards or backwards."""

    def __init__(
        self, estimate: Estimate, distance: float, heading: float, top: float,
        learned: Learned, limits: MotionLimits,
    ) -> None:
        """Drive a distance, m, along a heading, rad; negative: backwards."""
        super().__init__(estimate, distance, Approach(
            min(top, limits.max_wheel_speed), STRAIGHT_TOLERANCE, learned,
            limits.linear_acceleration))
        self.forward = distance > 0
        self._heading = heading
        self._off = remainder(estimate.yaw - heading, tau)
        self._aside = 0.0

    @property
    def distance(self) -> float:
        """Metres that are left, signed."""
        return self._left

    def _went(self, estimate: Estimate) -> float:
        dx, dy = estimate.x - self._last.x, estimate.y - self._last.y
        c, s = cos(self._heading), sin(self._heading)
        self._off = remainder(estimate.yaw - self._heading, tau)
        self._aside += dy * c - dx * s
        return dx * c + dy * s

    def _variance(self, estimate: Estimate) -> float:
        xx, xy, _, _, yy, *_ = estimate.pose_covariance
        c, s = cos(self._heading), sin(self._heading)
        return c * c * xx + 2 * c * s * xy + s * s * yy

    def _pace(self, estimate: Estimate) -> float:
        return estimate.linear

    def _velocity(self, speed: float) -> Velocity:
        return Velocity(speed, 0.0)

    def _steering(self, linear: float, estimate: Estimate) -> float:
        return steering(linear, self._aside, self._off)


class Turn(Leg):
    """A turn in place."""

    def __init__(self, estimate: Estimate, angle: float, top: float, learned: Learned,
                 limits: MotionLimits) -> None:
        """Turn by an angle, rad, at this many rad/s at most."""
        self._half = limits.wheel_separation / 2
        super().__init__(estimate, angle * self._half, Approach(
            min(top * self._half, limits.max_wheel_speed), TURN_TOLERANCE * self._half, learned,
            limits.angular_acceleration * self._half))

    @property
    def angle(self) -> float:
        """Radians that are left, signed."""
        return self._left / self._half

    def _went(self, estimate: Estimate) -> float:
        return remainder(estimate.yaw - self._last.yaw, tau) * self._half

    def _variance(self, estimate: Estimate) -> float:
        return estimate.pose_covariance[8] * self._half ** 2

    def _pace(self, estimate: Estimate) -> float:
        return estimate.angular * self._half

    def _velocity(self, speed: float) -> Velocity:
        return Velocity(0.0, speed / self._half)


class Arc(Leg):
    """A part of a circle: the heading tells how far it is driven, steering keeps the radius."""

    def __init__(
        self, estimate: Estimate, angle: float, radius: float, direction: int, top: float,
        learned: Learned, limits: MotionLimits,
    ) -> None:
        """
        Turn by an angle, rad, on a circle of a radius, m, at m/s of the robot's centre at most.

        `direction` is 1 for forwards and -1 for backwards.
        """
        half = limits.wheel_separation / 2
        self._reach = radius + half
        caps = [cap * self._reach for cap in (
            limits.linear_acceleration / radius, limits.angular_acceleration) if cap]
        super().__init__(estimate, angle * self._reach, Approach(
            min(top * self._reach / radius, limits.max_wheel_speed),
            TURN_TOLERANCE * self._reach, learned, min(caps, default=0.0)))
        self.forward = direction > 0
        self._radius = radius
        self._side = direction * copysign(1.0, angle)
        """1 where the circle's centre is on the robot's left, -1 on its right."""
        self._centre = (estimate.x - self._side * radius * sin(estimate.yaw),
                        estimate.y + self._side * radius * cos(estimate.yaw))

    @property
    def angle(self) -> float:
        """Radians that are left, signed."""
        return self._left / self._reach

    def _went(self, estimate: Estimate) -> float:
        return remainder(estimate.yaw - self._last.yaw, tau) * self._reach

    def _variance(self, estimate: Estimate) -> float:
        return estimate.pose_covariance[8] * self._reach ** 2

    def _pace(self, estimate: Estimate) -> float:
        return estimate.angular * self._reach

    def _velocity(self, speed: float) -> Velocity:
        angular = speed / self._reach
        return Velocity(angular * self._side * self._radius, angular)

    def _steering(self, linear: float, estimate: Estimate) -> float:
        x, y = estimate.x - self._centre[0], estimate.y - self._centre[1]
        tangent = atan2(y, x) + self._side * pi / 2
        aside = self._side * (self._radius - hypot(x, y))
        off = remainder(estimate.yaw - tangent, tau)
        return steering(linear, aside, off)


def steering(speed: float, aside: float, off: float) -> float:
    """
    Return the rad/s that bring a robot back to its line while it drives at a speed, m/s.

    It is `aside` metres left of the line, and `off` radians left of the line's direction.
    """
    if speed == 0.0:
        return 0.0
    wanted = max(-STEEPEST, min(STEEPEST, -copysign(ASIDE_GAIN, speed) * aside))
    most = min(SHARPEST, MOST_BEND * abs(speed))
    return max(-most, min(most, HEADING_GAIN * (wanted - off)))
