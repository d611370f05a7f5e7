# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A gyro on the cargo bay's analog input: an ADXRS613, as TurtleBot 1 had one.

Each robot (seed) has another one: a zero and a scale within the tolerances of the part, and a zero
that drifts.
"""

import math
from random import Random

VOLTS, STEPS = 5.0, 1023
"""Range of the analog input, and its highest value (manual: Cargo Bay Analog Signal)."""
SENSITIVITY, TOLERANCE = 0.0125, 0.05
"""Volts for each degree a second, counter-clockwise, and the part by which it may be off."""
RANGE = 150.0
"""Degrees a second, beyond which its output stays where it is."""
ZERO, ZERO_SPREAD = 512, 20
"""Value at rest, and by how much it may be off."""
DRIFT = 0.02 / 60
"""Degrees a second by which the zero changes in a second."""
NOISE = 1.0
"""Standard deviation of a value."""


class Gyro:
    """Turns a yaw rate into a value of packet 33."""

    def __init__(self, seed: int) -> None:
        self._random = Random(f'gyro {seed}')
        steps = STEPS / VOLTS * SENSITIVITY
        self._scale = steps * (1 + self._random.uniform(-TOLERANCE, TOLERANCE))
        self._zero = ZERO + self._random.uniform(-ZERO_SPREAD, ZERO_SPREAD)
        self._drift = steps * DRIFT * self._random.choice((1, -1))

    def read(self, rate: float, time: float) -> int:
        """Return the value at a yaw rate, rad/s, so many seconds after the start."""
        turning = max(-RANGE, min(RANGE, math.degrees(rate)))
        value = (self._zero + self._drift * time + self._scale * turning
                 + self._random.gauss(0.0, NOISE))
        return round(max(0.0, min(float(STEPS), value)))
