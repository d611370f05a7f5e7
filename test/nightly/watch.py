# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks everything that a node publishes for wrong values."""

from collections import deque
from collections.abc import Callable
from math import cos, hypot, remainder, sin, tau
import time
from typing import Any, NamedTuple

from create_oi_msgs.msg import Mode
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from create_oi_ros.ros.messages import yaw_of
from create_oi_ros.ros.topics import LATCHED, SENSOR_TOPICS
from support.ros import Listener

STEP, TURN = 0.05, 0.15
"""Tolerance of a step of the odometry, metres and radians."""
FASTEST, FASTEST_TURN = 0.6, 5.0
"""Highest speed that the odometry may show, m/s and rad/s."""
GAP = 0.2
"""Seconds between two messages above which frames must have been lost."""
LOOK_EVERY = 0.02
"""Seconds between two queries of the robot's true pose."""
PROMPT = 0.01
"""Longest duration of a query, seconds; a slower answer has no exact time and is dropped."""
POSES = 500
"""Number of true poses that are kept: they last longer than the longest gap."""


class Pose(NamedTuple):
    """A pose and its time: seconds of the system's clock, metres, radians."""

    time: float
    x: float
    y: float
    yaw: float


class Step(NamedTuple):
    """The movement between two poses in the frame of the first: metres, radians."""

    forward: float
    left: float
    turn: float


NO_STEP = Step(0.0, 0.0, 0.0)


def step(before: Pose, after: Pose) -> Step:
    """Return the step from one pose to another."""
    x, y = after.x - before.x, after.y - before.y
    return Step(x * cos(before.yaw) + y * sin(before.yaw),
                y * cos(before.yaw) - x * sin(before.yaw),
                remainder(after.yaw - before.yaw, tau))


class TruePath:
    """The true poses of the robot, from its simulator."""

    def __init__(
        self, truth: Callable[[], dict[str, Any]], clock: Callable[[], float] = time.time,
    ) -> None:
        self._truth, self._clock = truth, clock
        self._poses: deque[Pose] = deque(maxlen=POSES)

    def look(self) -> None:
        """Query the true pose and keep it, unless the answer took too long."""
        asked = self._clock()
        truth = self._truth()
        answered = self._clock()
        if answered - asked < PROMPT:
            self._poses.append(
                Pose((asked + answered) / 2, truth['x'], truth['y'], truth['yaw']))

    def between(self, begin: float, end: float) -> Step | None:
        """Return the true step between two times; None if a pose around one of them is missing."""
        self.look()
        before, after = self._at(begin), self._at(end)
        return None if before is None or after is None else step(before, after)

    def _at(self, moment: float) -> Pose | None:
        later = None
        for pose in reversed(self._poses):
            if pose.time <= moment:
                return None if later is None else _mean(pose, later, moment)
            later = pose
        return None


def _mean(before: Pose, after: Pose, moment: float) -> Pose:
    share = (moment - before.time) / (after.time - before.time)
    return Pose(moment, before.x + share * (after.x - before.x),
                 before.y + share * (after.y - before.y),
                 before.yaw + share * remainder(after.yaw - before.yaw, tau))


def jump(before: Pose, after: Pose, path: TruePath | None = None) -> str:
    """
    Return a description of a jump of the odometry; empty if there is none.

    Between two messages the odometry may move as fast as a robot can. After a gap, when frames
    were lost, it must be where it was before, or must have moved as the robot truly did: a robot
    can drive on during the gap.
    """
    seconds = after.time - before.time
    if seconds <= 0:
        return f'odom: stamps do not rise ({seconds:.3f} s)'
    shown = step(before, after)
    moving = seconds if seconds < GAP else 0.0
    if _near(shown, NO_STEP, STEP + FASTEST * moving, TURN + FASTEST_TURN * moving):
        return ''
    moved = None if path is None else path.between(before.time, after.time)
    if moved is not None and _near(shown, moved, STEP, TURN):
        return ''
    return (f'odom: {_words(shown)} within {seconds:.3f} s up to {after.time:.3f}; the robot: '
            f'{"not known" if moved is None else _words(moved)}')


def _near(one: Step, other: Step, metres: float, radians: float) -> bool:
    return (hypot(one.forward - other.forward, one.left - other.left) <= metres
            and abs(remainder(one.turn - other.turn, tau)) <= radians)


def _words(moved: Step) -> str:
    return f'{moved.forward:.3f} m ahead, {moved.left:.3f} m left, {moved.turn:.3f} rad'


class Watch:
    """Subscribes to everything that a node publishes, and collects what is wrong."""

    def __init__(self, ros: Listener) -> None:
        self.wrong: list[str] = []
        self.odoms = 0
        self._ros = ros
        self._path: TruePath | None = None
        self._since = 0.0
        """Start of the present node: older messages are late ones of the node before it."""
        self.newest = 0.0
        """The newest stamp of an `odom`, seconds of the system's clock."""
        self._last: Pose | None = None
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
        """Expect another node, whose odometry begins at the origin."""
        self._last = None
        self._since = time.time()
        self._modes.clear()

    def follow(self, truth: Callable[[], dict[str, Any]]) -> None:
        """Query the true pose of a robot from now on."""
        self._path = TruePath(truth)
        self._ros.node.create_timer(LOOK_EVERY, self._path.look)

    def _on_sensor(self, name: str, message: Any) -> None:
        message.header = Header()
        text = str(message)
        if text != self._first.setdefault(name, text):
            self.wrong.append(f'{name}: {text}')

    def _on_odom(self, odom: Odometry) -> None:
        pose = _pose(odom)
        if pose.time < self._since:
            return
        self.odoms += 1
        self.newest = pose.time
        if self._last is not None and (wrong := jump(self._last, pose, self._path)):
            self.wrong.append(wrong)
        self._last = pose


def _pose(odom: Odometry) -> Pose:
    stamp, at, turned = odom.header.stamp, odom.pose.pose.position, odom.pose.pose.orientation
    return Pose(stamp.sec + stamp.nanosec / 1e9, at.x, at.y, yaw_of(turned))
