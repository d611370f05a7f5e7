"""What has been heard of a robot, and when; moments are seconds of one rising clock."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import hypot, inf, isfinite
from typing import Any, NamedTuple

from create_oi_msgs.msg import Bumper, Cliff
from nav_msgs.msg import Odometry

from ...ros.rotation import yaw_of

MOST_POINTS, MOST_MARKS = 2000, 100
STEP = 0.02
"""Metres between two points of a new track."""
FARTHEST = 1e6
"""Metres from the origin beyond which a place is a mistake and is not drawn."""
FASTEST, SLACK = 1.0, 0.3
"""m/s and metres: a robot that is farther off than this was put elsewhere, or counts anew."""
LATE = 1.5
"""Seconds beyond its period after which a topic is missed."""


class Pose(NamedTuple):
    """Metres and radians."""

    x: float
    y: float
    yaw: float

    @property
    def drawable(self) -> bool:
        """Whether it is a place on any map."""
        return all(map(isfinite, self)) and max(abs(self.x), abs(self.y)) <= FARTHEST


class Heard(NamedTuple):
    """The newest message of a topic."""

    message: Any
    at: float


class Mark(NamedTuple):
    """Something that happened at a place."""

    x: float
    y: float
    sign: str


class Track:
    """Where the robot was: the whole way, the coarser the longer it is."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float]] = []
        self.marks: list[Mark] = []
        self._step = STEP
        self._at = -inf
        self._last: Pose | None = None

    def add(self, pose: Pose, at: float) -> None:
        """Take a pose in; one that cannot be reached from the last begins the track again."""
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
        """Note that something happens where the robot is."""
        if self._last is not None:
            self.marks = [*self.marks[1 - MOST_MARKS:], Mark(self._last.x, self._last.y, sign)]

    def clear(self) -> None:
        """Forget the way."""
        self.points, self.marks, self._step, self._last = [], [], STEP, None


@dataclass
class Note:
    """What the line for messages says."""

    text: str = ''
    loud: bool = False
    waiting_since: float | None = None
    """When a service was called that has not answered yet."""


@dataclass
class State:
    """All that the picture shows."""

    title: str = ''
    periods: dict[type, tuple[str, float]] = field(default_factory=dict)
    """For each type of message its topic, and seconds between two; inf: only on change."""
    track: Track = field(default_factory=Track)
    diagnostics: dict[str, Any] = field(default_factory=dict)
    """Each status by its name, without the node's."""
    note: Note = field(default_factory=Note)
    listened: bool = False
    """Whether somebody wants velocity commands."""
    drivers: int = 0
    """How many publish the odometry."""
    helping: bool = False
    driving: bool = False
    """Whether a key drives."""
    speeds: tuple[float, float] = (0.0, 0.0)
    """m/s and rad/s of the keys that drive."""
    _heard: dict[type, Heard] = field(default_factory=dict)

    def take(self, message: Any, at: float) -> None:
        """Take a message in."""
        before = self.get(type(message))
        self._heard[type(message)] = Heard(message, at)
        match message:
            case Odometry() if (pose := self.pose) is not None:
                self.track.add(pose, at)
            case Bumper() if touched(message) and not touched(before):
                self.track.mark('x')
            case Cliff() if touched(message) and not touched(before):
                self.track.mark('!')

    def get(self, type_: type) -> Any:
        """Return the newest message of a type, or None."""
        heard = self._heard.get(type_)
        return None if heard is None else heard.message

    def age(self, type_: type, now: float) -> float:
        """Return the seconds since the newest message of a type; inf: never one."""
        heard = self._heard.get(type_)
        return inf if heard is None else now - heard.at

    @property
    def pose(self) -> Pose | None:
        """Where the odometry says that the robot is."""
        odom = self.get(Odometry)
        if odom is None:
            return None
        pose = odom.pose.pose
        return Pose(pose.position.x, pose.position.y, yaw_of(pose.orientation))

    @property
    def silent(self) -> bool:
        """Whether nothing at all was heard yet."""
        return not self._heard

    def missed(self, now: float) -> dict[str, float]:
        """Return topics that were heard and should have been again, with the seconds since."""
        ages = {name: (self.age(type_, now), period)
                for type_, (name, period) in self.periods.items()}
        return {name: age for name, (age, period) in ages.items()
                if period + LATE < age < inf}

    def quiet_for(self, now: float) -> float:
        """Return the seconds since anything was heard of the driver."""
        return min((self.age(type_, now) for type_ in self.periods), default=inf)


def touched(message: Any) -> bool:
    """Tell whether any flag of a message is set."""
    return message is not None and any(
        getattr(message, name) is True for name in message.get_fields_and_field_types())
