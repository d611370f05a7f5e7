# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Drives a robot by its goals, services and velocities, and waits for what it reports."""

from __future__ import annotations

from collections.abc import Callable
from math import remainder, tau
import time
from typing import Any

from create_oi_msgs.msg import Bumper, Mode, Song
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Pose, PoseStamped, Twist, Vector3
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from ...driver import MotionLimits
from ...ros.goal_client import GoalClient, GoalFailed
from ...ros.messages import yaw_of
from ...ros.robot_state import RobotState
from ...ros.topics import CMD_VEL

PERIOD = 0.05
"""Seconds between two commands."""
CRUISE, SPIRAL_TURN = 0.3, 1.6
"""Highest speeds of a spiral, m/s and rad/s."""
BRAKING = min(2.5, MotionLimits.angular_acceleration / SPIRAL_TURN)
"""Turning speed, rad/s, for each radian left to turn: braking stays within the driver's limits."""
SLOWEST = 0.2
"""Turning speed at least, rad/s."""
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
        self._steer: Callable[[], None] = lambda: None
        self._next = 0.0
        self.sent = 0
        """Commands published."""
        self.turned = 0.0
        """Angle turned since the start, rad; may exceed a full turn."""
        self.state = RobotState()
        self.state.listen(node, Odometry, Bumper, Mode, Song, DiagnosticArray)

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
    def song_plays(self) -> bool:
        """Whether a song plays."""
        song = self.state.newest(Song)
        return song is not None and bool(song.playing)

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

    def until(
        self, happened: Callable[[], Any], what: str, seconds: float = 10.0,
        steer: Callable[[], None] = lambda: None,
    ) -> None:
        """Wait for a condition, steering meanwhile; TourError: it did not come in time."""
        deadline, self._steer = time.monotonic() + seconds, steer
        while not happened():
            if time.monotonic() > deadline:
                self.release()
                raise TourError(f'{what} did not happen within {seconds:.0f} s')
            self._spin()

    def _spin(self) -> None:
        """Receive, and send the velocity that is set when it is time."""
        self._check()
        before = self.yaw
        self._executor.spin_once(timeout_sec=PERIOD / 2)
        self.turned += remainder(self.yaw - before, tau)
        if time.monotonic() >= self._next:
            self._next = time.monotonic() + PERIOD
            self._steer()
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

    def start(self, name: str, **goal: Any) -> None:
        """Send a goal instead of velocities, which would take over."""
        self._commanded, self._steer = None, lambda: None
        super().start(name, **goal)

    def turn_to(self, yaw: float) -> None:
        """Turn in place to a heading, the short way."""
        self.do('rotate_angle', angle=remainder(yaw - self.yaw, tau))

    def go_to(self, x: float, y: float) -> None:
        """Turn towards a point and drive there; GoalFailed: an obstacle is in the way."""
        place = Pose(position=Point(x=x, y=y))
        self.do('navigate_to_position', goal_pose=PoseStamped(pose=place))

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
