# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Sends goals for the pages, tells all pages how the newest one fares, and cancels it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Mapping
import time
from typing import Any

from rclpy.action.client import ClientGoalHandle
from rclpy.task import Future

from .live_robot import LiveRobot
from .page_messages import feedback_part, PageMessage
from .web_node import awaited, Reply, WebNode

CANCELED = Reply(False, 'canceled before it was sent')
DISCOVERY, LOOK = 2.0, 0.1
"""Seconds in which a driver that has just started must be found, and between two looks."""
GONE = Reply(False, 'the driver has gone')
REJECTED = Reply(False, 'rejected as malformed')


class SentGoal:
    """A goal that a page has sent."""

    def __init__(self, viewer: int, name: str) -> None:
        self.viewer, self.name = viewer, name
        self.handle: ClientGoalHandle | None = None
        """Set when the driver has accepted it."""
        self.canceling = False
        self.code = 0
        """`error_code` of its result; 0 also while there is none."""
        self.ended: asyncio.Future[Reply] = asyncio.get_running_loop().create_future()

    def end(self, reply: Reply) -> None:
        """End it, if it has not ended yet."""
        if not self.ended.done():
            self.ended.set_result(reply)


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
        return self._pursue(goal, message.goal)

    async def _pursue(self, goal: SentGoal, request: Any) -> Reply:
        client = self._node.action_client(goal.name)
        looked = 0.0
        while not (client.server_is_ready() or goal.canceling) and looked < DISCOVERY:
            await asyncio.sleep(LOOK)
            looked += LOOK
        if goal.canceling:
            goal.end(CANCELED)
        elif not client.server_is_ready():
            goal.end(self._node.nobody_offers(goal.name))
        else:
            await self._send(goal, client.send_goal_async(
                request, lambda message: self._on_feedback(goal, message.feedback)))
        reply = await goal.ended
        state = 'reached' if reply.ok else 'canceled' if goal.canceling else 'ended'
        self._show(goal, state, reply.text)
        self._robot.happened('error' if state == 'ended' else '', f'{goal.name.replace("_", " ")}'
                             f' {state}: {reply.text}', time.monotonic())
        return reply

    async def _send(self, goal: SentGoal, sent: Future) -> None:
        try:
            self._follow(goal, await awaited(sent))
        except TimeoutError as error:
            # The driver may still accept it: cancel it then.
            goal.end(Reply(False, str(error)))
            sent.add_done_callback(lambda late: late.result().cancel_goal_async())

    def _follow(self, goal: SentGoal, handle: ClientGoalHandle) -> None:
        """Wait for the result of a goal, if it was accepted."""
        if not handle.accepted:
            goal.end(REJECTED)
            return
        goal.handle = handle
        if goal.canceling:
            handle.cancel_goal_async()
        else:
            self._show(goal, 'under way')

        def on_result(done: Any) -> None:
            result = done.result().result
            goal.code = int(getattr(result, 'error_code', 0))
            goal.end(Reply(bool(result.success), str(result.message)))
        handle.get_result_async().add_done_callback(on_result)

    def _on_feedback(self, goal: SentGoal, feedback: Any) -> None:
        if not goal.canceling and not goal.ended.done():
            self._show(goal, 'under way', feedback=feedback_part(feedback))

    def _show(self, goal: SentGoal, state: str, text: str = '', *,
              feedback: Mapping[str, Any] | None = None) -> None:
        if goal is self._newest:
            self._robot.parts.put(self._part, {
                'name': goal.name, 'viewer': goal.viewer, 'state': state, 'text': text,
                'code': goal.code, 'feedback': feedback})

    @property
    def _running(self) -> SentGoal | None:
        goal = self._newest
        return None if goal is None or goal.ended.done() else goal

    def cancel(self) -> bool:
        """Cancel the goal that runs; return whether there is one."""
        goal = self._running
        if goal is None:
            return False
        goal.canceling = True
        self._show(goal, 'canceling')
        if goal.handle is not None:
            goal.handle.cancel_goal_async()
        return True

    def check(self, viewer: int | None) -> None:
        """Cancel the goal if only another `viewer` may drive; end it if the driver has gone."""
        goal = self._running
        if goal is None:
            return
        if goal.viewer != viewer and not goal.canceling:
            self.cancel()
        if goal.handle and not self._node.action_client(goal.name).server_is_ready():
            goal.end(GONE)
