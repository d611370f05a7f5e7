# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Publishes a velocity 20 times a second until SIGTERM: the robot drives in a circle."""

from time import sleep

from geometry_msgs.msg import Twist
import rclpy
from rclpy.signals import SignalHandlerOptions

rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node('circle')
publisher = node.create_publisher(Twist, 'cmd_vel', 1)
twist = Twist()
twist.linear.x, twist.angular.z = 0.2, 0.5
while True:
    publisher.publish(twist)
    sleep(0.05)
