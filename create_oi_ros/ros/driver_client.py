# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Sends goals and requests to a driver; coroutines of asyncio wait for what becomes of them.

Whoever uses this lets rclpy run beside them on the same thread, by `rclpy.spin_once` for example.
"""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from enum import Enum
from typing import Any, NamedTuple

from rclpy.action.client import ActionClient, ClientGoalHandle
from rclpy.node import Node
from rclpy.task import Future

from .actions import ALL_ACTIONS, malformed
from .services import SERVICES
from .waiting import other_user

REPLY_TIMEOUT = 10.0
"""Seconds in which the driver must answer a request, or accept a goal."""
LOOK_INTERVAL, CHECK_INTERVAL = 0.1, 1.0
"""Seconds between two looks for a driver, and whether it is still there."""
ACTION_TYPES: dict[str, Any] = {action.name: action.type for action in ALL_ACTIONS}
SERVICE_TYPES: dict[str, Any] = {service.name: service.type for service in SERVICES}


class Reply(NamedTuple):
    """How a goal or a request ended: with what sentence, and what result or response, if any."""

    ok: bool
    text: str
    message: Any = None


async def awaited(future: Future, timeout: float) -> Any:
    """Return the result of a future of rclpy; TimeoutError: none came within so many seconds."""
    done = asyncio.Event()
    future.add_done_callback(lambda _: done.set())
    try:
        await asyncio.wait_for(done.wait(), timeout)
    except TimeoutError:
        raise TimeoutError(f'the driver does not answer within {timeout:g} s') from None
    return future.result()


class DriverClient:
    """The clients of a node for the driver's actions and services, made when first needed."""

    def __init__(self, node: Node, discovery_timeout: float) -> None:
        """Look for the driver so many seconds at most."""
        self.node = node
        self._timeout = discovery_timeout
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

    async def find(self, name: str, given_up: Callable[[], bool] = lambda: False) -> None:
        """Wait until a driver offers something; TimeoutError: none does."""
        for _ in range(round(self._timeout / LOOK_INTERVAL)):
            if given_up() or self.offered(name):
                return
            await asyncio.sleep(LOOK_INTERVAL)
        raise TimeoutError(f'no driver offers {self.node.resolve_service_name(name)} in ROS '
                           f'domain {self.node.context.get_domain_id()}')

    def unanswered(self, error: TimeoutError) -> Reply:
        """Return the reply where the driver was found, but has not answered."""
        why = other_user(self.node)
        return Reply(False, f'{error}: {why}' if why else str(error))

    async def call(self, name: str, request: Any) -> Reply:
        """Call a service of the driver."""
        try:
            await self.find(name)
            answer = self.client(name).call_async(request)
            try:
                response = await awaited(answer, REPLY_TIMEOUT)
            finally:
                self.client(name).remove_pending_request(answer)
        except TimeoutError as error:
            return self.unanswered(error)
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
                 on_change: Callable[['Goal'], object] = lambda goal: None) -> None:
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
            self.reply = self._driver.unanswered(error)
        self._become(GoalState.REACHED if self.reply.ok else
                     GoalState.CANCELED if self._canceled else GoalState.FAILED)
        return self.reply

    async def _pursue(self) -> Reply:
        await self._driver.find(self.name, lambda: self._canceled)
        if self._canceled:
            return Reply(False, 'canceled before it was sent')
        sent = self._driver.client(self.name).send_goal_async(self._request, self._on_feedback)
        try:
            handle = await awaited(sent, REPLY_TIMEOUT)
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
                result = (await awaited(ended, CHECK_INTERVAL)).result
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
        if self.state is GoalState.UNDER_WAY:
            self._on_change(self)

    def _become(self, state: GoalState) -> None:
        self.state = state
        self._on_change(self)
