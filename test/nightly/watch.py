# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks everything that a node publishes for wrong values."""

from math import hypot, remainder, tau
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


class Pose(NamedTuple):
    """A pose and its time: seconds of the system's clock, metres, radians."""

    time: float
    x: float
    y: float
    yaw: float


def jump(before: Pose, after: Pose) -> str:
    """Return a description of a step that no robot can have made; empty if there is none."""
    seconds = after.time - before.time
    if seconds <= 0:
        return f'odom: stamps do not rise ({seconds:.3f} s)'
    way = hypot(after.x - before.x, after.y - before.y)
    turn = abs(remainder(after.yaw - before.yaw, tau))
    if way <= STEP + FASTEST * seconds and turn <= TURN + FASTEST_TURN * seconds:
        return ''
    return f'odom: {way:.3f} m, {turn:.3f} rad within {seconds:.3f} s up to {after.time:.3f}'


class Watch:
    """Subscribes to everything that a node publishes, and collects what is wrong."""

    def __init__(self, ros: Listener) -> None:
        self.wrong: list[str] = []
        self.odoms = 0
        self._ros = ros
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
        if self._last is not None and (wrong := jump(self._last, pose)):
            self.wrong.append(wrong)
        self._last = pose


def _pose(odom: Odometry) -> Pose:
    stamp, at, turned = odom.header.stamp, odom.pose.pose.position, odom.pose.pose.orientation
    return Pose(stamp.sec + stamp.nanosec / 1e9, at.x, at.y, yaw_of(turned))
