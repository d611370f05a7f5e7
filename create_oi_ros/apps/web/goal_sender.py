# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Sends goals for the pages, tells all pages how the newest one fares, and cancels it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Mapping
from contextlib import suppress
from dataclasses import dataclass
import time
from typing import Any

from rclpy.action.client import ClientGoalHandle

from .live_robot import LiveRobot
from .page_messages import feedback_part, PageMessage
from .web_node import awaited, Reply, WebNode

CANCELED = Reply(False, 'canceled before it was sent')
DISCOVERY, LOOK = 2.0, 0.1
"""Seconds in which a driver that has just started must be found, and between two looks."""
CHECK = 1.0
"""Seconds between two looks whether the driver is still there."""
GONE = Reply(False, 'the driver has gone')
REJECTED = Reply(False, 'rejected as malformed')


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
        self._robot.happened('error' if state == 'ended' else '', f'{goal.name.replace("_", " ")}'
                             f' {state}: {reply.text}', time.monotonic())
        return reply

    async def _reply(self, goal: SentGoal, request: Any) -> Reply:
        """Send a goal, and return how it ends."""
        client = self._node.action_client(goal.name)
        looked = 0.0
        while not (client.server_is_ready() or goal.canceling) and looked < DISCOVERY:
            await asyncio.sleep(LOOK)
            looked += LOOK
        if goal.canceling:
            return CANCELED
        if not client.server_is_ready():
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
            return REJECTED
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
                return GONE
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
