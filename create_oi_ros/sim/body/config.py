# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The physical constants of the simulated Create, in one place, each with what it rests on.

`manual` marks what the Open Interface manual says, `reported` what users of real robots measured,
and `guess` what nobody we know of has published: chosen to be plausible, and here to be changed.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import Enum
import math

from ...robot import FIRMWARE_SEPARATION, WHEEL_SEPARATION
from .wheels import MAX_UNSTEADINESS, Response, TimeConstant


class EncoderSign(Enum):
    """How the single-channel encoders decide which way a wheel turned."""

    DRIVE = 'drive'
    """The sign of the speed that the motor was last driven at, kept at rest: a request counts once
    its dead time is over (measured of Create 2 robots, and the default)."""
    UNTIL_REST = 'until_rest'
    """The last command's sign at once; a command of zero keeps it until the wheel rests, then up
    (guess)."""
    COMMAND = 'command'
    """The last command's sign at once, and up for a command of zero, whatever the wheel does."""
    TRUE = 'true'
    """The true sign, as two-channel encoders would have it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyConfig:
    """
    Physical constants of a Create: SI units; `right`/`left` as seen by the robot itself.

    The defaults are what a first-generation Create most likely is (docs/simulator.md).
    """

    wheel_separation: float = 0.262
    """Between the wheels' contact points, metres (measured of one Create: 0.261 to 0.263)."""
    encoder_separation: float = 0.262
    """The separation by which the firmware works out the angle, metres (guess: the true one)."""
    response: Response = Response.FIRST_ORDER
    """How a wheel's speed follows its goal (measured of one Create)."""
    time_constant: TimeConstant = TimeConstant(0.2256, 1.0)
    """Of a first-order wheel, or one over the natural frequency of a second-order one. Times the
    speed it is the way that a wheel coasts: 15 mm, from 0.3 s at 50 mm/s to 0.03 s at 500
    (measured of one Create: 13 mm at 50 and 76 mm/s; reported of others: 15 to 22 mm, 100 to
    500 mm/s)."""
    overshoot: float = 0.2
    """Part of a step by which a second-order wheel goes beyond it (Create 2: 0 to 0.4)."""
    wheel_acceleration: float = 1.0
    """Acceleration of a wheel that ramps, m/s^2 (guess)."""
    braking: float = 1.0
    """How many times as fast a wheel brakes as it speeds up (guess)."""
    dead_time: float = 0.025
    """Seconds until a wheel begins to follow a request (guess that fits the reports of Creates;
    Create 2: 0.03 to 0.06)."""
    dead_band: float = 0.01
    """Slowest speed that moves a wheel, m/s (reported of the 400 series)."""
    encoder_tick: float = 0.00027
    """Metres of travel a count; 0 counts without steps (reported of the 400 series)."""
    encoder_sign: EncoderSign = EncoderSign.DRIVE
    right_speed_gain: float = 1.0
    """Speed that the right wheel settles at, over the speed asked; the encoder sees it."""
    left_speed_gain: float = 1.0
    right_speed_offset: float = 0.0
    """Speed that the right wheel adds to any it is asked, m/s (some Create 2: up to 0.014)."""
    left_speed_offset: float = 0.0
    speed_jitter: float = 0.0
    """Part by which a wheel's mean speed strays from one second to the next, standard deviation
    (Create 2: 0.004 to 0.025, some more when slow; the Create that was filmed: too little to
    see)."""
    speed_wander: float = 0.0
    """The same of a drift within half a minute (Create 2: 0 to 0.05)."""
    right_wheel_scale: float = 1.0
    """True travel of the right wheel over the travel its encoder counts (an unequal wheel)."""
    left_wheel_scale: float = 1.0
    right_slip: float = 0.0
    """Part of the right wheel's travel that is lost to slip at all times, 0 to 1."""
    left_slip: float = 0.0
    gyro: bool = False
    """Whether a gyro is on the analog input."""

    def __post_init__(self) -> None:
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        for name, value in {**values, 'time_constant': self.time_constant.seconds}.items():
            low, high = RANGES.get(name, (-math.inf, math.inf))
            if isinstance(value, float) and not (low <= value <= high and math.isfinite(value)):
                raise ValueError(f'{name} is {value}; allowed: {low:g} to {high:g}')


SMALLEST = 1e-6
"""Stands for above 0."""
RANGES = {
    **dict.fromkeys(('wheel_separation', 'encoder_separation', 'wheel_acceleration', 'braking',
                     'time_constant'), (SMALLEST, math.inf)),
    **dict.fromkeys(('dead_time', 'dead_band', 'encoder_tick'), (0.0, math.inf)),
    **dict.fromkeys(('speed_jitter', 'speed_wander'), (0.0, MAX_UNSTEADINESS)),
    **dict.fromkeys(('right_slip', 'left_slip'), (0.0, 1.0)), 'overshoot': (0.0, 0.99),
}
"""Lowest and highest value of a constant; any finite number where it is not here."""

DEFAULT_BODY = BodyConfig()
"""The default robot: the centre of what was measured and reported."""
IDEAL = BodyConfig(
    wheel_separation=WHEEL_SEPARATION, encoder_separation=FIRMWARE_SEPARATION,
    response=Response.RAMP, dead_time=0.0, dead_band=0.0, encoder_tick=0.0,
    encoder_sign=EncoderSign.UNTIL_REST)
"""Wheels that ramp without delay, for tests whose sums are easy."""
