# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The ROS node of the page: subscriptions, velocity commands, clients of services and actions."""

from __future__ import annotations

import asyncio
import time
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action.client import ActionClient
from rclpy.node import Node
from rclpy.task import Future

from ...ros import topics
from ...ros.diagnostics import of_driver
from ...ros.velocity_output import NEWEST, VelocityOutput
from .live_robot import LiveRobot, PARTS
from .page_messages import CALLS, GOALS

REPLY_TIMEOUT = 10.0
"""Seconds to wait for the reply of a service."""


class Reply(NamedTuple):
    """The reply of a service: whether it worked, and a text for people."""

    ok: bool
    text: str


async def awaited(future: Future, timeout: float = REPLY_TIMEOUT) -> Any:
    """Return the result of a future of rclpy; TimeoutError: none came within so many seconds."""
    answered: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

    def end(done: Future) -> None:
        if not answered.done():
            answered.set_result(done.result())
    future.add_done_callback(end)
    try:
        return await asyncio.wait_for(answered, timeout)
    except TimeoutError:
        raise TimeoutError(f'no reply within {timeout:.0f} s') from None


class WebNode(Node):
    """Passes messages to a live robot, publishes velocity commands, calls services."""

    def __init__(self, robot: LiveRobot) -> None:
        """Subscribe to the driver's topics and create clients for the services."""
        super().__init__('create_web', start_parameter_services=False, enable_rosout=False)
        self._robot = robot
        self._own_namespace = self.get_namespace().strip('/')
        self.velocity = VelocityOutput(self)
        for topic in topics.PUBLISHED:
            if topic.type in PARTS:
                self.create_subscription(topic.type, topic.name, self._on_message,
                                         NEWEST if topic is topics.ODOM else topic.qos)
        self.create_subscription(DiagnosticArray, topics.DIAGNOSTICS.name, self._on_diagnostics,
                                 topics.DIAGNOSTICS.qos)
        # Discovery takes a moment, so the clients are created before they are needed.
        self._service_clients = {
            name: self.create_client(type_, name) for name, type_ in CALLS.items()}
        self._action_clients: dict[str, ActionClient] = {}

    def _on_message(self, message: Any) -> None:
        self._robot.update(message, time.monotonic())

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Pass on the diagnostics of the driver in our namespace."""
        found = of_driver(message, self._own_namespace)
        if found is not None:
            self._robot.diagnose(found[1], time.monotonic())

    def action_client(self, name: str) -> ActionClient:
        """Return the client of an action; it is made when it is first needed."""
        if name not in self._action_clients:
            self._action_clients[name] = ActionClient(self, GOALS[name], name)
        return self._action_clients[name]

    def nobody_offers(self, name: str) -> Reply:
        """Return the reply for a service or an action without a server."""
        return Reply(False, f'nobody offers {self.resolve_service_name(name)}: '
                            'no driver is running')

    async def call(self, service: str, request: Any = None) -> Reply:
        """Call a service and return its reply, or why there is none."""
        client = self._service_clients[service]
        if not client.service_is_ready():
            return self.nobody_offers(service)
        try:
            reply = await awaited(client.call_async(request or CALLS[service].Request()))
        except TimeoutError as error:
            return Reply(False, str(error))
        return Reply(bool(reply.success), str(reply.message))
