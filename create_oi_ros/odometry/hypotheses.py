# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The hypotheses: ways in which wheels may follow requests, and how likely each is at first."""

from enum import Enum, IntEnum
from math import exp, log, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

DEGREE, MM = pi / 180, 1e-3
"""Units of packets 20 and 19, rad and m."""


class Response(IntEnum):
    """How a wheel's speed follows a step of its request."""

    LAG = 0
    """First order; `time` is its time constant, s."""
    SPRING = 1
    """Second order; `time` is 1/natural frequency, s."""
    RAMP = 2
    """Constant acceleration; `time` is its inverse, s²/m."""


class SignSource(Enum):
    """Where an encoder, which has one channel, takes the sign of its counts from."""

    MOTION = 'motion'
    """The wheel's own motion."""
    DRIVE = 'drive'
    """The last request that was not zero, once its dead time is over."""
    LAST_REQUEST = 'last_request'
    """The last request that was not zero, at once."""
    REQUEST = 'request'
    """The request at once; zero counts as forwards."""


class Hypothesis(NamedTuple):
    """One way in which both wheels may work; SI units."""

    response: Response
    time: float
    """At `REFERENCE_SPEED`."""
    of_speed: float
    """Power of 1/v with which this time goes: 0, the same at all speeds; 1, wheels coast as far
    at any speed."""
    overshoot: float
    """Of a spring, as a part of the step."""
    braking: float
    """How many times as fast a wheel slows down as it speeds up."""
    dead_time: float
    """Seconds until a request takes effect."""
    dead_band: float
    """m/s; a slower request does not move the wheel."""
    sign: SignSource = SignSource.DRIVE


REFERENCE_SPEED = 0.1
"""m/s."""
SIGNS = tuple(SignSource)
DEAD_BANDS = 0.0035, 0.0095, 0.0165, 0.0245, 0.045
"""m/s; between the whole mm/s that can be requested."""


class Start(NamedTuple):
    """What is thought of a hypothesis before any reading."""

    log: float
    """Logarithm of how likely it is."""
    unsure: float
    """Part of `SPREAD` by which its numbers are unsure."""


STARTS = {Hypothesis(response, time, power, 0.2, 1.0, 0.045, band): start
          for response, time, power, start in (
              (Response.LAG, 0.15, 1.0, Start(0.5, 0.3)),
              (Response.LAG, 0.06, 0.4, Start(-0.7, 0.8)),
              (Response.LAG, 0.17, 0.4, Start(-0.7, 0.8)),
              (Response.SPRING, 0.035, 0.4, Start(-1.0, 1.0)),
              (Response.RAMP, 0.6, 0.0, Start(-1.7, 0.8)),
              (Response.RAMP, 1.8, 0.0, Start(-1.7, 0.8)))
          for band in DEAD_BANDS}
"""Hypotheses of a robot that nobody knows: the first Create coasted as far at any speed."""
NUMBERS = 5
"""How many numbers of a hypothesis are estimated: ln(time), power, ln(braking), dead time,
overshoot."""
SPREAD = np.array([0.6, 0.4, 0.5, 0.05, 0.12])
"""Their standard deviations at first."""
LOWEST = np.array([log(0.01), 0.0, log(0.25), 0.0, 0.02])
HIGHEST = np.array([log(4.0), 1.0, log(4.0), 0.2, 0.6])


def numbers_of(row: Hypothesis) -> list[float]:
    """Return what is estimated of a hypothesis, as the filters have it."""
    return [log(row.time), row.of_speed, log(row.braking), row.dead_time, row.overshoot]


def with_numbers(row: Hypothesis, numbers: list[float], sign: SignSource) -> Hypothesis:
    """Return a hypothesis with other numbers."""
    time, power, braking, dead_time, overshoot = numbers
    return row._replace(time=exp(time), of_speed=power, braking=exp(braking), dead_time=dead_time,
                        overshoot=overshoot, sign=sign)
