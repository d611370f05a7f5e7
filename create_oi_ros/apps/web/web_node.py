# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The ROS node of the page: subscriptions, velocity commands, a client of the driver, and goals.

All pages are told how the newest goal fares, and each can cancel it.
"""

from __future__ import annotations

from collections.abc import Awaitable
from math import isfinite
import time
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from ...ros.collector import subscribe
from ...ros.driver_client import DriverClient, Goal, GoalState, Reply
from ...ros.velocity import VelocityOutput
from .access import CALLS
from .live_robot import LiveRobot, PARTS

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""For `odom`: the page is told twenty times a second."""


class WebNode(Node):
    """Passes messages to a live robot; has what publishes velocities and calls the driver."""

    def __init__(self) -> None:
        """Subscribe to the driver's topics and create clients for the services."""
        super().__init__('create_web', start_parameter_services=False, enable_rosout=False)
        self.velocity = VelocityOutput(self)
        self.robot = LiveRobot(self.get_namespace())
        subscribe(self, PARTS, lambda name, message: self.robot.update(
            name, message, time.monotonic()), odom=NEWEST)
        self.driver = DriverClient(self)
        for name in CALLS:  # discovery takes a moment: before they are needed
            self.driver.client(name)


def feedback_part(feedback: Any) -> dict[str, Any]:
    """Return a feedback as JSON can say it; a number that is none is left out."""
    found = {name: getattr(feedback, name) for name in feedback.get_fields_and_field_types()}
    return {name: round(value, 3) if isinstance(value, float) else value
            for name, value in found.items()
            if isinstance(value, str) or (isinstance(value, int | float) and isfinite(value))}


class NewestGoal:
    """The newest goal of a kind: all pages are shown it, and can cancel it."""

    def __init__(self, node: WebNode, part: str) -> None:
        """Show it as a part of the node's robot."""
        self._node, self._part = node, part
        self._goal: Goal | None = None
        self._viewer = 0

    def begin(self, viewer: int, name: str, goal: Any) -> Awaitable[Reply]:
        """Begin a goal at once, so that STOP finds it; return what waits for its end."""
        self._viewer = viewer
        self._goal = Goal(self._node.driver, name, goal, self._show)
        self._show(self._goal)
        return self._goal.pursue()

    def _show(self, goal: Goal) -> None:
        text = '' if goal.reply is None else goal.reply.text
        if goal.reply is not None:
            self._node.robot.happened('error' if goal.state is GoalState.FAILED else '',
                                 f'{goal.name.replace("_", " ")}: {text}', time.monotonic())
        if goal is self._goal:
            runs = goal.state is GoalState.UNDER_WAY and goal.feedback is not None
            self._node.robot.parts.put(self._part, {
                'name': goal.name, 'viewer': self._viewer, 'state': goal.state.value,
                'text': text, 'feedback': feedback_part(goal.feedback) if runs else None})

    def cancel(self, but: int | None = None) -> bool:
        """Cancel the goal that runs, if it is not of a viewer; return whether there is one."""
        if self._goal is None or self._goal.reply is not None or self._viewer == but:
            return False
        self._goal.cancel()
        return True
