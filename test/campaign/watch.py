"""Compares all that is published with what it must be."""

from collections import deque
from collections.abc import Callable
from math import atan2, cos, hypot, remainder, sin, tau
import time
from typing import Any, NamedTuple

from create_oi_msgs.msg import Mode
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from create_oi_ros.ros.topics import LATCHED, SENSOR_TOPICS
from support.ros import Listener

STEP, TURN = 0.05, 0.15
"""Metres and radians that odometry may differ after a gap."""
FASTEST, FASTEST_TURN = 0.6, 5.0
"""m/s and rad/s that it may show without one."""
GAP = 0.2
"""Seconds between two messages from which on frames were missed."""
LOOK_EVERY = 0.02
"""Seconds between two looks at the robot's own place."""
PROMPT = 0.01
"""Seconds within which it must be told to be worth knowing."""
PLACES = 500
"""How many places of the robot are remembered: more than the longest gap has."""


class Place(NamedTuple):
    """Where something was: seconds of the system's clock, metres, radians."""

    time: float
    x: float
    y: float
    yaw: float


class Step(NamedTuple):
    """What lies between two places, as seen from the first: metres, radians."""

    forward: float
    left: float
    turn: float


STOOD = Step(0.0, 0.0, 0.0)


def step(before: Place, after: Place) -> Step:
    """Return how one comes from one place to another."""
    x, y = after.x - before.x, after.y - before.y
    return Step(x * cos(before.yaw) + y * sin(before.yaw),
                y * cos(before.yaw) - x * sin(before.yaw),
                remainder(after.yaw - before.yaw, tau))


class Way:
    """Where the robot really was, as its simulator tells it."""

    def __init__(
        self, truth: Callable[[], dict[str, Any]], clock: Callable[[], float] = time.time,
    ) -> None:
        self._truth, self._clock = truth, clock
        self._places: deque[Place] = deque(maxlen=PLACES)

    def look(self) -> None:
        """See where the robot is; an answer that took long says nothing of when."""
        asked = self._clock()
        truth = self._truth()
        answered = self._clock()
        if answered - asked < PROMPT:
            self._places.append(
                Place((asked + answered) / 2, truth['x'], truth['y'], truth['yaw']))

    def between(self, begin: float, end: float) -> Step | None:
        """Return how the robot went from one past time to another, if it was seen around both."""
        self.look()
        before, after = self._at(begin), self._at(end)
        return None if before is None or after is None else step(before, after)

    def _at(self, moment: float) -> Place | None:
        later = None
        for place in reversed(self._places):
            if place.time <= moment:
                return None if later is None else _mean(place, later, moment)
            later = place
        return None


def _mean(before: Place, after: Place, moment: float) -> Place:
    share = (moment - before.time) / (after.time - before.time)
    return Place(moment, before.x + share * (after.x - before.x),
                 before.y + share * (after.y - before.y),
                 before.yaw + share * remainder(after.yaw - before.yaw, tau))


def jump(before: Place, after: Place, way: Way | None = None) -> str:
    """
    Say by how much the odometry has jumped, or ''.

    After a gap it must be where it was, or have gone as the robot did in truth, as far as that
    is known: one that drives on while frames are lost is somewhere else after them.
    """
    seconds = after.time - before.time
    if seconds <= 0:
        return f'odom: stamps do not rise ({seconds:.3f} s)'
    said = step(before, after)
    moving = seconds if seconds < GAP else 0.0
    if _near(said, STOOD, STEP + FASTEST * moving, TURN + FASTEST_TURN * moving):
        return ''
    went = None if way is None else way.between(before.time, after.time)
    if went is not None and _near(said, went, STEP, TURN):
        return ''
    return (f'odom: {_words(said)} within {seconds:.3f} s up to {after.time:.3f}; the robot: '
            f'{"not known" if went is None else _words(went)}')


def _near(one: Step, other: Step, metres: float, radians: float) -> bool:
    return (hypot(one.forward - other.forward, one.left - other.left) <= metres
            and abs(remainder(one.turn - other.turn, tau)) <= radians)


def _words(moved: Step) -> str:
    return f'{moved.forward:.3f} m ahead, {moved.left:.3f} m left, {moved.turn:.3f} rad'


class Watch:
    """Hears what a node publishes, and keeps what is wrong."""

    def __init__(self, ros: Listener) -> None:
        self.wrong: list[str] = []
        self.odoms = 0
        self._ros = ros
        self._way: Way | None = None
        self._since = 0.0
        """When the present node was started: what one before it has said may come late."""
        self.newest = 0.0
        """The newest stamp of an `odom`, in seconds of the system's clock."""
        self._last: Place | None = None
        self._first: dict[str, str] = {}
        for topic in SENSOR_TOPICS:
            if topic.name != 'song':
                ros.node.create_subscription(
                    topic.type, topic.name,
                    lambda message, name=topic.name: self._on_sensor(name, message), topic.qos)
        ros.node.create_subscription(Odometry, 'odom', self._on_odom, 200)
        self._modes = ros.listen(Mode, 'mode', LATCHED)

    @property
    def mode(self) -> int | None:
        """The mode that was published last."""
        return self._modes[-1].mode if self._modes else None

    def restart(self) -> None:
        """Begin anew with another node: its odometry begins at the origin."""
        self._last = None
        self._since = time.time()
        self._modes.clear()

    def follow(self, truth: Callable[[], dict[str, Any]]) -> None:
        """See from now on where a robot really is."""
        self._way = Way(truth)
        self._ros.node.create_timer(LOOK_EVERY, self._way.look)

    def _on_sensor(self, name: str, message: Any) -> None:
        message.header = Header()
        said = str(message)
        if said != self._first.setdefault(name, said):
            self.wrong.append(f'{name}: {said}')

    def _on_odom(self, odom: Odometry) -> None:
        place = _place(odom)
        if place.time < self._since:
            return
        self.odoms += 1
        self.newest = place.time
        if self._last is not None and (wrong := jump(self._last, place, self._way)):
            self.wrong.append(wrong)
        self._last = place


def _place(odom: Odometry) -> Place:
    stamp, at, turned = odom.header.stamp, odom.pose.pose.position, odom.pose.pose.orientation
    return Place(stamp.sec + stamp.nanosec / 1e9, at.x, at.y, 2 * atan2(turned.z, turned.w))
