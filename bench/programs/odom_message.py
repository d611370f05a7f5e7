# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The one message that the floor and its variants publish for each frame."""

from nav_msgs.msg import Odometry
from rclpy.node import Node


def odom_message(node: Node, right: int, left: int) -> Odometry:
    """Return an Odometry with the present time and the mean of two wheel speeds, mm/s."""
    message = Odometry()
    message.header.stamp = node.get_clock().now().to_msg()
    message.header.frame_id = 'odom'
    message.child_frame_id = 'base_footprint'
    message.twist.twist.linear.x = (right + left) / 2000
    return message
