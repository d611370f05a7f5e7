# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity commands to a driver, in the message type to which it subscribes."""

from __future__ import annotations

from math import inf
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped, Vector3
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from .topics import CMD_VEL

COMMANDS = {f'geometry_msgs/msg/{type_.__name__}': type_ for type_ in (Twist, TwistStamped)}
CHECK_INTERVAL, SEARCH_INTERVAL = 1.0, 0.2
"""Seconds between two looks for the driver, when it was there and when it was not."""
NEWEST = QoSProfile(depth=1)
STOP_TIMEOUT = Duration(seconds=1.0)
"""How long to wait until the last command has arrived."""


class VelocityOutput:
    """Publishes velocity commands, once a driver has been found."""

    def __init__(self, node: Node) -> None:
        """Use this node; nothing is published before a driver is found."""
        self._node = node
        self._publisher: Publisher | None = None
        self._next_check = -inf
        self.driver_listens = False
        """Whether a driver subscribes to velocity commands."""

    @property
    def type(self) -> Any:
        """The message type of the commands; None before a driver is found."""
        return None if self._publisher is None else self._publisher.msg_type

    def find_driver(self, now: float) -> bool:
        """Check now and then who subscribes to cmd_vel; return whether it was checked now."""
        if now < self._next_check:
            return False
        types = [
            COMMANDS[each.topic_type]
            for each in self._node.get_subscriptions_info_by_topic(CMD_VEL)
            if each.node_name != self._node.get_name() and each.topic_type in COMMANDS]
        self.driver_listens = bool(types)
        self._next_check = now + (CHECK_INTERVAL if types else SEARCH_INTERVAL)
        if types and self.type is not types[0]:
            if self._publisher is not None:
                self._node.destroy_publisher(self._publisher)
            self._publisher = self._node.create_publisher(types[0], CMD_VEL, NEWEST)
        return True

    def publish(self, linear: float, angular: float) -> None:
        """Publish a velocity, m/s and rad/s, if a driver has been found."""
        if self._publisher is None:
            return
        twist = Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))
        if self.type is Twist:
            self._publisher.publish(twist)
        else:
            stamped = TwistStamped(twist=twist)
            stamped.header.stamp = self._node.get_clock().now().to_msg()
            self._publisher.publish(stamped)

    def stop(self) -> None:
        """Command a standstill, and wait until the command has arrived."""
        self.publish(0.0, 0.0)
        if self._publisher is not None:
            self._publisher.wait_for_all_acked(STOP_TIMEOUT)
