# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_calibrate listen`: distance and angle since the start, as `odom` reports them."""

from math import degrees, pi
import sys

from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.task import Future

from ...ros.messages import yaw_of
from ...ros.process import call_on_signal, ros_executor, spin_until

PERIOD = 0.5
"""Seconds between two lines."""


class Tally:
    """Adds up distance and angle; the angle may exceed a full turn."""

    def __init__(self) -> None:
        self.distance = 0.0
        """Metres, forward less backward."""
        self.turned = 0.0
        """Radians, counter-clockwise."""
        self._before: tuple[float, float, float] | None = None

    def add(self, x: float, y: float, yaw: float, *, forward: bool) -> None:
        """Add the motion since the last pose."""
        if self._before is not None:
            x0, y0, yaw0 = self._before
            step = ((x - x0) ** 2 + (y - y0) ** 2) ** 0.5
            self.distance += step if forward else -step
            self.turned += (yaw - yaw0 + pi) % (2 * pi) - pi
        self._before = (x, y, yaw)


class _Listener(Node):
    """Prints the tally twice a second: in place on a terminal, else a line each."""

    def __init__(self, tally: Tally) -> None:
        super().__init__('create_calibrate')
        self._tally = tally
        self.heard = False
        """Whether any odometry has come."""
        self._fresh = False
        self._begin, self._end = ('\r\033[K', '') if sys.stdout.isatty() else ('', '\n')
        self.create_subscription(Odometry, 'odom', self._on_odom, 100)
        self.create_timer(PERIOD, self.show)

    def _on_odom(self, odom: Odometry) -> None:
        pose = odom.pose.pose
        self.heard = self._fresh = True
        self._tally.add(
            pose.position.x, pose.position.y, yaw_of(pose.orientation),
            forward=odom.twist.twist.linear.x >= 0)

    def show(self) -> None:
        """Print the tally, or that no odometry comes."""
        text = (f'reported: {self._tally.distance:+8.3f} m  {degrees(self._tally.turned):+9.1f} '
                'degrees')
        if not self._fresh:
            topic = self.resolve_topic_name('odom')
            text = f'{text}; {topic} has ended' if self.heard else f'nothing on {topic} yet'
        self._fresh = False
        print(f'{self._begin}{text}   (Ctrl-C ends)', end=self._end, flush=True)


def listen(arguments: list[str]) -> int:
    """Print the tally until Ctrl-C; 1: no odometry came."""
    ended = Future()
    call_on_signal(lambda: ended.set_result(0))
    with ros_executor(arguments) as executor:
        listener = _Listener(Tally())
        executor.add_node(listener)
        spin_until(executor, ended)
        heard, topic = listener.heard, listener.resolve_topic_name('odom')
    if sys.stdout.isatty():
        print()
    if not heard:
        print(f'create_calibrate: nothing came on {topic}: does a driver run in this ROS domain '
              'and namespace?', file=sys.stderr)
    return 0 if heard else 1
