# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The odometry of a check: it learns as ever, but readings are asked for as the moves want."""

from collections.abc import Iterator
from itertools import cycle
from math import cos, remainder, sin, tau

from ...odometry import Estimate, Increment, Odometry

PENDING = 8
"""Frames within which a reading that was asked for arrives, or is asked for again."""


class Notebook(Odometry):
    """Takes the place of the driver's odometry: asks for readings as told, and keeps frames."""

    def __init__(self) -> None:
        super().__init__(window=1.0)
        self.frames: list[Increment] = []
        self.seconds = 0.0
        """The robot's time since the first frame."""
        self.travelled = self.turned = 0.0
        """Metres ahead and radians to the left since the first frame."""
        self._intervals: Iterator[int] = iter(())
        self._every = self._since = 0
        self._due = False

    @property
    def reading_due(self) -> bool:
        """Whether the next frame should carry distance and angle."""
        return self._due

    def ask(self, intervals: tuple[int, ...] = ()) -> None:
        """Ask for a reading, and for others so many frames apart, in turn."""
        self._intervals = cycle(intervals)
        self._every, self._since, self._due = next(self._intervals, 0), 0, True

    def ask_no_more(self) -> None:
        """Ask for no more readings."""
        self._every, self._due = 0, False

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        self.frames.append(increment)
        self.seconds += increment.dt
        self._since += 1
        self._due = bool(self._every) and self._since >= self._every
        if self._due:
            self._every, self._since = next(self._intervals), 0
        before, after = self.estimate, super().update(increment)
        self.travelled += ((after.x - before.x) * cos(before.yaw)
                           + (after.y - before.y) * sin(before.yaw))
        self.turned += remainder(after.yaw - before.yaw, tau)
        return after
