# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A subscription with a thread of its own.

Each time that rclpy's executor wakes, it gathers everything that it waits for. That is much in
this node: over twenty services and seven actions take a millisecond of processor time. A velocity
command, ten or fifty times a second, need not wait for that.
"""

from collections.abc import Callable
import threading
from typing import Any

from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node

from .no_executor import NoExecutor


class TopicThread:
    """Calls a function with each message of a topic, on a thread of its own."""

    def __init__(self, node: Node, type_: type, topic: str, callback: Callable[[Any], None], *,
                 on_failure: Callable[[], None], raw: bool = False) -> None:
        """
        Subscribe, and keep the newest message; `start` begins to take messages.

        With `raw` the function gets the bytes of each. `on_failure` is called when the thread
        ends with an error, whose traceback is printed.
        """
        self._subscription = node.create_subscription(
            type_, topic, callback, 1, callback_group=NoExecutor(), raw=raw)
        assert node.context.handle is not None, 'a node has an initialised context'
        self._context = node.context.handle
        self._bell = GuardCondition(None, None, context=node.context)
        self._on_failure = on_failure
        self._closing = False
        self._thread = threading.Thread(target=self._run, name=topic)

    def start(self) -> None:
        """Begin to take messages."""
        self._thread.start()

    def close(self) -> None:
        """Take no more messages, and wait until the function has returned; once is enough."""
        if self._closing:
            return
        self._closing = True
        self._bell.trigger()
        if self._thread.is_alive():
            self._thread.join()
        self._bell.destroy()

    def _run(self) -> None:
        handle, subscription = self._subscription.handle, self._subscription
        try:
            # While these are entered, nobody else can destroy them.
            with handle, self._bell.handle, self._context:
                wait_set = rclpy_implementation.WaitSet(1, 1, 0, 0, 0, 0, self._context)
                while not self._closing:
                    message = handle.take_message(subscription.msg_type, subscription.raw)
                    if message is not None:
                        subscription.callback(message[0])
                        continue
                    wait_set.clear_entities()
                    wait_set.add_subscription(handle)
                    wait_set.add_guard_condition(self._bell.handle)
                    wait_set.wait(-1)
        finally:
            if not self._closing:
                self._on_failure()
