# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the odometry has learned of the robot, in words, and a notice once it is certain of it.

The log, `/diagnostics` and `create_check` all say it in these words.
"""

from ..odometry import Hypothesis, Knowledge, Known, Response, Rounding, SignSource
from ..odometry.hypotheses import REFERENCE_SPEED
from ..odometry.knowledge import delay_of, QUICK
from ..robot import FIRMWARE_SEPARATION, MILLI
from .core import Core
from .events import Severity
from .tracking import Tracking

INTERVAL = 5.0
"""Seconds between two checks."""
FRACTIONS = {
    Rounding.TRUNCATE: 'cut off and lost at each reading',
    Rounding.ROUND: 'rounded, and the rest is lost',
    Rounding.CARRY: 'kept for the next reading'}
SIGNS = {
    SignSource.DRIVE: 'of the drive: the last request that was not zero, after its dead time',
    SignSource.LAST_REQUEST: 'of the last request that was not zero, at once',
    SignSource.REQUEST: 'of the request; a wheel told to stop counts forwards',
    SignSource.MOTION: 'of the motion itself'}


class LearnedRobot:
    """Reports a robot once the odometry is certain of it."""

    def __init__(self, core: Core, tracking: Tracking) -> None:
        robot = core.settings.robot
        self._core = core
        self._tracking = tracking
        self._reported = None if robot is None else robot.likeliest
        self._check_at = 0.0

    def observe(self, now: float) -> None:
        """Report a robot that has become known, or that is another than was thought."""
        if now < self._check_at:
            return
        self._check_at = now + INTERVAL
        robot, before = self._tracking.robot, self._reported
        if robot is None or not robot.certain or robot.likeliest == before:
            return
        self._reported = robot.likeliest
        known = 'the odometry knows this robot now' if before is None else (
            'this is another robot than odometry_model says; the odometry has learned')
        said = '; '.join(f'{what}: {answer}' for what, answer in in_words(robot).items())
        self._core.notice(Severity.INFO, f'{known}: {said}')


def in_words(robot: Knowledge) -> dict[str, str]:
    """Say what the odometry believes of a robot, and how sure it is."""
    rounding, sign = robot.likeliest
    wheels, width = robot.wheels, FIRMWARE_SEPARATION / robot.angle_factor.value / MILLI
    responds = sum(p for each, p in robot.hypotheses.items() if each.response is wheels.response)
    late = robot.delay(QUICK)
    return {
        'fractions of distance and angle': FRACTIONS[rounding] + _sure(robot.rounding[rounding]),
        'sign of an encoder': SIGNS[sign] + _sure(robot.encoder_sign[sign]),
        'response': _response(wheels) + _sure(responds),
        'late': f'{late.value / MILLI:.0f} +- {late.deviation / MILLI:.0f} ms at {QUICK} m/s',
        'dead time': f'about {wheels.dead_time / MILLI:.0f} ms',
        'wheels over request': f'right {_ratio(robot.right_gain)}, left '
                               f'{_ratio(robot.left_gain)}',
        'slowest speed that moves it': f'about {wheels.dead_band / MILLI:.0f} mm/s',
        'wheel separation of the firmware': f'{width:.1f} mm',
        'frame period': f'{robot.frame_period.value / MILLI:.3f} ms'}


def _response(wheels: Hypothesis) -> str:
    """Say how a wheel follows a step of its request."""
    match wheels.response:
        case Response.LAG:
            slow, fast = (speed / MILLI * (delay_of(wheels, speed) - wheels.dead_time)
                          for speed in (REFERENCE_SPEED, QUICK))
            kind = (f'first order, coasts {slow:.0f} mm from {REFERENCE_SPEED} m/s, {fast:.0f} mm '
                    f'from {QUICK} m/s')
        case Response.SPRING:
            kind = f'second order, overshoots by {100 * wheels.overshoot:.0f} %'
        case _:  # a ramp
            kind = f'a constant acceleration of {1 / wheels.time:.2f} m/s2'
    return kind if abs(wheels.braking - 1) < 0.05 else (
        f'{kind}, brakes {wheels.braking:.1f} times as fast as it speeds up')


def _ratio(known: Known) -> str:
    return f'{known.value:.3f} +- {known.deviation:.3f}'


def _sure(probability: float) -> str:
    return f' ({"over 99.9 %" if probability > 0.999 else f"{probability:.1%}"} sure)'
