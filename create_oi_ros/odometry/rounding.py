# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a whole number says about the quantity behind it.

A Create reports whole millimetres and degrees. Such a number stands for an interval; which one
depends on the rounding. Of a normal distribution that is cut to an interval a part is left, which
is described here by its mass, mean and variance (docs/odometry.md, "An integer is an interval").
"""

from math import erf, erfc, exp, inf, sqrt, tau

from ..robot import Rounding

ROOT_HALF = sqrt(0.5)
ROOT_TAU = sqrt(tau)
FAR_TAIL = 6.0
"""Standard deviations from which the tail is treated as an exponential."""


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


def cut_normal(low: float, high: float) -> tuple[float, float, float]:
    """Return mean, variance and mass of the standard normal's part between low and high."""
    mirrored = low > -high
    if mirrored:
        # The moments are wanted from the tail that is computed without cancellation.
        low, high = -high, -low
    if high < -FAR_TAIL:
        mean, variance, mass = _cut_tail(low, high)
    else:
        mass = (erfc(-high * ROOT_HALF) - erfc(-low * ROOT_HALF) if high < 0 else
                erf(high * ROOT_HALF) - erf(low * ROOT_HALF)) / 2
        width = high - low
        if width < 1e-3:
            # So narrow a piece is flat.
            mean, variance = (low + high) / 2, width * width / 12
        else:
            at_low, at_high = _density(low), _density(high)
            mean = (at_low - at_high) / mass
            variance = 1 + (low * at_low - high * at_high) / mass - mean * mean
            variance = min(1.0, max(variance, 1e-9))
    return -mean if mirrored else mean, variance, mass


def _density(z: float) -> float:
    return exp(-z * z / 2) / ROOT_TAU


def _cut_tail(low: float, high: float) -> tuple[float, float, float]:
    """Return the same far below zero, where the density falls like exp(-rate (high - z))."""
    rate, width = -high, high - low
    fall = exp(-rate * width)
    if rate * width < 1e-3:
        return (low + high) / 2, width * width / 12, _density(high) * width
    mean = high - 1 / rate + width * fall / (1 - fall)
    variance = 1 / rate ** 2 - width * width * fall / (1 - fall) ** 2
    return mean, max(variance, 1e-12), _density(high) / rate * (1 - fall)
