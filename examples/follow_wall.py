# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Follow a wall on the right: drive ahead until the bumper touches something, then along it.

    python examples/follow_wall.py
    python examples/follow_wall.py --ros-args -p signal:=250.0

`signal` is the wanted signal of the wall sensor; a stronger signal means a nearer wall. The
default suits the simulator; for a real wall put the robot beside it and read topic `wall`. The
program ends when the robot leaves Safe mode: at a cliff, lifted, or on a charger.
"""
import argparse
from math import sqrt
import signal

from create_oi_msgs.msg import Bumper, Mode, Wall
from geometry_msgs.msg import Twist, Vector3
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.velocity import driver_type
from create_oi_ros.ros.waiting import wait_for_robot

SIGNAL = 500.0
PERIOD = 0.05
"""Seconds between two commands."""
SPEED, GAIN, SHARPEST = 0.2, 1.6, 0.8
"""Speed, m/s; turning speed for an error of 1, rad/s; fastest turn, rad/s."""
AWAY = ((-0.1, 0.0),) * 6 + ((0.0, 1.2),) * 12
"""Moves after a touch, one a period, m/s and rad/s: back a little, then turn left."""


class Steering:
    """Decides the next move from the bumper and the wall sensor."""

    def __init__(self, wanted: float = SIGNAL) -> None:
        self.wanted = wanted
        self.found = False  # whether a wall has been found
        self.away: list[tuple[float, float]] = []

    def next_move(self, touched: bool, signal: int) -> tuple[float, float]:
        """Return the speed, m/s, and the turning speed to the left, rad/s."""
        if touched and not self.away:
            self.away = list(AWAY)
        self.found = self.found or touched or signal > 0
        if self.away:
            return self.away.pop(0)
        if signal == 0:  # drive ahead to find a wall, or turn right where the wall ended
            return SPEED, -SHARPEST if self.found else 0.0
        # The signal falls with the square of the distance: an error above 0 is too far away.
        error = sqrt(self.wanted / signal) - 1.0
        return SPEED, max(-SHARPEST, min(SHARPEST, -GAIN * error))


class FollowWall(Node):
    """Subscribes to bumper and wall sensor, and commands a velocity each period."""

    def __init__(self) -> None:
        super().__init__('follow_wall')
        self.steering = Steering(self.declare_parameter('signal', SIGNAL).value)
        self.touched, self.signal, self.mode = False, 0, Mode.UNKNOWN
        self.ended = rclpy.task.Future()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(Bumper, 'bumper', self.on_bumper, 10)
        self.create_subscription(Wall, 'wall', self.on_wall, 10)
        self.create_subscription(Mode, 'mode', self.on_mode, latched)
        self.velocity = self.create_publisher(Twist, 'cmd_vel', 1)

    def on_bumper(self, bumper: Bumper) -> None:
        touched = bumper.left or bumper.right
        if touched and not self.touched:
            print('touched something: back, and to the left', flush=True)
        self.touched = touched

    def on_wall(self, wall: Wall) -> None:
        self.signal = wall.signal

    def on_mode(self, mode: Mode) -> None:
        # Before the first Safe, go on: the driver enters Safe with the first command.
        if self.mode == Mode.SAFE and mode.mode != Mode.SAFE:
            self.ended.set_result(f'the robot has left Safe mode, {mode.reason}')
        self.mode = mode.mode

    def drive(self) -> None:
        if driver_type(self) is None:
            self.ended.set_result('the driver has ended')
            return
        speed, turn = self.steering.next_move(self.touched, self.signal)
        self.velocity.publish(Twist(linear=Vector3(x=speed), angular=Vector3(z=turn)))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args(remove_ros_args()[1:])
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # Ctrl-C is a KeyboardInterrupt
        node = FollowWall()
        wait_for_robot(node)
        node.create_timer(PERIOD, node.drive)
        signal.signal(signal.SIGINT, lambda *_: node.ended.set_result('Ctrl-C'))
        rclpy.spin_until_future_complete(node, node.ended)
        why = node.ended.result()
    except KeyboardInterrupt:
        why = 'Ctrl-C'
    print(f'no more commands, the driver stops the wheels: {why}')


if __name__ == '__main__':
    main()
