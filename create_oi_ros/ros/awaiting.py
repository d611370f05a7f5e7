# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Lets a coroutine of a node wait for a result of the driver, which comes on another thread."""

from typing import TypeVar

from rclpy.node import Node
from rclpy.task import Future

from ..driver.pending import Awaited

Result = TypeVar('Result')


def future_of(awaited: Awaited[Result], node: Node) -> Future:
    """Return a future of a result; the thread that brings it wakes the node."""
    ended = Future()

    def end(result: Result) -> None:
        ended.set_result(result)
        if node.executor is not None:
            node.executor.wake()
    awaited.then(end)
    return ended
