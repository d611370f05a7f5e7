# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a whole number says about the quantity behind it.

A Create reports whole millimetres and degrees. Such a number stands for an interval; which one
depends on the rounding. Of a normal distribution that is cut to an interval a part is left, which
is described here by its mass, mean and variance (docs/odometry.md, "An integer is an interval").
"""

from math import erfc, inf, sqrt, tau

import numpy as np

from ..robot import Rounding
from .request_history import Array

ROOT_HALF = sqrt(0.5)
ROOT_TAU = sqrt(tau)
ERFC = np.frompyfunc(erfc, 1, 1)
FARTHEST = 30.0
"""Standard deviations beyond which the tail is taken for the one that begins there: farther out,
densities are too small for a float."""
FLAT = 1e-3
"""Standard deviations: so narrow a piece is flat."""
LEAST_VARIANCE = 1e-9
"""What is left at least, for differences of floats may be below zero."""


def interval(rounding: Rounding, whole: int) -> tuple[float, float]:
    """Return the ends of what the accumulator may have held when it reported `whole`."""
    if rounding is Rounding.ROUND:
        return whole - 0.5, whole + 0.5
    return (float(whole) if whole > 0 else whole - 1.0,
            float(whole) if whole < 0 else whole + 1.0)


def telling_in(rounding: Rounding, amount: float, rate: float, room: float) -> float:
    """
    Return in how many seconds an amount comes near to where another whole number begins.

    It grows by `rate` in a second; `room`: how near. 0: it is; infinity: it never does.
    """
    whole = abs(amount)
    ends = interval(rounding, round(whole) if rounding is Rounding.ROUND else int(whole))
    if amount < 0:
        ends = -ends[1], -ends[0]
    if min(abs(end - amount) for end in ends) < room:
        return 0.0
    return (abs(ends[rate > 0] - amount) - room) / abs(rate) if rate else inf


def cut_normal(low: Array, high: Array) -> tuple[Array, Array, Array]:
    """Return means, variances and masses of the standard normal's parts between low and high."""
    ends = np.array([low, high])
    mirrored = low > -high
    # The moments are wanted from the tail that is computed without cancellation.
    ends = np.where(mirrored, -ends[::-1], ends)
    beyond = np.minimum(ends[1] + FARTHEST, 0.0)
    ends -= beyond
    below = np.asarray(ERFC(ends * -ROOT_HALF), float) / 2
    mass = below[1] - below[0]
    density = np.exp(-ends * ends / 2) / (ROOT_TAU * mass)
    at_low, at_high = ends * density
    mean = density[0] - density[1]
    variance = np.clip(1 + at_low - at_high - mean * mean, LEAST_VARIANCE, 1.0)
    width = ends[1] - ends[0]
    flat = width < FLAT
    mean = np.where(flat, (ends[0] + ends[1]) / 2, mean) + beyond
    variance = np.where(flat, width * width / 12, variance)
    return np.where(mirrored, -mean, mean), variance, mass
