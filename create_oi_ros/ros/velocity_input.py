# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Reads velocity commands from their bytes: a Twist has six numbers, and two are needed."""

from collections.abc import Callable

from geometry_msgs.msg import Twist
from rclpy.serialization import deserialize_message, serialize_message

from .serialized import Unpacking, unpacking

DRIVEN_AXES = 'linear.x', 'angular.z'
"""The fields of a Twist that two wheels can follow."""


class TwistReader:
    """Takes forward speed, m/s, and turn rate, rad/s, out of a serialized Twist."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Look up where they are; where that is not certain, `warn`, and let rclpy convert."""
        self._unpack: Unpacking | None = None
        try:
            self._unpack = unpacking(Twist(), DRIVEN_AXES, serialize_message)
        except ValueError as error:
            warn(f'Twist: {error}. Commands are converted by rclpy instead, which takes more '
                 'processor time; please report it, with the versions of ROS and of its '
                 'middleware')

    def __call__(self, received: bytes) -> tuple[float, float]:
        """Return both numbers."""
        found = None if self._unpack is None else self._unpack(received)
        if found is None:  # the sender has another byte order, or encodes otherwise
            twist = deserialize_message(received, Twist)
            return twist.linear.x, twist.angular.z
        linear, angular = found
        return linear, angular
