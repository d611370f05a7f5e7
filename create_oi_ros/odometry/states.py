# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The states of a track, in this order, with what is believed of them before the first reading.

First the unknowns of which the wheels' motion depends on, each of which gets a copy of the wheels
that is off by one standard deviation (`wheel_model`); then the pose and the accumulators.
"""

from math import inf, radians
from typing import NamedTuple

from ..robot import MILLI

MM, DEGREE = MILLI, radians(1)
"""The units of a reading, m and rad."""
(GAIN_RIGHT, GAIN_LEFT, OFFSET_RIGHT, OFFSET_LEFT, LAG, SLOW_LAG, FAST_LAG, DEAD_TIME, RAMP,
 BRAKING, SEPARATION, MOVES_RIGHT, MOVES_LEFT, SPEED_RIGHT, SPEED_LEFT, X, Y, YAW, DISTANCE,
 ANGLE) = range(20)
SIZE = 20
DAMPING = RAMP
"""Of a spring, in the place of the acceleration's bound, which a spring does not have."""
UNKNOWNS = 15
"""The states that have a copy of the wheels."""
GOALS = slice(GAIN_RIGHT, OFFSET_LEFT + 1)
"""Those on which depends at which speed a wheel settles."""
POSE = (X, Y, YAW)
MOVES = (MOVES_RIGHT, MOVES_LEFT)
SPEEDS = (SPEED_RIGHT, SPEED_LEFT)


class Prior(NamedTuple):
    """Mean and standard deviation at the start, and the range that it never leaves."""

    mean: float
    spread: float
    low: float
    high: float
    drift: float = 0.0
    """Standard deviation of its random walk, per root second of motion."""


NOTHING = Prior(0.0, 0.0, -inf, inf)
"""Of a state that is no property of the robot, such as its pose."""
COMMON = {
    GAIN_RIGHT: Prior(1.0, 0.035, 0.6, 1.5, 2e-5),
    GAIN_LEFT: Prior(1.0, 0.035, 0.6, 1.5, 2e-5),
    OFFSET_RIGHT: Prior(0.0, 0.004, -0.02, 0.03),
    OFFSET_LEFT: Prior(0.0, 0.004, -0.02, 0.03),
    DEAD_TIME: Prior(0.06, 0.045, 0.0, 0.25),
    BRAKING: Prior(0.0, 0.5, -1.3, 1.3),
    SEPARATION: Prior(0.0, 0.04, -0.15, 0.15),
    MOVES_RIGHT: Prior(1.0, 0.0, -0.2, 1.2),
    MOVES_LEFT: Prior(1.0, 0.0, -0.2, 1.2),
}
SPRING = {
    LAG: Prior(0.07, 0.05, 0.004, 0.6), SLOW_LAG: Prior(0.25, 0.25, -0.1, 0.8),
    FAST_LAG: Prior(0.2, 0.3, -0.1, 0.95), DAMPING: Prior(0.5, 0.15, 0.15, 0.95),
    DEAD_TIME: Prior(0.08, 0.05, 0.0, 0.25)}
"""Wheels that overshoot."""
SPRINGS = SPRING, SPRING | {BRAKING: Prior(-0.8, 0.35, -1.3, 1.3)}
"""The same, braking as they start or softly: those are too far apart for one to become the other
before springs are given up."""
LAGS = (
    {LAG: Prior(0.12, 0.08, 0.004, 0.6), SLOW_LAG: Prior(0.25, 0.25, -0.1, 0.8),
     FAST_LAG: Prior(0.2, 0.3, -0.1, 0.95), RAMP: Prior(0.1, 0.2, 0.0, 4.0)},
    {LAG: Prior(0.02, 0.02, 0.004, 0.6), SLOW_LAG: Prior(0.0, 0.3, -0.1, 0.8),
     FAST_LAG: Prior(0.0, 0.3, -0.1, 0.95), RAMP: Prior(0.7, 0.5, 0.0, 4.0)},
    {LAG: Prior(0.02, 0.02, 0.004, 0.6), SLOW_LAG: Prior(0.0, 0.3, -0.1, 0.8),
     FAST_LAG: Prior(0.0, 0.3, -0.1, 0.95), RAMP: Prior(2.0, 0.8, 0.0, 4.0)},
)
"""Lags that decay and constant accelerations (as 1 / a, s²/m), which can become each other."""
RESPONSES = LAGS + SPRINGS
"""All that a track may begin with."""
PRIORS = tuple((COMMON | LAGS[0]).get(index, NOTHING) for index in range(SIZE))
"""Of all states, of wheels that are no springs."""
