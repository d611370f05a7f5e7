# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The least that a driver can do: `floor.py PORT`.

One thread reads the port, unpacks each frame with one `struct` and publishes one Odometry for it.
A velocity from `cmd_vel` is written to the port at once. There is no checksum, no mode, no
odometry and no other topic, so what the node takes beyond this is the cost of its own work.
"""

import struct
import sys
import threading

from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
import rclpy
from rclpy.signals import SignalHandlerOptions
import serial

from create_oi_ros import oi
from create_oi_ros.driver.stream import ESSENTIAL

SPEEDS = ('requested_right_velocity', 'requested_left_velocity')
PACKETS = oi.PacketList([*(name for name in ESSENTIAL if name not in SPEEDS), *SPEEDS])
"""Those that the driver needs in every frame, no more."""
CALL = b''.join(command.encode() for command in (
    oi.Start(), oi.Safe(), oi.Stream(packets=PACKETS.ids)))
LAYOUT = struct.Struct('>xx' + ''.join(
    f'x{"h" if name in SPEEDS else "x" * oi.size_of(oi.NUMBERS[name])}'
    for name in PACKETS.names) + 'x')
port = serial.Serial(sys.argv[1], 57600, exclusive=True)
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node('floor')
odom = node.create_publisher(Odometry, 'odom', 10)


def drive(twist: Twist) -> None:
    speed = round(twist.linear.x * 1000)
    port.write(struct.pack('>Bhh', oi.DriveDirect.opcode, speed, speed))


def read() -> None:
    port.write(CALL)
    while True:
        right, left = LAYOUT.unpack(port.read(LAYOUT.size))
        message = Odometry()
        message.header.stamp = node.get_clock().now().to_msg()
        message.header.frame_id = 'odom'
        message.child_frame_id = 'base_footprint'
        message.twist.twist.linear.x = (right + left) / 2000
        odom.publish(message)


node.create_subscription(Twist, 'cmd_vel', drive, 1)
threading.Thread(target=read, daemon=True).start()
rclpy.spin(node)
