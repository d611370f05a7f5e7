# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Sends goals and requests to a driver; coroutines of asyncio wait for what becomes of them.

Whoever uses this lets rclpy run beside them on the same thread, by `rclpy.spin_once` for example.
"""

from collections.abc import Callable
from contextlib import suppress
from enum import Enum
from typing import Any, NamedTuple

from rclpy.action.client import ActionClient, ClientGoalHandle
from rclpy.node import Node

from .actions import ACTION_TYPES, malformed
from .answers import answer_of, found
from .services import SERVICE_TYPES

CHECK_INTERVAL = 1.0
"""Seconds between two looks whether the driver is still there."""


class Reply(NamedTuple):
    """How a goal or a request ended: with what sentence, and what result or response, if any."""

    ok: bool
    text: str
    message: Any = None


class DriverClient:
    """The clients of a node for the driver's actions and services, made when first needed."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self._clients: dict[str, Any] = {}

    def client(self, name: str) -> Any:
        """Return the client of the action or service with this name."""
        if name not in self._clients:
            self._clients[name] = (
                ActionClient(self.node, ACTION_TYPES[name], name) if name in ACTION_TYPES else
                self.node.create_client(SERVICE_TYPES[name], name))
        return self._clients[name]

    def offered(self, name: str) -> bool:
        """Return whether a driver offers this action or service."""
        client = self.client(name)
        return bool(client.server_is_ready() if name in ACTION_TYPES else
                    client.service_is_ready())

    def destroy(self) -> None:
        """Destroy what rclpy does not destroy with the node."""
        for client in self._clients.values():
            if isinstance(client, ActionClient):
                client.destroy()

    async def call(self, name: str, request: Any) -> Reply:
        """Call a service of the driver."""
        try:
            await found(self.node, name, lambda: self.offered(name))
            answer = self.client(name).call_async(request)
            try:
                response = await answer_of(answer, self.node)
            finally:
                self.client(name).remove_pending_request(answer)
        except TimeoutError as error:
            return Reply(False, str(error))
        return Reply(bool(response.success), str(response.message), response)


class GoalState(Enum):
    SENT = 'sent'
    UNDER_WAY = 'under way'
    CANCELING = 'canceling'
    REACHED = 'reached'
    CANCELED = 'canceled'
    FAILED = 'ended'


class Goal:
    """A goal of one of the driver's actions."""

    def __init__(self, driver: DriverClient, name: str, request: Any,
                 on_change: Callable[['Goal'], object]) -> None:
        """`on_change` is called at each change of `state` and `feedback`."""
        self.name, self.state = name, GoalState.SENT
        self.feedback: Any = None
        """The newest one; None: none has come."""
        self.reply: Reply | None = None
        """None before the end."""
        self._driver, self._request, self._on_change = driver, request, on_change
        self._handle: ClientGoalHandle | None = None

    async def pursue(self) -> Reply:
        """Send the goal, and wait for its end."""
        try:
            self.reply = await self._pursue()
        except TimeoutError as error:
            self.reply = Reply(False, str(error))
        self._become(GoalState.REACHED if self.reply.ok else
                     GoalState.CANCELED if self._canceled else GoalState.FAILED)
        return self.reply

    async def _pursue(self) -> Reply:
        node = self._driver.node
        await found(node, self.name, lambda: self._canceled or self._driver.offered(self.name))
        if self._canceled:
            return Reply(False, 'canceled before it was sent')
        sent = self._driver.client(self.name).send_goal_async(self._request, self._on_feedback)
        try:
            handle = await answer_of(sent, node)
        except TimeoutError:  # the driver may still accept it: cancel it then
            sent.add_done_callback(lambda late: late.result().cancel_goal_async())
            raise
        if not handle.accepted:
            why = malformed(self.name, self._request) or 'the log of the driver says why'
            return Reply(False, f'rejected as malformed; {why}')
        self._handle = handle
        if self._canceled:
            handle.cancel_goal_async()
        else:
            self._become(GoalState.UNDER_WAY)
        ended = handle.get_result_async()
        while self._driver.offered(self.name):
            with suppress(TimeoutError):
                result = (await answer_of(ended, node, CHECK_INTERVAL)).result
                return Reply(bool(result.success), str(result.message), result)
        return Reply(False, 'the driver has gone')

    @property
    def _canceled(self) -> bool:
        return self.state is GoalState.CANCELING

    def cancel(self) -> None:
        """Ask the driver to cancel it, if it has not ended; `pursue` waits for the end."""
        if not self._canceled and self.reply is None:
            self._become(GoalState.CANCELING)
            if self._handle is not None:
                self._handle.cancel_goal_async()

    def _on_feedback(self, message: Any) -> None:
        self.feedback = message.feedback
        self._on_change(self)

    def _become(self, state: GoalState) -> None:
        self.state = state
        self._on_change(self)
