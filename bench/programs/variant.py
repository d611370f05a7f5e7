# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The floor with one change: `variant.py WHICH PORT CALL LAYOUT`. Otherwise as floor.py.

- `timer`: an rclpy timer looks for frames every 15 ms; there is no reading thread;
- `events`: the events executor of `rclpy.experimental` replaces the default one;
- `messages`: everything that the node publishes is published, at the node's rates. The messages
  are made once and never filled, so this is the cost of publishing alone;
- `bytes`: the same, and the messages are serialized once, too.
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
from odom_message import odom_message
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.serialization import serialize_message
import serial

from create_oi_ros.oi import SLOT
from create_oi_ros.ros.topics import DIAGNOSTICS, JOINT_STATES, MODE, PUBLISHED, SENSOR_TOPICS, TF

MOST = 120
"""Limit of processor time, seconds, should it never sleep."""
SENSOR_PERIOD = 0.05
"""Seconds; the default of the node's parameter `sensor_rate`."""
PERIODS = {MODE.name: inf, DIAGNOSTICS.name: 1.0} | {
    topic.name: topic.period or SENSOR_PERIOD for topic in SENSOR_TOPICS}
"""Seconds between two messages of a topic; topics not listed are published with every frame."""
CONTENTS: dict[str, dict[str, Any]] = {
    TF.name: {'transforms': [TransformStamped()]},
    JOINT_STATES.name: {
        'name': ['left_wheel_joint', 'right_wheel_joint'], 'position': [0.0] * 2,
        'velocity': [0.0] * 2}}
"""Fields of messages that must not be empty."""

which = sys.argv[1]
resource.setrlimit(resource.RLIMIT_CPU, (MOST, MOST))
port = serial.Serial(sys.argv[2], 57600, exclusive=True)
layout = struct.Struct(sys.argv[4])
rclpy.init()
node = rclpy.create_node('floor')
odom = node.create_publisher(Odometry, 'odom', 10) if which in ('timer', 'events') else None


class Repeater:
    """Publishes one message on one topic again and again."""

    def __init__(self, topic: Any) -> None:
        """Make the publisher and the message."""
        self._publisher = node.create_publisher(topic.type, topic.name, topic.qos)
        message = topic.type(**CONTENTS.get(topic.name, {}))
        self._message = serialize_message(message) if which == 'bytes' else message
        self._period = PERIODS.get(topic.name, 0.0)
        self._due = monotonic()

    def publish(self, now: float) -> None:
        """Publish the message if it is due."""
        if now >= self._due:
            self._due += self._period
            self._publisher.publish(self._message)


repeaters = [] if odom else [Repeater(topic) for topic in PUBLISHED]


def publish(frame: bytes) -> None:
    """Publish what is due at a frame."""
    speeds = layout.unpack(frame)
    if odom is None:
        now = monotonic()
        for repeater in repeaters:
            repeater.publish(now)
    else:
        odom.publish(odom_message(node, *speeds))


def read_waiting() -> None:
    """Publish for each frame that has arrived."""
    while port.in_waiting >= layout.size:
        publish(port.read(layout.size))


def read() -> None:
    """Wait for frames; publish for each."""
    while True:
        publish(port.read(layout.size))


node.create_subscription(Twist, 'cmd_vel', lambda _: None, 1)
signal.signal(signal.SIGTERM, signal.SIG_DFL)
port.write(bytes.fromhex(sys.argv[3]))
if which == 'timer':
    node.create_timer(SLOT, read_waiting)
else:
    threading.Thread(target=read, daemon=True).start()
if which == 'events':
    executor = EventsExecutor()
    executor.add_node(node)
    while True:  # without a timeout this executor does not sleep
        executor.spin_once(timeout_sec=1000.0)
rclpy.spin(node)
