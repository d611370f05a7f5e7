# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Reads velocity commands from their bytes: a Twist has six numbers, and two are needed."""

from collections.abc import Callable

from geometry_msgs.msg import Twist
from rclpy.serialization import deserialize_message, serialize_message

from .serialized import PLEASE_REPORT, Unpacking, unpacking

DRIVEN_AXES = 'linear.x', 'angular.z'
"""The fields of a Twist that two wheels can follow."""


def driven(twist: Twist) -> tuple[float, float]:
    """Return forward speed, m/s, and turn rate, rad/s."""
    return twist.linear.x, twist.angular.z


class TwistReader:
    """Takes forward speed, m/s, and turn rate, rad/s, out of a serialized Twist."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Look up where they are; where that is not certain, `warn`, and let rclpy convert."""
        self._unpack: Unpacking | None = None
        try:
            self._unpack = unpacking(Twist(), DRIVEN_AXES, serialize_message)
        except ValueError as error:
            warn(f'Twist: {error}. Commands are converted by rclpy instead, {PLEASE_REPORT}')

    def __call__(self, received: bytes) -> tuple[float, float]:
        """Return both numbers."""
        found = None if self._unpack is None else self._unpack(received)
        if found is None:  # the sender has another byte order, or encodes otherwise
            return driven(deserialize_message(received, Twist))
        linear, angular = found
        return linear, angular
