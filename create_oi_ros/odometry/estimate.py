# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What goes into odometry, what comes out of it, and what it knows of a robot; SI units."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from math import log, nan, radians
from typing import NamedTuple

import numpy as np

from ..robot import Rounding, SLOT, WHEEL_RADIUS, WHEEL_SEPARATION
from .wheels import Array, late


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
    """Requested speed of the right wheel, m/s (packet 41); 0 where wheels do not obey it."""
    left: float
    """Requested speed of the left wheel, m/s (packet 42), likewise."""
    distance: int | None = None
    """Millimetres since it was last asked for (packet 19); None when not asked."""
    angle: int | None = None
    """Degrees since it was last asked for (packet 20); None when not asked."""
    lifted: bool = False
    """Whether a drive wheel hangs down: wheels may turn then, but nothing moves."""
    lost: bool = False
    """Whether a reading before this frame, or in it, may have been lost."""
    analog: float = nan
    """Volts at the analog input (packet 33); NaN: not known."""
    bumped: bool = False
    """Whether the bumper is pressed."""
    by_itself: bool = False
    """Whether the robot itself moves its wheels: in a demo, or while it docks."""


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
    trip: tuple[float, float] = (0.0, 0.0)
    """Metres ahead and radians to the left, all in all; from `Odometry.start_trip` on without
    corrections of what was before. Not smoothed."""
    trip_variance: tuple[float, float] = (0.0, 0.0)
    """Theirs since then, m² and rad²."""


class SignSource(Enum):
    """Where an encoder takes its sign from; it has one channel, and no direction of its own."""

    DRIVE = 'drive'
    """The last request that was not zero, once it has taken effect."""
    LAST_REQUEST = 'last_request'
    """The last request that was not zero, at once."""
    REQUEST = 'request'
    """The request; a wheel told to stop counts forwards."""
    MOTION = 'motion'
    """The motion itself."""


class Known(NamedTuple):
    """A number, and the standard deviation of what is believed of it."""

    value: float
    deviation: float


PERIOD = Known(SLOT, 3e-4)
"""Length of a slot of a robot that nobody knows, s (evidence: 15 and 15.625 ms were seen)."""


class KnownGyro(NamedTuple):
    """An analog gyro."""

    zero: Known
    """Volts at rest."""
    scale: Known
    """Degrees a second for each volt; negative where the voltage grows clockwise."""


class GyroSettings(NamedTuple):
    """An analog gyro, by its data sheet; the defaults are those of an ADXRS613."""

    scale: float = radians(80.0)
    """rad/s for each volt; negative where the voltage grows clockwise."""
    range: float = radians(150.0)
    """rad/s at which its output ends."""


CERTAIN, FINE, PROMPT = 0.97, 0.01, 0.03
"""When a robot counts as known: least probability of its rounding and of its source of signs (two
that differ only for a dead time count as one);
largest deviation of a gain, and of a wheel's delay at 0.2 m/s, s (what a minute teaches)."""
QUICK = 0.2
"""m/s at which that delay is looked at."""
TAUGHT = 40
"""Readings in motion from which on what was learned is saved by itself: the first may be sure of
what the next ones refute."""


@dataclass(frozen=True, kw_only=True)
class Knowledge:
    """A robot as the odometry knows it; SI units."""

    rounding: Mapping[Rounding, float]
    """Probability of each."""
    encoder_sign: Mapping[SignSource, float]
    right_gain: Known
    """Speed of the right wheel over the speed asked."""
    left_gain: Known
    angle_factor: Known
    """Angle that the robot reports over what wheels 258 mm apart turn."""
    lag: Known
    """T, seconds."""
    lag_power: Known
    """p, between 0 and 1."""
    acceleration: Known
    """a, m/s²."""
    braking: Known
    """b, a ratio."""
    dead_time: Known
    """d, seconds."""
    frame_period: Known = PERIOD
    """Seconds between two frames."""
    readings: int = 0
    """Readings of distance and angle in motion from which this was learned."""
    gyro: KnownGyro | None = None
    """None: there is none, or nobody has seen it follow the robot."""

    @property
    def likeliest(self) -> tuple[Rounding, SignSource]:
        """The rounding and the source of signs that are believed in most."""
        return (max(self.rounding, key=self.rounding.__getitem__),
                max(self.encoder_sign, key=self.encoder_sign.__getitem__))

    @property
    def certain(self) -> bool:
        """Whether the robot is known as well as a minute of mixed driving can teach."""
        signs = dict(self.encoder_sign)
        signs[SignSource.DRIVE] += signs.pop(SignSource.LAST_REQUEST)
        return (min(max(self.rounding.values()), max(signs.values())) > CERTAIN
                and max(self.right_gain.deviation, self.left_gain.deviation) < FINE
                and self.delay(QUICK).deviation < PROMPT)

    @property
    def numbers(self) -> tuple[Array, Array]:
        """The wheel model's five numbers, ln T, p, ln a, ln b and d, and their deviations."""
        (t, dt), (p, dp), (a, da), (b, db), (d, dd) = (
            self.lag, self.lag_power, self.acceleration, self.braking, self.dead_time)
        return (np.array([log(t), p, log(a), log(b), d]),
                np.array([dt / t, dp, da / a, db / b, dd]))

    def delay(self, speed: float) -> Known:
        """Return by how many seconds a wheel is late that starts to run at a speed, m/s."""
        numbers, deviations = self.numbers
        usual = late(numbers, speed)
        steps = [late(numbers + step, speed) - usual for step in np.diag(deviations)]
        return Known(usual, sum(step * step for step in steps) ** 0.5)
