# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Drive a circle for five seconds; print each second where the odometry says the robot is."""
import argparse
import signal
import time

from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.waiting import wait_for_robot

argparse.ArgumentParser(description=__doc__).parse_args(remove_ros_args()[1:])
circle = Twist(linear=Vector3(x=0.2), angular=Vector3(z=0.5))
heard: list[Odometry] = []
ended: list[str] = []


def show() -> None:
    if heard:
        place = heard[-1].pose.pose.position
        print(f'x {place.x:+.2f} y {place.y:+.2f} m', flush=True)


try:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # Ctrl-C is a KeyboardInterrupt
    node = rclpy.create_node('drive')
    velocity = node.create_publisher(Twist, 'cmd_vel', 1)
    wait_for_robot(node)
    node.create_timer(0.1, lambda: velocity.publish(circle))
    node.create_subscription(Odometry, 'odom', heard.append, 1)
    node.create_timer(1.0, show)
    # Ctrl-C is only noted from here on: an exception could come amid a message.
    signal.signal(signal.SIGINT, lambda *_: ended.append('Ctrl-C'))
    until = time.monotonic() + 5.5
    while not ended and time.monotonic() < until:
        rclpy.spin_once(node, timeout_sec=0.1)
except KeyboardInterrupt:
    ended.append('Ctrl-C')
if ended:
    print('no more commands, the driver stops the wheels: Ctrl-C')
