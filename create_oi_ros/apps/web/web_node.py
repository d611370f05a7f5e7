# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The ROS node of the page: subscriptions, velocity commands, calls of services, and goals.

All pages are told how the newest goal fares, and each can cancel it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
import time
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action.client import ActionClient, ClientGoalHandle
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future

from ...ros import topics
from ...ros.diagnostics import of_driver
from ...ros.velocity import VelocityOutput
from .live_robot import LiveRobot, PARTS
from .page_messages import CALLS, feedback_part, GOALS, PageMessage

REPLY_TIMEOUT = 10.0
"""Seconds to wait for the reply of a service."""
DISCOVERY, LOOK = 2.0, 0.1
"""Seconds in which a driver that has just started must be found, and between two looks."""
CHECK = 1.0
"""Seconds between two looks whether the driver is still there."""
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""For `odom`: the page is told twenty times a second."""


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


async def found(ready: Callable[[], bool]) -> bool:
    """Wait as long as a driver that has just started may take; return whether it is ready."""
    looked = 0.0
    while not ready() and looked < DISCOVERY:
        await asyncio.sleep(LOOK)
        looked += LOOK
    return ready()


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
                self.create_subscription(
                    topic.type, topic.name,
                    lambda message: robot.update(message, time.monotonic()),
                    NEWEST if topic is topics.ODOM else topic.subscription_qos)
        self.create_subscription(DiagnosticArray, topics.DIAGNOSTICS.name, self._on_diagnostics,
                                 topics.DIAGNOSTICS.subscription_qos)
        # Discovery takes a moment, so the clients are created before they are needed.
        self._service_clients = {
            name: self.create_client(type_, name) for name, type_ in CALLS.items()}
        self._action_clients: dict[str, ActionClient] = {}

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
        if not await found(client.service_is_ready):
            return self.nobody_offers(service)
        answer = client.call_async(request or CALLS[service].Request())
        try:
            reply = await awaited(answer)
        except TimeoutError as error:
            return Reply(False, str(error))
        finally:
            client.remove_pending_request(answer)
        return Reply(bool(reply.success), str(reply.message))


@dataclass
class SentGoal:
    """A goal that a page has sent."""

    viewer: int
    name: str
    handle: ClientGoalHandle | None = None
    """Set when the driver has accepted it."""
    canceling: bool = False
    running: bool = True


class GoalSender:
    """Sends goals of a kind one after the other; the driver lets a new one take over, or not."""

    def __init__(self, node: WebNode, robot: LiveRobot, part: str) -> None:
        """Show the newest goal as a part of this robot."""
        self._node, self._robot, self._part = node, robot, part
        self._newest: SentGoal | None = None

    def pursue(self, viewer: int, message: PageMessage) -> Awaitable[Reply]:
        """Begin a goal at once, so that STOP finds it; return what waits for its end."""
        goal = self._newest = SentGoal(viewer, message.type)
        self._show(goal, 'sent')
        return self._pursue(goal, message.request)

    async def _pursue(self, goal: SentGoal, request: Any) -> Reply:
        reply = await self._reply(goal, request)
        goal.running = False
        state = 'reached' if reply.ok else 'canceled' if goal.canceling else 'ended'
        self._show(goal, state, reply.text)
        self._robot.happened('error' if state == 'ended' else '',
                             f'{goal.name.replace("_", " ")}: {reply.text}', time.monotonic())
        return reply

    async def _reply(self, goal: SentGoal, request: Any) -> Reply:
        """Send a goal, and return how it ends."""
        client = self._node.action_client(goal.name)
        offered = await found(lambda: goal.canceling or client.server_is_ready())
        if goal.canceling:
            return Reply(False, 'canceled before it was sent')
        if not offered:
            return self._node.nobody_offers(goal.name)
        sent = client.send_goal_async(
            request, lambda message: self._on_feedback(goal, message.feedback))
        try:
            handle = await awaited(sent)
        except TimeoutError as error:
            # The driver may still accept it: cancel it then.
            sent.add_done_callback(lambda late: late.result().cancel_goal_async())
            return Reply(False, str(error))
        if not handle.accepted:
            return Reply(False, 'rejected as malformed')
        goal.handle = handle
        if goal.canceling:
            handle.cancel_goal_async()
        else:
            self._show(goal, 'under way')
        ended = handle.get_result_async()
        while not ended.done():
            with suppress(TimeoutError):
                await awaited(ended, CHECK)
            if not (ended.done() or client.server_is_ready()):
                return Reply(False, 'the driver has gone')
        result = ended.result().result
        return Reply(bool(result.success), str(result.message))

    def _on_feedback(self, goal: SentGoal, feedback: Any) -> None:
        if goal.running and not goal.canceling:
            self._show(goal, 'under way', feedback=feedback_part(feedback))

    def _show(self, goal: SentGoal, state: str, text: str = '', *,
              feedback: Mapping[str, Any] | None = None) -> None:
        if goal is self._newest:
            self._robot.parts.put(self._part, {
                'name': goal.name, 'viewer': goal.viewer, 'state': state, 'text': text,
                'feedback': feedback})

    def cancel(self, but: int | None = None) -> bool:
        """Cancel the goal that runs, if it is not of a viewer; return whether there is one."""
        goal = self._newest
        if goal is None or not goal.running or goal.viewer == but:
            return False
        if not goal.canceling:
            goal.canceling = True
            self._show(goal, 'canceling')
            if goal.handle is not None:
                goal.handle.cancel_goal_async()
        return True
