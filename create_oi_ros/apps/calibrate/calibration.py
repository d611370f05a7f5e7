"""
The arithmetic of calibration: what was measured against what the odometry said.

Pure functions in SI units. What they work out are the node's parameters `linear_scale`,
`angular_scale` and `wheel_separation`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sin
from statistics import mean

PLAUSIBLE = 0.2
"""A correction of more than this share is more likely a slip of the tape, or of the pen."""


@dataclass(frozen=True)
class Calibration:
    """Values of the parameters; those that were in force, or those to set."""

    linear_scale: float = 1.0
    angular_scale: float = 1.0
    wheel_separation: float = 0.258

    def yaml(self) -> str:
        """Return them as a ROS parameter file."""
        return '\n'.join([
            '/**:', '  ros__parameters:',
            *(f'    {name}: {value:.5f}' for name, value in vars(self).items()), ''])


@dataclass(frozen=True)
class Run:
    """One drive: what the tape or the marks said, and what `odom` said, in the same unit."""

    measured: float
    reported: float


def line(runs: Sequence[Run], before: Calibration) -> Calibration:
    """Correct the distance by drives along a measured line; ValueError for absurd figures."""
    return replace(before, linear_scale=before.linear_scale * _correction(runs))


def turns(runs: Sequence[Run], before: Calibration) -> Calibration:
    """
    Correct the angle by measured turns in place; ValueError for absurd figures.

    The robot turns by the difference of its wheels over their separation: where it turns further
    than it reports, its wheels are closer together than was thought.
    """
    correction = _correction(runs)
    return replace(
        before, angular_scale=before.angular_scale * correction,
        wheel_separation=before.wheel_separation / correction)


def _correction(runs: Sequence[Run]) -> float:
    """Return true over reported, longer runs counting more."""
    for run in runs:
        if run.measured * run.reported <= 0:
            raise ValueError(
                f'measured {run.measured} and reported {run.reported}: both must be positive, or '
                'both negative')
    correction = sum(abs(run.measured) for run in runs) / sum(abs(run.reported) for run in runs)
    if abs(correction - 1) > PLAUSIBLE:
        raise ValueError(
            f'a correction by {correction:.2f} is not believable (up to {PLAUSIBLE:.0%} is): are '
            'measured and reported in the same unit, and the same way round?')
    return correction


@dataclass(frozen=True)
class Return:
    """Where a robot ended that was to come back, measured less reported, m, in its first frame."""

    x: float
    y: float


@dataclass(frozen=True)
class Square:
    """What UMBmark finds."""

    calibration: Calibration
    wheel_ratio: float
    """Diameter of the right wheel over that of the left; the driver has no parameter for it."""
    worst: float
    """Metres: the larger distance of the two centres of gravity, the benchmark's own figure."""


def square(
    clockwise: Sequence[Return], counter: Sequence[Return], side: float, before: Calibration,
) -> Square:
    """
    Correct the angle by driving a square of `side` metres both ways round (UMBmark).

    Borenstein and Feng, "Measurement and correction of systematic odometry errors in mobile
    robots", 1996: errors that are alike both ways come from the wheels' separation, errors that
    are opposite from unequal wheels. The robot starts along x and turns by 90 degrees at every
    corner, to the right when clockwise.
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
    half = before.wheel_separation / 2
    radius = side / 2 / sin(beta / 2) if beta else float('inf')
    ratio = (radius + half) / (radius - half) if beta else 1.0
    return Square(
        replace(before, angular_scale=before.angular_scale / share,
                wheel_separation=before.wheel_separation * share),
        ratio, max((end.x ** 2 + end.y ** 2) ** 0.5 for end in (cw, ccw)))


def _centre(ends: Sequence[Return]) -> Return:
    return Return(mean(end.x for end in ends), mean(end.y for end in ends))
