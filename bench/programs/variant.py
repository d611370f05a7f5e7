"""
The floor with one thing done otherwise: `variant.py WHICH PORT CALL LAYOUT`.

- `timer`: rclpy's executor looks for frames every 15 ms, in place of a thread that waits for them;
- `events`: the events executor of `rclpy.experimental`, in place of the default one;
- `messages`: for each frame, all that the node would publish is published, at the node's rates;
  made beforehand and never filled, so that this is what publishing alone costs;
- `bytes`: the same, serialized beforehand.

The rest is as in floor.py: see there.
"""

from math import inf
import resource
import signal
import struct
import sys
import threading
from time import monotonic
from typing import Any

from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.serialization import serialize_message
import serial

from create_oi_ros.oi import SLOT
from create_oi_ros.ros.topics import DIAGNOSTICS, JOINT_STATES, MODE, PUBLISHED, SENSOR_TOPICS, TF

MOST = 120
"""Seconds of processor time after which the kernel ends this: the events executor never rests."""
SENSOR_PERIOD = 0.05
"""Seconds, as the node's parameter `sensor_rate` has it."""
PERIODS = {MODE.name: inf, DIAGNOSTICS.name: 1.0} | {
    topic.name: topic.period or SENSOR_PERIOD for topic in SENSOR_TOPICS}
"""Seconds between two messages of a topic; what is not here is published with every frame."""
CONTENTS: dict[str, dict[str, Any]] = {
    TF.name: {'transforms': [TransformStamped()]},
    JOINT_STATES.name: {
        'name': ['left_wheel_joint', 'right_wheel_joint'], 'position': [0.0] * 2,
        'velocity': [0.0] * 2}}
"""What a message holds that would be empty otherwise."""

which = sys.argv[1]
resource.setrlimit(resource.RLIMIT_CPU, (MOST, MOST))
port = serial.Serial(sys.argv[2], 57600, exclusive=True)
layout = struct.Struct(sys.argv[4])
rclpy.init()
node = rclpy.create_node('floor')
odom = node.create_publisher(Odometry, 'odom', 10) if which in ('timer', 'events') else None


class Outlet:
    """One topic, and the message that is published again and again."""

    def __init__(self, topic: Any) -> None:
        """Prepare it."""
        self._publisher = node.create_publisher(topic.type, topic.name, topic.qos)
        message = topic.type(**CONTENTS.get(topic.name, {}))
        self._message = serialize_message(message) if which == 'bytes' else message
        self._period = PERIODS.get(topic.name, 0.0)
        self._due = monotonic()

    def publish(self, now: float) -> None:
        """Publish it where it is due."""
        if now >= self._due:
            self._due += self._period
            self._publisher.publish(self._message)


outlets = [] if odom else [Outlet(topic) for topic in PUBLISHED]


def tell(frame: bytes) -> None:
    """Publish what a frame asks for."""
    right, left = layout.unpack(frame)
    if odom is None:
        now = monotonic()
        for outlet in outlets:
            outlet.publish(now)
        return
    message = Odometry()
    message.header.stamp = node.get_clock().now().to_msg()
    message.header.frame_id = 'odom'
    message.child_frame_id = 'base_footprint'
    message.twist.twist.linear.x = (right + left) / 2000
    odom.publish(message)


def look() -> None:
    """Tell of the frames that have come."""
    while port.in_waiting >= layout.size:
        tell(port.read(layout.size))


def read() -> None:
    """Wait for frames, and tell of each."""
    while True:
        tell(port.read(layout.size))


node.create_subscription(Twist, 'cmd_vel', lambda _: None, 1)
signal.signal(signal.SIGTERM, signal.SIG_DFL)
port.write(bytes.fromhex(sys.argv[3]))
if which == 'timer':
    node.create_timer(SLOT, look)
else:
    threading.Thread(target=read, daemon=True).start()
rclpy.spin(node, EventsExecutor() if which == 'events' else None)
