# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals for programs of a few lines: send one, wait, get its result."""

from types import TracebackType
from typing import Any

import rclpy
from rclpy.action.client import ActionClient

from .actions import ACTIONS

PATIENCE = 10.0
"""Seconds in which a driver must be found."""
TYPES: dict[str, Any] = {action.name: action.type for action in ACTIONS}


class GoalFailed(SystemExit):
    """A goal that was not reached; unless it is caught, the program ends with its one line."""


class GoalClient:
    """
    A ROS node that sends goals to the driver, one after the other.

        with GoalClient() as robot:
            robot.do('drive_distance', distance=0.3)
    """

    def __init__(self, name: str = 'goal_client') -> None:
        """Take the name of the node."""
        self._name = name
        self._clients: dict[str, ActionClient] = {}

    def __enter__(self) -> 'GoalClient':
        rclpy.init()
        self.node = rclpy.create_node(self._name)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        for client in self._clients.values():
            client.destroy()
        context = self.node.context
        self.node.destroy_node()
        if context.ok():  # Ctrl-C has shut it down already
            rclpy.shutdown()

    def do(self, name: str, **goal: Any) -> Any:
        """Pursue a goal of the action with this name; return the result, or raise GoalFailed."""
        if name not in TYPES:
            raise GoalFailed(f'no action {name!r}; there are {", ".join(TYPES)}')
        if name not in self._clients:
            self._clients[name] = ActionClient(self.node, TYPES[name], name)
        client = self._clients[name]
        if not client.wait_for_server(PATIENCE):
            domain = self.node.context.get_domain_id()
            raise GoalFailed(f'{name}: no driver in ROS domain {domain}; is ROS_DOMAIN_ID that of '
                             'the driver?')
        handle = self._wait(client.send_goal_async(TYPES[name].Goal(**goal)))
        if not handle.accepted:
            raise GoalFailed(f'{name}: malformed and rejected, the log of the driver says why')
        result = self._wait(handle.get_result_async()).result
        if not result.success:
            raise GoalFailed(f'{name}: {result.message}')
        return result

    def _wait(self, future: Any) -> Any:
        rclpy.spin_until_future_complete(self.node, future)
        return future.result()
