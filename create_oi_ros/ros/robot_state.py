# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What programs know of a robot: the newest message of each of its driver's topics."""

from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from .diagnostics import of_driver
from .topics import PUBLISHED

Message = TypeVar('Message')


class RobotState:
    """The newest message of each type."""

    def __init__(self) -> None:
        self._newest: dict[type, Any] = {}

    def newest(self, type_: type[Message]) -> Message | None:
        """Return the newest message of a type; None before the first."""
        return self._newest.get(type_)

    def take(self, message: Any) -> None:
        """Take a message of the driver."""
        self._newest[type(message)] = message

    def listen(self, node: Node, *types: type) -> None:
        """Take the messages of these types of the driver in a node's namespace."""
        own = node.get_namespace().strip('/')

        def take_own(diagnostics: DiagnosticArray) -> None:  # all drivers share the topic
            if of_driver(diagnostics, own) is not None:
                self.take(diagnostics)
        for topic in PUBLISHED:
            if topic.type in types:
                take = take_own if topic.type is DiagnosticArray else self.take
                node.create_subscription(topic.type, topic.name, take, topic.subscription_qos)
