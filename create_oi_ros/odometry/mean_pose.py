# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where the robot is on average over all tracks, also between two steps of their wheels.

The copies of the wheels roll some frames at once. In between the mean goes on as it did last: with
its speeds, and with what these changed by.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from .request_history import Array
from .wheel_model import WheelModel

Pose = tuple[float, float, float]
"""x, y, yaw; m and rad."""


class MeanMotion(NamedTuple):
    """How a pose changes in a second, and what that changes by; m and rad."""

    east: float
    north: float
    turn: float
    more: float
    """Of the speed ahead."""
    more_turn: float


class MeanPose:
    """The mean of the tracks' poses, which costs little in most frames."""

    def __init__(self, wheels: WheelModel) -> None:
        self._wheels = wheels
        self._pose: Pose | None = None
        """The mean when the wheels last rolled; None until somebody asks."""
        self._motion: MeanMotion | None = None
        """How it moved then, likewise."""
        self._before: tuple[Array, float] | None = None
        """The wheels' speeds before they rolled, and for how long they did; None: they did not."""

    def begin(self, shares: Array, scales: tuple[float, float]) -> None:
        """Take new copies of the wheels, the tracks' shares, and true over counted travel."""
        self._shares, (linear, angular) = shares, scales
        self._ahead = shares * (linear / 2)
        self._turn = shares * angular / self._wheels.track_width[:, 0]
        """By which sums and differences of the wheels' speeds become those of the mean."""
        self._pose = self._motion = self._before = None

    def roll(self) -> None:
        """Note that the wheels are about to catch up."""
        self._before = self._wheels.speed, self._wheels.behind
        self._pose = self._motion = None

    def now(self) -> Pose:
        """Return the mean pose now."""
        wheels = self._wheels
        if self._pose is None:
            x, y, yaw = (wheels.poses[:, :, 0] @ self._shares).tolist()
            self._pose = x, y, yaw
        if not wheels.behind:
            return self._pose
        if self._motion is None:
            self._motion = self._moves()
        (x, y, yaw), move, middle = self._pose, self._motion, wheels.behind / 2
        half = (move.turn + move.more_turn * middle) * middle
        chord = wheels.behind * (sin(half) / half if half else 1.0)
        c, d, more = chord * cos(half), chord * sin(half), move.more * middle
        east, north = move.east + more * cos(yaw), move.north + more * sin(yaw)
        return x + c * east - d * north, y + c * north + d * east, yaw + 2 * half

    def _moves(self) -> MeanMotion:
        """Return how the mean moves and speeds up."""
        wheels = self._wheels
        speed, yaw = wheels.speed[:, :, 0], wheels.poses[2, :, 0]
        right, left = speed[0], speed[1]
        ahead = (right + left) * self._ahead
        more = more_turn = 0.0
        if self._before is not None and not wheels.settled:
            before, seconds = self._before
            change = (speed - before[:, :, 0]) / seconds
            more = float((change[0] + change[1]) @ self._ahead)
            more_turn = float((change[0] - change[1]) @ self._turn)
        return MeanMotion(float(ahead @ np.cos(yaw)), float(ahead @ np.sin(yaw)),
                          float((right - left) @ self._turn), more, more_turn)
