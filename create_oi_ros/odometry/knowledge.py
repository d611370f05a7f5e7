# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What was learned of a robot, apart from where it is: what is saved, and where it starts from."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import log, pi
from typing import NamedTuple

from ..robot import Rounding, SLOT
from .hypotheses import Hypothesis, REFERENCE_SPEED, Response, SignSource

CERTAIN, FINE, PROMPT = 0.99, 0.01, 0.03
"""When a robot counts as known: least probability of its rounding and of its source of signs;
largest standard deviation of a gain, and of a wheel's delay, s."""
QUICK = 0.2
"""m/s of a quick drive, at which that delay is looked at."""
TAUGHT = 40
"""Readings since the start from which on what was learned is told and saved by itself: the first
may be sure of what the next ones refute."""


class Known(NamedTuple):
    """A number, and the standard deviation of what is believed of it."""

    value: float
    deviation: float


PERIOD = Known(SLOT, 3e-4)
"""Length of a slot of a robot that nobody knows, s: 15 and 15.625 ms were seen."""


class KnownGyro(NamedTuple):
    """An analog gyro."""

    zero: Known
    """Volts at rest."""
    drift: Known
    """By how much the zero changes, V/s."""
    scale: Known
    """Degrees a second for each volt; negative where the voltage grows clockwise."""


@dataclass(frozen=True, kw_only=True)
class Knowledge:
    """A robot as the odometry knows it; SI units."""

    hypotheses: Mapping[Hypothesis, float]
    """Ways in which its wheels may work, and their probabilities."""
    rounding: Mapping[Rounding, float]
    """Probability of each."""
    right_gain: Known
    """Speed of the right wheel over the speed asked."""
    left_gain: Known
    angle_factor: Known
    """Angle that the robot reports over what wheels 258 mm apart turn."""
    frame_period: Known = PERIOD
    """Seconds between two frames."""
    readings: int = 0
    """Readings of distance and angle in motion from which this was learned."""
    gyro: KnownGyro | None = None
    """None: there is none, or nobody has seen it follow the robot."""

    @property
    def wheels(self) -> Hypothesis:
        """The likeliest hypothesis."""
        return max(self.hypotheses, key=self.hypotheses.__getitem__)

    @property
    def encoder_sign(self) -> Mapping[SignSource, float]:
        """Probability of each source of the encoders' signs."""
        return {sign: sum(p for row, p in self.hypotheses.items() if row.sign is sign)
                for sign in SignSource}

    @property
    def likeliest(self) -> tuple[Rounding, SignSource]:
        """The rounding and the source of signs that are believed in most."""
        signs = self.encoder_sign
        return (max(self.rounding, key=self.rounding.__getitem__),
                max(signs, key=signs.__getitem__))

    @property
    def certain(self) -> bool:
        """Whether the robot is known as well as a minute of mixed driving can teach."""
        rounding, sign = self.likeliest
        return (self.rounding[rounding] > CERTAIN and self.encoder_sign[sign] > CERTAIN
                and max(self.right_gain.deviation, self.left_gain.deviation) < FINE
                and self.delay(QUICK).deviation < PROMPT)

    def delay(self, speed: float) -> Known:
        """Return by how many seconds a wheel is late that starts to run at a speed, m/s."""
        delays = {row: delay_of(row, speed) for row in self.hypotheses}
        mean = sum(p * delays[row] for row, p in self.hypotheses.items())
        variance = sum(p * (delays[row] - mean) ** 2 for row, p in self.hypotheses.items())
        return Known(mean, variance ** 0.5)


def delay_of(row: Hypothesis, speed: float) -> float:
    """Return by how many seconds wheels are late that start to run at a speed, m/s."""
    time: float = row.time * (REFERENCE_SPEED / speed) ** row.of_speed
    match row.response:
        case Response.LAG:
            late = time
        case Response.RAMP:
            late = speed * time / 2
        case Response.SPRING:
            decay = -log(max(row.overshoot, 1e-3))
            late = 2 * time * decay / (decay ** 2 + pi ** 2) ** 0.5
    return row.dead_time + late

