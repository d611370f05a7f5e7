# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What goes into odometry, and what comes out of it; SI units."""

from dataclasses import dataclass
from typing import NamedTuple

from ..robot import WHEEL_RADIUS, WHEEL_SEPARATION


@dataclass(frozen=True, slots=True)
class Geometry:
    """The robot's dimensions and the corrections that calibration found."""

    wheel_separation: float = WHEEL_SEPARATION
    """Metres between the wheels' contact points."""
    wheel_radius: float = WHEEL_RADIUS
    """Metres; only the wheels' joint angles depend on it."""
    linear_scale: float = 1.0
    """True distance over the distance that the robot reports."""
    angular_scale: float = 1.0
    """True angle over the angle that the robot reports."""
    slip: float = 5e-5
    """Metres by which a wheel strays from what its encoder counts, per root metre of travel.
    Nothing on the robot can measure it; it only widens the covariance. A hard floor has little;
    a carpet may need 0.002."""


class Increment(NamedTuple):
    """What one frame says about motion since the frame before."""

    dt: float
    """Seconds since the frame before, by the robot's clock."""
    right: float
    """Requested speed of the right wheel, m/s (packet 41)."""
    left: float
    """Requested speed of the left wheel, m/s (packet 42)."""
    driven: bool
    """Whether the wheels obey these requests: not in a demo, nor after a safety stop."""
    distance: int | None = None
    """Millimetres since it was last asked for (packet 19); None when not asked."""
    angle: int | None = None
    """Degrees since it was last asked for (packet 20); None when not asked."""
    lifted: bool = False
    """Whether a drive wheel hangs down: wheels may turn then, but nothing moves."""
    lost: bool = False
    """Whether a frame before this one, or a reading in this one, may have been lost."""
    analog: float | None = None
    """Volts at the analog input (packet 33); None: not known, or no gyro is there."""
    bumped: bool = False
    """Whether the bumper is pressed."""


class Estimate(NamedTuple):
    """Pose in the odometry frame, twist in the base frame, wheels, and how sure that is."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    linear: float = 0.0
    """m/s, forward."""
    angular: float = 0.0
    """rad/s, counter-clockwise."""
    pose_covariance: tuple[float, ...] = (1e-9, 0.0, 0.0, 0.0, 1e-9, 0.0, 0.0, 0.0, 1e-9)
    """Row-major over x, y, yaw; m², m rad, rad²."""
    twist_covariance: tuple[float, float] = (1e-6, 1e-6)
    """Variances of linear and angular velocity."""
    right_wheel: float = 0.0
    """Angle of the right wheel, rad."""
    right_wheel_speed: float = 0.0
    """rad/s."""
    left_wheel: float = 0.0
    """rad."""
    left_wheel_speed: float = 0.0
    """rad/s."""
    gyro: tuple[float, float] | None = None
    """Turn rate by the gyro, rad/s, and its variance; None: it does not tell."""
