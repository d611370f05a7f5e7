# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Drive a circle for five seconds and print where the odometry says the robot is."""
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
import rclpy

rclpy.init()
node = rclpy.create_node('drive')
circle = Twist(linear=Vector3(x=0.2), angular=Vector3(z=0.5))
velocity = node.create_publisher(Twist, 'cmd_vel', 1)
while not velocity.get_subscription_count():  # it takes up to three seconds
    rclpy.spin_once(node, timeout_sec=0.1)
node.create_timer(0.1, lambda: velocity.publish(circle))
node.create_subscription(Odometry, 'odom', lambda odom: print(odom.pose.pose.position), 1)
rclpy.spin_until_future_complete(node, rclpy.task.Future(), timeout_sec=5.0)
