"""
The shortest program that does a driver's job: `floor.py PORT CALL LAYOUT COMMAND [MODULE ...]`.

One thread reads the port, one `struct` unpacks a frame, one Odometry is published for it; what
`cmd_vel` says is written at once. No checksum, no mode, no odometry, no other topic: whatever a
driver takes beyond this is what its work costs. CALL (hex) makes the robot stream frames that
LAYOUT unpacks to the right and the left requested velocity; COMMAND is the opcode of Drive
Direct. Modules that are named are imported, to be in memory as they are in the driver.
"""

from importlib import import_module
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
for module in sys.argv[5:]:
    import_module(module)
rclpy.init()
node = rclpy.create_node('floor')
odom = node.create_publisher(Odometry, 'odom', 10)


def drive(twist: Twist) -> None:
    """Say both wheels' speed."""
    speed = round(twist.linear.x * 1000)
    port.write(struct.pack('>Bhh', opcode, speed, speed))


def read() -> None:
    """Publish each frame."""
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
