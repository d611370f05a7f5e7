# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A node of your own to start from: it drives ahead, and turns away where the bumper touches.

It is plain rclpy, with a client for each of two actions. Ctrl-C ends it, and the driver stops the
wheels.
"""
import argparse
from math import radians
import signal
from typing import Any

from create_oi_msgs.action import DriveDistance, RotateAngle
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

AHEAD = DriveDistance.Goal(distance=1.0)
AWAY = (DriveDistance.Goal(distance=-0.1), RotateAngle.Goal(angle=radians(100)))


class Explorer(Node):
    """Sends one goal after the other; what comes next depends on how the last one ended."""

    def __init__(self) -> None:
        super().__init__('explorer')
        self.clients_of = {
            DriveDistance.Goal: ActionClient(self, DriveDistance, 'drive_distance'),
            RotateAngle.Goal: ActionClient(self, RotateAngle, 'rotate_angle')}
        self.next: list[Any] = []
        self.ended: list[str] = []
        self.get_logger().info('waits for the driver')
        self.clients_of[DriveDistance.Goal].wait_for_server()
        self.send(AHEAD)

    def send(self, goal: Any) -> None:
        """Send a goal; the answers come while the node spins."""
        self.clients_of[type(goal)].send_goal_async(goal).add_done_callback(self.on_accepted)

    def on_accepted(self, sent: Future) -> None:
        if sent.result().accepted:
            sent.result().get_result_async().add_done_callback(self.on_result)
        else:
            self.ended.append('refused: the log of the driver says why')

    def on_result(self, got: Future) -> None:
        result = got.result().result
        self.get_logger().info(result.message)
        if result.error_code == DriveDistance.Result.BUMP:
            self.next = list(AWAY)
        elif not result.success:
            self.ended.append('the robot does not go on')
            return
        self.send(self.next.pop(0) if self.next else AHEAD)


argparse.ArgumentParser(description=__doc__).parse_args(remove_ros_args()[1:])
try:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # Ctrl-C is a KeyboardInterrupt
    node = Explorer()
    # Signals are only noted from here on: an exception could come amid a message.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: node.ended.append('Ctrl-C'))
    while not node.ended:
        rclpy.spin_once(node, timeout_sec=0.1)
    print(node.ended[0])
except KeyboardInterrupt:
    pass
