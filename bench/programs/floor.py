# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The least that a driver can do: `floor.py PORT CALL LAYOUT COMMAND`.

One thread reads the port, unpacks each frame with one `struct` and publishes one Odometry for it.
A velocity from `cmd_vel` is written to the port at once. There is no checksum, no mode, no
odometry and no other topic, so what the node takes beyond this is the cost of its own work.

CALL (hex) is sent first: it starts the stream. LAYOUT unpacks a frame to the requested right and
left velocity. COMMAND is the opcode of Drive Direct.
"""

import signal
import struct
import sys
import threading

from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
import rclpy
import serial

port = serial.Serial(sys.argv[1], 57600, exclusive=True)
layout = struct.Struct(sys.argv[3])
opcode = int(sys.argv[4])
rclpy.init()
node = rclpy.create_node('floor')
odom = node.create_publisher(Odometry, 'odom', 10)


def drive(twist: Twist) -> None:
    speed = round(twist.linear.x * 1000)
    port.write(struct.pack('>Bhh', opcode, speed, speed))


def read() -> None:
    port.write(bytes.fromhex(sys.argv[2]))
    while True:
        right, left = layout.unpack(port.read(layout.size))
        message = Odometry()
        message.header.stamp = node.get_clock().now().to_msg()
        message.header.frame_id = 'odom'
        message.child_frame_id = 'base_footprint'
        message.twist.twist.linear.x = (right + left) / 2000
        odom.publish(message)


node.create_subscription(Twist, 'cmd_vel', drive, 1)
signal.signal(signal.SIGTERM, signal.SIG_DFL)
threading.Thread(target=read, daemon=True).start()
rclpy.spin(node)
