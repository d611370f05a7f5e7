# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Finds what cannot be true: jumps, and an angle that never changes while the robot turns."""

from math import degrees, inf

from .. import oi
from ..robot import MM_PER_M
from .script_speeds import requested_speeds

FASTEST, FASTEST_TURN = 1.0, 450.0
"""m/s and deg/s: twice what the wheels can do, for a robot that is pushed."""
SLACK, TURN_SLACK = 50, 20
"""mm and degrees that are allowed beyond that, for whole units and late frames."""
TURN_LIMIT = 360.0
"""Degrees of requested turning after which the angle should have changed."""
ANGLE_STUCK = (
    'the angle does not change though the robot was told to turn: are the wheels blocked, or does '
    'odometry_window: 0 hide slow turns? Some firmware before 3.4.1 is reported to send a '
    'constant 0')


class JumpCheck:
    """Refuses a distance or an angle that nothing could have made in the time."""

    def __init__(self) -> None:
        self._since: float | None = None

    def restart(self) -> None:
        """Forget when the last reading was: the next spans an unknown time."""
        self._since = None

    def possible(self, readings: oi.Readings, stamp: float, gap: float = 0.0) -> bool:
        """Tell whether a reading can be true that left at `stamp`, or so many seconds later."""
        elapsed = inf if self._since is None else stamp + gap - self._since
        self._since = stamp
        return (abs(readings.distance) <= FASTEST * elapsed * MM_PER_M + SLACK
                and abs(readings.angle) <= FASTEST_TURN * elapsed + TURN_SLACK)


class TurnCheck:
    """Notices an angle that never changes though the robot is told to turn."""

    def __init__(self, wheel_separation: float) -> None:
        """Take the wheel separation in metres."""
        self._separation = wheel_separation
        self._requested = 0.0
        self.stuck = False
        """Whether the angle should have changed long ago."""

    def observe(self, readings: oi.Readings, dt: float, *, drives: bool) -> bool:
        """
        Take a frame in, `dt` seconds after the last; True when it has just become stuck.

        `drives`: whether the robot follows the speeds that are asked of it.
        """
        right, left = requested_speeds(readings)
        if right == left and not self._requested:
            return False  # as in most frames
        if readings.number('angle', 0):
            self._requested, self.stuck = 0.0, False
        elif drives:
            self._requested += degrees((right - left) / MM_PER_M / self._separation) * dt
        before, self.stuck = self.stuck, abs(self._requested) > TURN_LIMIT
        return self.stuck and not before
