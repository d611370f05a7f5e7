"""Writes all topics of the driver, and its commands, to a bag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import time
from typing import TYPE_CHECKING

from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ..interface import type_name
from ..report.bag import definitions
from ..topics import PUBLISHED

if TYPE_CHECKING:
    from rosbags.interfaces import Qos


class Recorder:
    """Records from its making until `close`."""

    def __init__(self, node: Node, folder: Path) -> None:
        """Create a bag in a folder that is not there yet."""
        from rosbags.rosbag2 import StoragePlugin, Writer
        self._node = node
        self._store = definitions()
        self._writer = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        for topic in PUBLISHED:
            self._record(topic.name, topic.type, topic.qos)
        self._record('cmd_vel', Twist, QoSProfile(depth=10))

    def _record(self, name: str, type_: type, qos: QoSProfile) -> None:
        package, kind = type_name(type_).split('/')
        connection = self._writer.add_connection(
            self._node.resolve_topic_name(name), f'{package}/msg/{kind}', typestore=self._store,
            offered_qos_profiles=[written(qos)])
        write: Callable[[bytes], None] = lambda raw: self._writer.write(  # noqa: E731
            connection, time.time_ns(), raw)
        deep = QoSProfile(depth=1000, durability=qos.durability)
        self._node.create_subscription(type_, name, write, deep, raw=True)

    def close(self) -> None:
        """Finish the bag, so that it can be read."""
        self._writer.close()


def written(qos: QoSProfile) -> Qos:
    """Return a quality of service as a bag has it, for `ros2 bag play` to offer it again."""
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )
    latched = qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
    reliable = qos.reliability != ReliabilityPolicy.BEST_EFFORT
    never = QosTime(9223372036, 854775807)
    return Qos(
        QosHistory.KEEP_LAST, qos.depth,
        QosReliability.RELIABLE if reliable else QosReliability.BEST_EFFORT,
        QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        never, never, QosLiveliness.AUTOMATIC, never, False)
