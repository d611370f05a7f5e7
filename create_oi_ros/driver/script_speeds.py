# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Wheel speeds during a script, from the requested speeds that the robot reports.

The last Drive is reported in packets 39 and 40, the last Drive Direct in 41 and 42, and nothing
tells which of them came last. So a script is followed if it uses only one of them.
"""

from .. import oi
from ..oi.script import commands_of
from ..oi.steering import wheel_speeds
from ..robot import MM_PER_M, TOP_SPEED
from .stream_plan import DRIVE_REQUEST

CLEARED = oi.Drive(velocity=0, radius=oi.Radius.STRAIGHT)
"""Sent before a script plays: packets 39 and 40 may still hold an earlier Drive."""

Speeds = tuple[float, float]
"""Of the right and the left wheel, m/s."""
requested_speeds = oi.Readings.numbers('requested_right_velocity', 'requested_left_velocity')
"""What the last Drive Direct asked for, as the robot reports it in every frame, mm/s."""


class ScriptSpeeds:
    """Reads the wheel speeds from the packets that report them for one script."""

    def __init__(
        self, script: oi.Script | None, wheel_separation: float, *, cleared: bool,
    ) -> None:
        """Follow this script, if it is known; the separation is in metres."""
        commands = commands_of(script) if script else []
        used: set[type[oi.Command]] = {type(command) for command in commands}
        self._separation = wheel_separation * MM_PER_M
        self._drive = oi.Drive in used
        mixed = self._drive and oi.DriveDirect in used
        self.known = cleared and script is not None and not mixed and oi.Script not in used
        """Whether the packets tell how fast the wheels turn."""
        self.resets_accumulators = self.known and not used.isdisjoint(
            (oi.WaitDistance, oi.WaitAngle))
        """Whether the script sets distance and angle to zero as it waits for them (manual), so
        that a part of the motion is missing from them. False where the packets do not tell the
        speeds either: then that part is all that is known."""

    def speeds(self, readings: oi.Readings) -> Speeds | None:
        """Return how fast the wheels are to run by a frame's packets; None if not known."""
        if not self._drive:
            return requested_directly(readings)
        if not readings.has(*DRIVE_REQUEST):
            return 0.0, 0.0
        if readings.requested_velocity is None:
            return None
        right, left = wheel_speeds(
            readings.requested_velocity, readings.requested_radius, self._separation)
        return _limited(right), _limited(left)


def requested_directly(readings: oi.Readings) -> Speeds | None:
    """Return what the last Drive Direct asked for; None if not known."""
    right, left = requested_speeds(readings)
    return None if None in (right, left) else (right / MM_PER_M, left / MM_PER_M)


def _limited(speed: float) -> float:
    """Convert a requested wheel speed from mm/s to m/s, limited to what the wheel can do."""
    return max(-TOP_SPEED, min(TOP_SPEED, speed / MM_PER_M))
