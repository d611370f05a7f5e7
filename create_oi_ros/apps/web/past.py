# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What happened: the track, events on the map, samples for the charts. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import hypot, inf, remainder, tau
from typing import Any, NamedTuple

RECENT = 600.0
"""Seconds for which every point of the track is kept."""
STEP, OLD_STEP = 0.02, 0.2
"""Metres between two points of the track, and between two that are older than RECENT."""
MOST_RECENT, MOST_OLD = 20000, 5000
"""Points; of older ones every second is dropped when there are more."""
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


class TrackPoint(NamedTuple):
    """Where the robot was, and when, seconds."""

    pose: FlatPose
    at: float

    def apart(self, other: TrackPoint) -> float:
        """Return the metres between two points."""
        return hypot(self.pose.x - other.pose.x, self.pose.y - other.pose.y)


class TrackLog:
    """The robot's track: RECENT seconds of it whole, before that with fewer points."""

    def __init__(self) -> None:
        self._recent: deque[TrackPoint] = deque(maxlen=MOST_RECENT)
        self._old: list[TrackPoint] = []
        self._old_step = OLD_STEP
        self._seen: TrackPoint | None = None
        self.count = 0
        """Points that were ever added."""
        self.epoch = 0
        """Grows when the track begins anew, and when a page should drop what became old."""
        self._dropped_at = -inf

    def add(self, pose: FlatPose, at: float) -> bool:
        """Add a pose, if it is STEP from the last one; return if it begins a new track: a jump."""
        jumps = self._seen is not None and not pose.follows(self._seen.pose, at - self._seen.at)
        if jumps:
            self.clear()
        self._seen = point = TrackPoint(pose, at)
        if self._recent and self._recent[-1].apart(point) < STEP:
            return False
        self._recent.append(point)
        self.count += 1
        while self._recent[0].at < at - RECENT:
            self._keep_old(self._recent.popleft())
            if self._dropped_at < at - RECENT:
                self._dropped_at, self.epoch = at, self.epoch + 1
        return jumps

    def _keep_old(self, point: TrackPoint) -> None:
        if self._old and self._old[-1].apart(point) < self._old_step:
            return
        self._old.append(point)
        if len(self._old) > MOST_OLD:
            self._old, self._old_step = self._old[::2], self._old_step * 2

    def clear(self) -> None:
        """Begin anew."""
        self._recent.clear()
        self._old, self._old_step, self._seen = [], OLD_STEP, None
        self.epoch += 1

    def whole(self) -> list[float]:
        """Return all points, as x, y, x, y, ..."""
        return flat([*self._old, *self._recent])

    def since(self, count: int) -> list[float]:
        """Return the points that were added when there were `count` already."""
        new = min(self.count - count, len(self._recent))
        first = len(self._recent) - new
        return flat([self._recent[place] for place in range(first, len(self._recent))])


def flat(points: Sequence[TrackPoint]) -> list[float]:
    """Return points as x, y, x, y, ... in millimetre steps."""
    return [round(each, 3) for point in points for each in point.pose[:2]]
