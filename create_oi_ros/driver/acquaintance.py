# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Reports once when the odometry has become certain of the robot, and what it has learned."""

from ..odometry import Knowledge, Rounding, SignSource
from ..odometry.knowledge import QUICK
from ..robot import MILLI
from .events import EventQueue, Severity

EVERY = 5.0
"""Seconds between two looks."""
FRACTIONS = {Rounding.TRUNCATE: 'cut off', Rounding.ROUND: 'rounded', Rounding.CARRY: 'carried'}
"""What becomes of the fractions of distance and angle."""
SIGNS = {
    SignSource.MOTION: 'the motion', SignSource.DRIVE: 'the drive',
    SignSource.LAST_REQUEST: 'the last request that is not zero',
    SignSource.LATE_REQUEST: 'the request after its dead time',
    SignSource.REQUEST: 'the request'}
"""Where encoders take their signs from."""


class Acquaintance:
    """Watches what the odometry knows."""

    def __init__(self, robot: Knowledge | None, events: EventQueue) -> None:
        """Start with what is known of the robot."""
        self._told = None if robot is None else robot.likeliest
        self._events = events
        self._look_at = 0.0

    def due(self, now: float) -> bool:
        """Tell whether it is time to look again."""
        if now < self._look_at:
            return False
        self._look_at = now + EVERY
        return True

    def look(self, robot: Knowledge | None) -> None:
        """Report a robot that has become known, or that is another than was thought."""
        if robot is None or not robot.certain or robot.likeliest == self._told:
            return
        known = 'the odometry knows this robot now' if self._told is None else (
            'this is another robot than odometry_model says; the odometry has learned')
        self._told = robot.likeliest
        self._events.notice(Severity.INFO, f'{known}: {described(robot)}')


def described(robot: Knowledge) -> str:
    """Say in a line what is known of a robot."""
    rounding, sign = robot.likeliest
    right, left = robot.right_gain.value, robot.left_gain.value
    overshoot = f' and overshoot by {100 * robot.overshoot:.0f} %' if robot.overshoot else ''
    return (f'fractions are {FRACTIONS[rounding]}, encoders take the sign of {SIGNS[sign]}, '
            f'wheels run at {right:.3f} (right) and {left:.3f} (left) of the speed asked, '
            f'{robot.delay(QUICK).value / MILLI:.0f} ms late at {QUICK} m/s{overshoot}; a '
            f'frame lasts {robot.frame_period.value / MILLI:.2f} ms')
