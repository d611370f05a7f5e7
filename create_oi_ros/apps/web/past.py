# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What happened: the track, events on the map, samples for the charts. Pure."""

from __future__ import annotations

from collections import deque
from math import hypot, remainder, tau
from typing import Any, NamedTuple

STEP = 0.02
"""Metres between two points of the track, at first."""
MOST_POINTS = 20_000
MOST_EVENTS, MOST_LOGGED = 500, 200
CHART_SECONDS, SAMPLE_PERIOD = 60.0, 0.2
"""Seconds that the charts show, and between two of their samples."""

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


class NewestLog:
    """The newest entries of a log, with running numbers: readers ask for all since theirs."""

    def __init__(self, most: int) -> None:
        """Keep this many entries."""
        self._kept: deque[Any] = deque(maxlen=most)
        self.count = 0
        """Entries that were ever added."""

    def add(self, entry: Any) -> None:
        """Add an entry; the oldest one may be dropped."""
        self._kept.append(entry)
        self.count += 1

    def since(self, count: int) -> list[Any]:
        """Return the entries that were added when there were `count` already."""
        new = min(self.count - count, len(self._kept))
        return [self._kept[place] for place in range(len(self._kept) - new, len(self._kept))]

    def clear(self) -> None:
        """Drop all entries; their numbers are not used again."""
        self._kept.clear()


class TrackLog:
    """
    The robot's track: a point for each STEP.

    When there are MOST_POINTS, every second one is dropped, and from then on they are twice as far
    apart.
    """

    def __init__(self) -> None:
        self._points: list[FlatPose] = []
        self._step = STEP
        self.epoch = 0
        """Grows when the track begins anew, or has lost points."""

    def __len__(self) -> int:
        return len(self._points)

    def add(self, pose: FlatPose) -> None:
        """Add a pose, if it is a step from the last one."""
        last = self._points[-1] if self._points else None
        if last is not None and hypot(pose.x - last.x, pose.y - last.y) < self._step:
            return
        self._points.append(pose)
        if len(self._points) > MOST_POINTS:
            del self._points[1::2]
            self._step *= 2
            self.epoch += 1

    def clear(self) -> None:
        """Begin anew."""
        self._points, self._step = [], STEP
        self.epoch += 1

    def since(self, count: int) -> list[float]:
        """Return the points after so many, as x, y, x, y, ... in millimetre steps."""
        return [round(each, 3) for pose in self._points[count:] for each in pose[:2]]
