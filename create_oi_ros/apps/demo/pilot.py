# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Drives a robot by its topics and services, and waits for what it reports."""

from __future__ import annotations

from collections.abc import Callable
from math import remainder, tau
import time
from typing import Any

from create_oi_msgs.msg import Bumper, Mode, Song
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Pose, PoseStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from rclpy.action.client import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from ...driver import MotionLimits
from ...ros.actions import ACTIONS
from ...ros.messages import yaw_of
from ...ros.topics import CMD_VEL, LATCHED

PERIOD = 0.05
"""Seconds between two commands."""
CRUISE, SPIRAL_TURN = 0.3, 1.6
"""Highest speeds of a spiral, m/s and rad/s."""
BRAKING = min(2.5, MotionLimits.angular_acceleration / SPIRAL_TURN)
"""Turning speed, rad/s, for each radian left to turn: braking stays within the driver's limits."""
SLOWEST = 0.2
"""Turning speed at least, rad/s."""
GOAL_TIMEOUT = 60.0
"""Seconds in which any goal ends: the driver's own time limits are shorter."""
STANDING = 0.01
"""m/s; a slower robot stands."""


class TourError(Exception):
    """Something that the tour waits for did not happen; the message says what."""


class Stopped(Exception):
    """A signal has ended the tour."""


class Pilot:
    """Drives the robot; each method returns when its motion is complete."""

    def __init__(
        self, node: Node, executor: SingleThreadedExecutor, check: Callable[[], None],
    ) -> None:
        """`check` is called while waiting, and may raise to end the tour."""
        self._node, self._executor, self._check = node, executor, check
        self._velocity = node.create_publisher(Twist, CMD_VEL, 1)
        self._commanded: Twist | None = None
        self._next = 0.0
        self.sent = 0
        """Commands published."""
        self.odom: Odometry | None = None
        self.mode, self.bumped, self.song = Mode(mode=Mode.UNKNOWN), False, Song()
        self.warnings: list[str] = []
        self.turned = 0.0
        """Angle turned since the start, rad; may exceed a full turn."""
        node.create_subscription(Odometry, 'odom', self._on_odom, 10)
        node.create_subscription(Bumper, 'bumper', self._on_bumper, 10)
        node.create_subscription(Mode, 'mode', self._on_mode, LATCHED)
        node.create_subscription(Song, 'song', self._on_song, LATCHED)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def _on_odom(self, odom: Odometry) -> None:
        before = self.yaw
        self.odom = odom
        self.turned += remainder(self.yaw - before, tau)

    def _on_bumper(self, bumper: Bumper) -> None:
        self.bumped = bool(bumper.left or bumper.right)

    def _on_mode(self, mode: Mode) -> None:
        self.mode = mode

    def _on_song(self, song: Song) -> None:
        self.song = song

    def _on_diagnostics(self, diagnostics: DiagnosticArray) -> None:
        self.warnings = [status.message for status in diagnostics.status
                         if status.level != DiagnosticStatus.OK]

    @property
    def place(self) -> tuple[float, float]:
        """Position by the odometry, metres."""
        if self.odom is None:
            return 0.0, 0.0
        return self.odom.pose.pose.position.x, self.odom.pose.pose.position.y

    @property
    def yaw(self) -> float:
        """Heading by the odometry, rad."""
        if self.odom is None:
            return 0.0
        return yaw_of(self.odom.pose.pose.orientation)

    @property
    def standing(self) -> bool:
        """Whether the robot stands still."""
        twist = self.odom.twist.twist if self.odom else Twist()
        return bool(abs(twist.linear.x) < STANDING and abs(twist.angular.z) < 5 * STANDING)

    def until(
        self, happened: Callable[[], Any], what: str, seconds: float = 10.0,
        steer: Callable[[], None] = lambda: None,
    ) -> None:
        """Wait for a condition, steering meanwhile; TourError: it did not come in time."""
        deadline = time.monotonic() + seconds
        while not happened():
            self._check()
            if time.monotonic() > deadline:
                self.release()
                raise TourError(f'{what} did not happen within {seconds:.0f} s')
            self._executor.spin_once(timeout_sec=PERIOD / 2)
            if time.monotonic() >= self._next:
                self._next = time.monotonic() + PERIOD
                steer()
                if self._commanded is not None:
                    self._publish(self._commanded)

    def command(self, speed: float, turn: float) -> None:
        """Set the velocity to send from now on, m/s and rad/s."""
        self._commanded = Twist(linear=Vector3(x=speed), angular=Vector3(z=turn))

    def release(self) -> None:
        """Send a zero velocity, then no more commands."""
        self._publish(Twist())
        self._commanded = None

    def _publish(self, command: Twist) -> None:
        self.sent += 1
        self._velocity.publish(command)

    def stop(self) -> None:
        """Stop, and wait until the robot stands."""
        self.command(0.0, 0.0)
        self.until(lambda: self.standing, 'the robot stands', 3.0)

    def call(self, type_: type, name: str, **fields: Any) -> str:
        """Call a service and return its message; TourError: it was refused."""
        client = self._node.create_client(type_, name)
        self.until(client.service_is_ready, f'service {name} is offered')
        future = client.call_async(type_.Request(**fields))  # type: ignore[attr-defined]
        self.until(future.done, f'service {name} answers')
        self._node.destroy_client(client)
        reply = future.result()
        if not reply.success:
            raise TourError(f'{name}: {reply.message}')
        return str(reply.message)

    def pursue(self, name: str, **fields: Any) -> None:
        """Send a goal to the driver and wait until it is reached; TourError: it was not."""
        self._commanded = None  # a velocity command would take over
        action, = (each.type for each in ACTIONS if each.name == name)
        client = ActionClient(self._node, action, name)
        try:
            self.until(client.server_is_ready, f'action {name} is offered')
            sent = client.send_goal_async(action.Goal(**fields))
            self.until(sent.done, f'action {name} takes the goal')
            if not sent.result().accepted:
                raise TourError(f'{name}: rejected as malformed')
            ended = sent.result().get_result_async()
            self.until(ended.done, f'{name} ends', GOAL_TIMEOUT)
        finally:
            client.destroy()
        result = ended.result().result
        if not result.success:
            raise TourError(f'{name}: {result.message}')

    def turn_to(self, yaw: float) -> None:
        """Turn in place to a heading, the short way."""
        self.pursue('rotate_angle', angle=remainder(yaw - self.yaw, tau))

    def go_to(self, x: float, y: float) -> None:
        """Turn towards a point and drive there; TourError: an obstacle is in the way."""
        place = Pose(position=Point(x=x, y=y))
        self.pursue('navigate_to_position', goal_pose=PoseStamped(pose=place))

    def back(self, distance: float) -> None:
        """Drive straight backwards."""
        self.pursue('drive_distance', distance=-distance)

    def spiral(self, turns: float, inner: float, outer: float) -> None:
        """Drive a clockwise spiral from an inner to an outer radius, metres."""
        began = self.turned

        def left() -> float:
            return turns * tau - (began - self.turned)

        def steer() -> None:
            done = 1 - left() / (turns * tau)
            radius = inner + (outer - inner) * min(1.0, max(0.0, done))
            # It brakes half as hard as a turn in place, for nothing corrects its end.
            rate = min(SPIRAL_TURN, CRUISE / radius, max(SLOWEST, BRAKING * left() / 2))
            self.command(rate * radius, -rate)
        self.until(lambda: left() <= 0, f'{turns} turns of a spiral', 20.0 * turns, steer)
        self.stop()
