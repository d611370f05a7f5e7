# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Publishes the topic `contacts`: what the robot feels, as a point cloud for costmaps."""

from math import inf
import struct

from builtin_interfaces.msg import Time
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2, PointField

from ..driver import Moved
from ..driver.contacts import Contacts
from . import messages, topics
from .parameters import Parameters
from .publishing import CHECK_INTERVAL, publisher

HEIGHT = 0.05
"""Metres above the floor at which the points are: between the heights of an obstacle layer."""
POINT = struct.Struct('<fff')
EMPTY_PERIOD = 1.0
"""Seconds between two clouds without points."""


class ContactCloud:
    """Fills the cloud and publishes it, frame by frame."""

    def __init__(self, node: Node, parameters: Parameters) -> None:
        """Create the publisher."""
        self._publisher = publisher(node, topics.CONTACTS)
        self._contacts = Contacts()
        self._count = 0
        self._due_at = self._check_at = -inf
        self._wanted = False
        fields = [PointField(name=name, offset=4 * place, datatype=PointField.FLOAT32, count=1)
                  for place, name in enumerate('xyz')]
        self._cloud = PointCloud2(
            header=messages.header(parameters.base_frame, Time()), height=1, fields=fields,
            is_bigendian=False, point_step=POINT.size, is_dense=True)

    def publish(self, moved: Moved, nanoseconds: int, parameters: Parameters) -> None:
        """Take a frame in, with its stamp in the node's time; publish what is felt when due."""
        stamp = moved.stamp
        if stamp >= self._check_at:
            self._check_at = stamp + CHECK_INTERVAL
            self._wanted = self._publisher.get_subscription_count() > 0
        if not self._wanted:
            return
        self._contacts.update(
            moved.readings, moved.estimate, stamp, parameters.contact_persistence)
        points = self._contacts.points(moved.estimate)
        if len(points) == self._count and stamp < self._due_at:
            return
        self._count = len(points)
        self._due_at = stamp + (1 / parameters.sensor_rate if points else EMPTY_PERIOD)
        self._cloud.header.stamp = messages.time(nanoseconds)
        self._cloud.width, self._cloud.row_step = len(points), len(points) * POINT.size
        self._cloud.data = b''.join(POINT.pack(x, y, HEIGHT) for x, y in points)
        self._publisher.publish(self._cloud)
