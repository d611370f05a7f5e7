# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Drives a robot by its goals, services and velocities, and waits for what it reports."""

from __future__ import annotations

from collections.abc import Callable
from math import remainder, tau
import time
from typing import Any

from create_oi_msgs.msg import Bumper, Mode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Pose, PoseStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from ...ros.goal_client import GoalClient, GoalFailed
from ...ros.messages import yaw_of
from ...ros.robot_state import RobotState
from ...ros.topics import CMD_VEL

PERIOD = 0.05
"""Seconds between two commands."""
STANDING = 0.01
"""m/s; a slower robot stands."""


class TourError(GoalFailed):
    """Something that the tour waits for did not happen; the message says what."""


class Stopped(Exception):
    """A signal has ended the tour."""


class Pilot(GoalClient):
    """Drives the robot; each method returns when its motion is complete."""

    def __init__(
        self, node: Node, executor: SingleThreadedExecutor, check: Callable[[], None],
    ) -> None:
        """`check` is called while waiting, and may raise to end the tour."""
        super().__init__()
        self.node, self._executor, self._check = node, executor, check
        self._velocity = node.create_publisher(Twist, CMD_VEL, 1)
        self._commanded: Twist | None = None
        self._next = 0.0
        self.state = RobotState()
        self.state.listen(node, Odometry, Bumper, Mode, DiagnosticArray)

    @property
    def odom(self) -> Odometry | None:
        """The newest pose and speed; None before the first."""
        return self.state.newest(Odometry)

    @property
    def mode(self) -> int:
        """The mode, as the message Mode has it."""
        mode = self.state.newest(Mode)
        return Mode.UNKNOWN if mode is None else int(mode.mode)

    @property
    def bumped(self) -> bool:
        """Whether the bumper is pressed."""
        bumper = self.state.newest(Bumper)
        return bumper is not None and bool(bumper.left or bumper.right)

    @property
    def warnings(self) -> list[str]:
        """What the diagnostics warn of."""
        diagnostics = self.state.newest(DiagnosticArray) or DiagnosticArray()
        return [each.message for each in diagnostics.status if each.level != DiagnosticStatus.OK]

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

    def until(self, happened: Callable[[], Any], what: str, seconds: float = 10.0) -> None:
        """Wait for a condition; TourError: it did not come in time."""
        deadline = time.monotonic() + seconds
        while not happened():
            if time.monotonic() > deadline:
                self.release()
                raise TourError(f'{what} did not happen within {seconds:.0f} s')
            self._spin()

    def _spin(self) -> None:
        """Receive, and send the velocity that is set when it is time."""
        self._check()
        self._executor.spin_once(timeout_sec=PERIOD / 2)
        if self._commanded is not None and time.monotonic() >= self._next:
            self._next = time.monotonic() + PERIOD
            self._velocity.publish(self._commanded)

    def command(self, speed: float, turn: float) -> None:
        """Set the velocity to send from now on, m/s and rad/s."""
        self._commanded = Twist(linear=Vector3(x=speed), angular=Vector3(z=turn))

    def release(self) -> None:
        """Send a zero velocity, then no more commands."""
        self._velocity.publish(Twist())
        self._commanded = None

    def stop(self) -> None:
        """Stop, and wait until the robot stands."""
        self.command(0.0, 0.0)
        self.until(lambda: self.standing, 'the robot stands', 3.0)

    def start(self, name: str, **goal: Any) -> None:
        """Send a goal instead of velocities, which would take over."""
        self._commanded = None
        super().start(name, **goal)

    def turn_to(self, yaw: float) -> None:
        """Turn in place to a heading, the short way."""
        self.do('rotate_angle', angle=remainder(yaw - self.yaw, tau))

    def go_to(self, x: float, y: float) -> None:
        """Turn towards a point and drive there; GoalFailed: an obstacle is in the way."""
        place = Pose(position=Point(x=x, y=y))
        self.do('navigate_to_position', goal_pose=PoseStamped(pose=place))
