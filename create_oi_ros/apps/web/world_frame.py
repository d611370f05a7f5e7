# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the frame of a simulated room lies in the frame of the odometry. Pure."""

from __future__ import annotations

from math import cos, hypot, remainder, sin, tau
from typing import NamedTuple

SLACK, FASTEST = 0.1, 1.0
"""Metres and m/s; a longer step means that the odometry was reset."""
TURN_SLACK, FASTEST_TURN = 0.3, 5.0
"""The same for the heading: radians and rad/s."""


class FlatPose(NamedTuple):
    """A pose on the floor: metres and radians."""

    x: float
    y: float
    yaw: float

    def follows(self, last: FlatPose, seconds: float) -> bool:
        """Return whether a robot can come here from its last pose in this time."""
        moved = hypot(self.x - last.x, self.y - last.y)
        turned = abs(remainder(self.yaw - last.yaw, tau))
        return moved <= SLACK + FASTEST * seconds and turned <= TURN_SLACK + FASTEST_TURN * seconds


class WorldFrame:
    """
    The room's frame as a pose in the odometry's frame.

    It is set when both poses are first known, and again after the odometry was reset. From then
    on the true place drifts away from that of the odometry, and this difference is its error.
    """

    def __init__(self) -> None:
        self.origin: FlatPose | None = None
        self._last, self._at = FlatPose(0.0, 0.0, 0.0), 0.0

    def update(self, odometry: FlatPose, true: FlatPose, now: float) -> bool:
        """Take both poses of one moment; return whether the frame was set."""
        continues = self.origin is not None and odometry.follows(self._last, now - self._at)
        self._last, self._at = odometry, now
        if continues:
            return False
        yaw = odometry.yaw - true.yaw
        self.origin = FlatPose(
            odometry.x - true.x * cos(yaw) + true.y * sin(yaw),
            odometry.y - true.x * sin(yaw) - true.y * cos(yaw), yaw)
        return True

    def reset(self) -> None:
        """Forget the frame: the odometry was reset."""
        self.origin = None
