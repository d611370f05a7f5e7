# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The arithmetic of calibration: measured motion against the motion that the odometry reported.

Pure functions in SI units. They compute the node's parameters `linear_scale`, `angular_scale` and
`wheel_separation`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, pi, sin
from statistics import mean

from ...robot import WHEEL_SEPARATION

PLAUSIBLE = 0.2
"""Largest believable correction; a larger one is more likely a mistake in measuring."""


@dataclass(frozen=True)
class Calibration:
    """Values of the parameters: those used in the drives, or those to set."""

    linear_scale: float = 1.0
    angular_scale: float = 1.0
    wheel_separation: float = WHEEL_SEPARATION


@dataclass(frozen=True)
class Run:
    """One drive: its length or angle as measured and as reported by `odom`, in one unit."""

    measured: float
    reported: float


def line(runs: Sequence[Run], before: Calibration) -> Calibration:
    """Correct the distance by measured straight drives; ValueError: not believable."""
    return replace(before, linear_scale=before.linear_scale * _correction(runs))


def turns(runs: Sequence[Run], before: Calibration) -> Calibration:
    """
    Correct the angle by measured turns in place; ValueError: not believable.

    The angle is the difference of the wheels' distances over their separation. A robot that turns
    further than it reports has wheels that are closer together than assumed.
    """
    correction = _correction(runs)
    return replace(
        before, angular_scale=before.angular_scale * correction,
        wheel_separation=before.wheel_separation / correction)


def _correction(runs: Sequence[Run]) -> float:
    """Return measured over reported motion; longer drives count more."""
    for run in runs:
        if run.measured * run.reported <= 0:
            raise ValueError(
                f'measured {run.measured} and reported {run.reported}: both must be positive, or '
                'both negative')
    correction = sum(abs(run.measured) for run in runs) / sum(abs(run.reported) for run in runs)
    if abs(correction - 1) > PLAUSIBLE:
        raise ValueError(
            f'a correction by {correction:.2f} is not believable (up to {PLAUSIBLE:.0%} is): are '
            'measured and reported in the same unit, with the same sign?')
    return correction


@dataclass(frozen=True)
class EndOffset:
    """End of a square drive, measured less reported, metres, in the frame of its start."""

    x: float
    y: float


@dataclass(frozen=True)
class SquareResult:
    """Result of UMBmark."""

    calibration: Calibration
    wheel_ratio: float
    """Diameter of the right wheel over the left; no parameter of the driver corrects it."""
    worst: float
    """Metres from the start to the mean end of either direction, whichever is larger."""


def square(
    clockwise: Sequence[EndOffset], counter: Sequence[EndOffset], side: float, before: Calibration,
) -> SquareResult:
    """
    Correct the angle by driving a square of `side` metres both ways round (UMBmark).

    Borenstein and Feng, "Measurement and correction of systematic odometry errors in mobile
    robots", 1996: equal errors both ways come from the wheel separation, opposite errors from
    unequal wheels. The robot starts along x and turns by 90 degrees at each corner.
    """
    if side <= 0 or not clockwise or not counter:
        raise ValueError('a square needs a positive side and runs both ways round')
    cw, ccw = _centre(clockwise), _centre(counter)
    alpha = (cw.x + ccw.x) / (-4 * side)
    beta = (cw.x - ccw.x) / (-4 * side)
    share = (pi / 2) / (pi / 2 - alpha)
    if abs(share - 1) > PLAUSIBLE:
        raise ValueError(
            f'the wheels would be {share:.2f} times as far apart: is the side in metres?')
    if abs(beta) > PLAUSIBLE * pi / 2:
        raise ValueError(
            f'the ends of the two directions are {hypot(cw.x - ccw.x, cw.y - ccw.y):.2f} m apart, '
            'too far for unequal wheels: are they in metres?')
    half = before.wheel_separation / 2
    radius = side / 2 / sin(beta / 2) if beta else float('inf')
    ratio = (radius + half) / (radius - half) if beta else 1.0
    return SquareResult(
        replace(before, angular_scale=before.angular_scale / share,
                wheel_separation=before.wheel_separation * share),
        ratio, max((end.x ** 2 + end.y ** 2) ** 0.5 for end in (cw, ccw)))


def _centre(ends: Sequence[EndOffset]) -> EndOffset:
    return EndOffset(mean(end.x for end in ends), mean(end.y for end in ends))
