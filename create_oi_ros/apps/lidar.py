# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_lidar`: publish the scans of a simulated robot's lidar, until Ctrl-C."""

import argparse
from collections.abc import Iterator
from contextlib import suppress
import json
from math import inf, pi, tau
from pathlib import Path
import socket
import sys
from threading import Event
import time
from typing import Any

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from tf2_msgs.msg import TFMessage

from ..ros.messages import beside
from ..ros.process import call_on_signal, ros_executor, spin_ready
from ..ros.topics import LATCHED, MODE
from ..ros.waiting import say_if_waiting

FRAME = 'laser'
HEIGHT = 0.12
"""Metres of the lidar above the floor."""
START_TIME, RETRY_INTERVAL = 10.0, 0.1
"""Seconds in which the simulator must have started, and between two attempts to connect."""


class LidarNode(Node):
    """Publishes `scan`, and where the lidar is on the robot."""

    def __init__(self, frame: str = '', base_frame: str = '') -> None:
        """Take the frames that are not given from the driver, which names its own in `mode`."""
        super().__init__('create_lidar')
        self._wanted, self._base_frame, self.frame = frame, '', ''
        self._newest = 0
        self._scans = self.create_publisher(LaserScan, 'scan', qos_profile_sensor_data)
        self._transforms = self.create_publisher(TFMessage, '/tf_static', LATCHED)
        if base_frame:
            self._mount(base_frame)
        else:
            self.create_subscription(Mode, MODE.name, self._on_mode, MODE.qos)

    def _on_mode(self, mode: Mode) -> None:
        self._mount(mode.header.frame_id)

    def _mount(self, base_frame: str) -> None:
        """Publish where the lidar is on a robot with this frame, unless it is there already."""
        if base_frame == self._base_frame:
            return
        self._base_frame = base_frame
        self.frame = self._wanted or beside(base_frame, FRAME)
        self._transforms.publish(TFMessage(transforms=[TransformStamped(
            header=Header(frame_id=base_frame, stamp=self.get_clock().now().to_msg()),
            child_frame_id=self.frame, transform=Transform(translation=Vector3(z=HEIGHT)))]))

    def publish(self, scan: dict[str, Any]) -> None:
        """Publish a turn, stamped at its middle; its beams count as measured at once."""
        if not self.frame:
            return
        stamp = self.get_clock().now().nanoseconds - round(1e9 * scan['age'])
        if 0 <= self._newest - stamp < 1e9 * scan['turn']:
            return  # the one before was late, and this one is not: their order would be wrong
        self._newest = stamp
        ranges = [inf if each is None else each for each in scan['ranges']]
        self._scans.publish(LaserScan(
            header=Header(frame_id=self.frame, stamp=Time(nanoseconds=stamp).to_msg()),
            ranges=ranges, angle_min=-pi, angle_max=pi - tau / len(ranges),
            angle_increment=tau / len(ranges),
            scan_time=scan['turn'], range_min=scan['nearest'], range_max=scan['farthest']))


def connect(connection: socket.socket, path: Path, ended: Event) -> None:
    """Connect to a simulator that may still start; OSError names its control socket."""
    until = time.monotonic() + START_TIME
    while not ended.is_set():
        try:
            return connection.connect(str(path))
        except OSError as error:
            if time.monotonic() > until:
                raise OSError(error.errno, error.strerror, str(path)) from None
            ended.wait(RETRY_INTERVAL)


def scans(connection: socket.socket) -> Iterator[dict[str, Any]]:
    """Yield one scan after the other, until the connection is closed."""
    with connection.makefile('rw') as lines:
        while True:
            lines.write('scan\n')
            lines.flush()
            answer = lines.readline()
            if not answer.startswith('ok '):
                return
            yield json.loads(answer.removeprefix('ok '))


def main() -> int:
    """Run until Ctrl-C or the end of the simulator; OSError: there is none."""
    parser = argparse.ArgumentParser(
        prog='create_lidar', description=__doc__, epilog='in a namespace: --ros-args -r __ns:=/r1')
    parser.add_argument('--control', type=Path, required=True, metavar='PATH',
                        help='control socket of create_sim')
    parser.add_argument('--frame', default='', help=(
        f"of the scans (default: {FRAME}, with the prefix of the robot's frame)"))
    parser.add_argument('--base-frame', default='', help=(
        "the robot's frame (default: base_frame of the driver)"))
    options = parser.parse_args(remove_ros_args(sys.argv)[1:])
    connection, ended = socket.socket(socket.AF_UNIX), Event()

    def end() -> None:
        ended.set()
        with suppress(OSError):  # it is not connected
            connection.shutdown(socket.SHUT_RDWR)
    call_on_signal(end)
    with connection, ros_executor() as executor:
        node = LidarNode(options.frame, options.base_frame)
        executor.add_node(node)
        connect(connection, options.control, ended)
        say_if_waiting(
            node, 'a driver, whose frame it shares,', lambda: not node.frame,
            lambda why: print(f'create_lidar: {why}', file=sys.stderr, flush=True))
        with suppress(OSError):  # the simulator has ended
            for scan in scans(connection):
                spin_ready(executor)
                node.publish(scan)
    return 0
