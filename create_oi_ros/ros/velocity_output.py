# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity commands to a driver, in the message type to which it subscribes."""

from __future__ import annotations

from math import inf

from geometry_msgs.msg import Twist, TwistStamped, Vector3
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from .topics import CMD_VEL

COMMANDS = {f'geometry_msgs/msg/{type_.__name__}': type_ for type_ in (Twist, TwistStamped)}
CHECK_INTERVAL, SEARCH_INTERVAL = 1.0, 0.2
"""Seconds between two looks for the driver, when it was there and when it was not."""
UNUSED_CHECKS = 10
"""Checks without a command after which the publisher ends."""
NEWEST = QoSProfile(depth=1)
STOP_TIMEOUT = Duration(seconds=1.0)
"""How long to wait until the last command has arrived."""


class VelocityOutput:
    """
    Publishes velocity commands, once a driver has been found.

    The publisher is made with the first command, and ends when none has followed for a while: a
    driver chooses its message type by its publishers, so one that is not used must not count.
    """

    def __init__(self, node: Node) -> None:
        """Use this node; nothing is published before a driver is found."""
        self._node = node
        self._publisher: Publisher | None = None
        self._type: type | None = None
        self._next_check = -inf
        self._unused = 0
        """Checks since the last command."""
        self.driver_listens = False
        """Whether a driver subscribes to velocity commands."""

    def find_driver(self, now: float) -> None:
        """Check now and then who subscribes to cmd_vel."""
        if now < self._next_check:
            return
        types = [
            COMMANDS[each.topic_type]
            for each in self._node.get_subscriptions_info_by_topic(CMD_VEL)
            if each.node_name != self._node.get_name() and each.topic_type in COMMANDS]
        self.driver_listens = bool(types)
        self._next_check = now + (CHECK_INTERVAL if types else SEARCH_INTERVAL)
        self._unused += 1
        changed = bool(types) and self._type is not types[0]
        if self._publisher is not None and (changed or self._unused > UNUSED_CHECKS):
            self._node.destroy_publisher(self._publisher)
            self._publisher = None
        if types:
            self._type = types[0]

    def publish(self, linear: float, angular: float) -> None:
        """Publish a velocity, m/s and rad/s, if a driver has been found."""
        if self._type is None:
            return
        if self._publisher is None:
            self._publisher = self._node.create_publisher(self._type, CMD_VEL, NEWEST)
        self._unused = 0
        twist = Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))
        if self._type is Twist:
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
