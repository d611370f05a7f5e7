# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Action clients for tests: a goal is sent, its feedback collected, its result awaited."""

from typing import Any

from rclpy.action.client import ActionClient

from support.ros import Listener


class Sent:
    """A goal that was accepted."""

    def __init__(self, ros: Listener, handle: Any, feedback: list[Any]) -> None:
        self._ros, self._handle = ros, handle
        self._result = handle.get_result_async()
        self.feedback = feedback
        self.status = 0

    def result(self) -> Any:
        """Wait for the result; its status is in `status` then."""
        self._ros.until(self._result.done, 'a result')
        wrapped = self._result.result()
        self.status = wrapped.status
        return wrapped.result

    def cancel(self) -> bool:
        """Cancel the goal; return whether that was accepted."""
        answer = self._handle.cancel_goal_async()
        self._ros.until(answer.done, 'the answer to a cancel')
        return bool(answer.result().goals_canceling)


class Client:
    """Sends goals of any action."""

    def __init__(self, ros: Listener) -> None:
        self._ros = ros
        self._clients: dict[str, ActionClient] = {}

    def send(self, type_: Any, name: str, **fields: Any) -> Sent | None:
        """Send a goal; return it, None where it was rejected."""
        if name not in self._clients:
            self._clients[name] = ActionClient(self._ros.node, type_, name)
        client = self._clients[name]
        self._ros.until(client.server_is_ready, f'action {name}')
        feedback: list[Any] = []
        answer = client.send_goal_async(
            type_.Goal(**fields),
            feedback_callback=lambda message: feedback.append(message.feedback))
        self._ros.until(answer.done, f'the answer of {name}')
        handle = answer.result()
        return Sent(self._ros, handle, feedback) if handle.accepted else None

    def result(self, type_: Any, name: str, **fields: Any) -> Any:
        """Send a goal that is accepted, and wait for its result."""
        sent = self.send(type_, name, **fields)
        assert sent is not None, f'{name} was rejected'
        return sent.result()

    def close(self) -> None:
        """Destroy the clients, before their node."""
        for client in self._clients.values():
            client.destroy()
