# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What was received from a robot, and when: seconds of a monotonic clock."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import hypot, inf, isfinite
from typing import Any, NamedTuple

from create_oi_msgs.msg import Bumper, Cliff, Song
from nav_msgs.msg import Odometry

from ...ros.rotation import yaw_of

MOST_POINTS, MOST_MARKS = 2000, 100
STEP = 0.02
"""Metres between two points of a new trail."""
FARTHEST = 1e6
"""Metres from the origin beyond which a position is wrong and is not drawn."""
FASTEST, SLACK = 1.0, 0.3
"""m/s and metres; a faster step means that the robot was moved or the odometry reset."""
LATE = 1.5
"""Seconds beyond its period after which a topic counts as late."""


class OdomPose(NamedTuple):
    """A pose by the odometry: metres and radians."""

    x: float
    y: float
    yaw: float

    @property
    def drawable(self) -> bool:
        """Whether it can be drawn on a map."""
        return all(map(isfinite, self)) and max(abs(self.x), abs(self.y)) <= FARTHEST


class Received(NamedTuple):
    """The newest message of a topic."""

    message: Any
    at: float


class Mark(NamedTuple):
    """A bump or a cliff, at its place on the map."""

    x: float
    y: float
    sign: str


class Trail:
    """All positions of the robot; the longer the trail, the coarser."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float]] = []
        self.marks: list[Mark] = []
        self._step = STEP
        self._at = -inf
        self._last: OdomPose | None = None

    def add(self, pose: OdomPose, at: float) -> None:
        """Add a pose; one that is too far from the last starts a new trail."""
        if not pose.drawable:
            return
        if self._last is not None and hypot(
                pose.x - self._last.x, pose.y - self._last.y) > SLACK + FASTEST * (at - self._at):
            self.clear()
        self._last, self._at = pose, at
        if self.points and hypot(
                pose.x - self.points[-1][0], pose.y - self.points[-1][1]) < self._step:
            return
        self.points.append((pose.x, pose.y))
        if len(self.points) > MOST_POINTS:
            self.points, self._step = self.points[::2], self._step * 2

    def mark(self, sign: str) -> None:
        """Put a mark where the robot is."""
        if self._last is not None:
            self.marks = [*self.marks[1 - MOST_MARKS:], Mark(self._last.x, self._last.y, sign)]

    def clear(self) -> None:
        """Start a new, empty trail."""
        self.points, self.marks, self._step, self._last = [], [], STEP, None


@dataclass
class CallStatus:
    """The last service call: its text for the user."""

    text: str = ''
    highlighted: bool = False
    waiting_since: float | None = None
    """When it was called, while its reply is missing."""


@dataclass
class RobotState:
    """Everything that the picture shows."""

    title: str = ''
    periods: dict[type, tuple[str, float]] = field(default_factory=dict)
    """Topic and period, s, of each message type; inf: published on change only."""
    trail: Trail = field(default_factory=Trail)
    diagnostics: dict[str, Any] = field(default_factory=dict)
    """Each status by its name, without the node's name."""
    call_status: CallStatus = field(default_factory=CallStatus)
    driver_listens: bool = False
    """Whether a driver subscribes to velocity commands."""
    driver_count: int = 0
    """Publishers of `odom`; more than one is a mistake."""
    help_shown: bool = False
    driving: bool = False
    """Whether a key drives the robot now."""
    speeds: tuple[float, float] = (0.0, 0.0)
    """Speeds that the drive keys command, m/s and rad/s."""
    song_played: bool = False
    """Whether a song has played since the view started."""
    _received: dict[type, Received] = field(default_factory=dict)

    def update(self, message: Any, at: float) -> None:
        """Store a message; extend the trail and its marks."""
        before = self.get(type(message))
        self._received[type(message)] = Received(message, at)
        match message:
            case Odometry() if (pose := self.pose) is not None:
                self.trail.add(pose, at)
            case Song() if message.playing:
                self.song_played = True
            case Bumper() if touched(message) and not touched(before):
                self.trail.mark('x')
            case Cliff() if touched(message) and not touched(before):
                self.trail.mark('!')

    def get(self, type_: type) -> Any:
        """Return the newest message of a type, or None."""
        newest = self._received.get(type_)
        return None if newest is None else newest.message

    def age(self, type_: type, now: float) -> float:
        """Return the seconds since the newest message of a type; inf: none yet."""
        newest = self._received.get(type_)
        return inf if newest is None else now - newest.at

    @property
    def pose(self) -> OdomPose | None:
        """The newest pose by the odometry."""
        odom = self.get(Odometry)
        if odom is None:
            return None
        pose = odom.pose.pose
        return OdomPose(pose.position.x, pose.position.y, yaw_of(pose.orientation))

    @property
    def nothing_received(self) -> bool:
        """Whether no message at all has arrived yet."""
        return not self._received

    def late_topics(self, now: float) -> dict[str, float]:
        """Return the age, s, of each topic whose next message is overdue."""
        ages = {name: (self.age(type_, now), period)
                for type_, (name, period) in self.periods.items()}
        return {name: age for name, (age, period) in ages.items()
                if period + LATE < age < inf}

    def silence(self, now: float) -> float:
        """Return the seconds since the newest message of the driver."""
        return min((self.age(type_, now) for type_ in self.periods), default=inf)


def touched(message: Any) -> bool:
    """Return whether any boolean of a message is true."""
    return message is not None and any(
        getattr(message, name) is True for name in message.get_fields_and_field_types())
