# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A subscription whose messages are taken when somebody looks.

rclpy's executor gathers all that it waits for each time that it looks, and again after each
message. A program that looks at many topics twenty times a second spends most of its time so.
"""

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile

from .no_executor import NoExecutor


class PolledTopic:
    """Calls a function with each message of a topic that has come, when `take` is called."""

    def __init__(self, node: Node, type_: type, topic: str, callback: Callable[[Any], None],
                 qos: QoSProfile) -> None:
        """Subscribe."""
        self._subscription = node.create_subscription(
            type_, topic, callback, qos, callback_group=NoExecutor())
        self._most = qos.depth

    def take(self) -> None:
        """Pass on what has come: no more messages than the subscription keeps."""
        subscription = self._subscription
        with subscription.handle:
            for _ in range(self._most):
                taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
                if taken is None:
                    return
                subscription.callback(taken[0])
