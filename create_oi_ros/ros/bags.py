# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Bags: what a damaged one causes, and a recorder of the driver's topics and its commands.

The library `rosbags` reads and writes them without an installed rosbag2.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
import os
from pathlib import Path
import struct
import sys
import time
from typing import TypeVar

from ament_index_python.packages import get_package_share_directory, PackageNotFoundError
from geometry_msgs.msg import Twist
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags import interfaces as bag
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore
from std_msgs.msg import String

from tf2_msgs.msg import TFMessage

from .programs import UserError
from .topics import ALL_TOPICS, CMD_VEL, LATCHED, type_name

Item = TypeVar('Item')
DESCRIPTION = 'robot_description'
SAVED = 1.0
"""Seconds between two writes to the file; what `kill -9` or a full disk loses at most."""


class BagError(UserError):
    """A bag cannot be read or is not of this driver; the message is one sentence."""


class DamageError(Exception):
    """The content of a bag cannot be read; the message is that of the library."""


FAULTS = (
    AssertionError, AttributeError, EOFError, LookupError, MemoryError, OSError, OverflowError,
    RuntimeError, TypeError, ValueError, struct.error)
"""What Python raises when damaged bytes are read."""
LIBRARY_FAULTS = {
    'backports.zstd': 'ZstdError', 'compression.zstd': 'ZstdError', 'sqlite3': 'Error',
    'rosbags.rosbag2': 'ReaderError', 'rosbags.serde': 'SerdeError',
    'rosbags.typesys': 'TypesysError', 'yaml': 'YAMLError'}
"""Exceptions of libraries, by module."""


def faults() -> tuple[type[Exception], ...]:
    """Return the exceptions that a broken file causes in the libraries that are loaded."""
    return (*FAULTS, *(getattr(sys.modules[module], name)
                       for module, name in LIBRARY_FAULTS.items() if module in sys.modules))


@contextmanager
def reading() -> Iterator[None]:
    """Turn what a broken file causes into DamageError."""
    try:
        yield
    except faults() as error:
        raise DamageError(
            ' '.join(str(error).split())[:200] or type(error).__name__) from error


def guarded(items: Iterable[Item]) -> Iterator[Item]:
    """Yield what is read, under `reading`; exceptions of the caller are not changed."""
    with reading():
        yield from items


def definitions() -> Typestore:
    """Return the message definitions of ROS 2 Jazzy and ours, installed or in the repository."""
    store = get_typestore(Stores.ROS2_JAZZY)
    try:
        share = Path(get_package_share_directory('create_oi_msgs'))
    except PackageNotFoundError:
        share = Path(__file__).parents[2] / 'msg_defs'
    for path in sorted(share.glob('msg/*.msg')):
        store.register(get_types_from_msg(path.read_text(), f'create_oi_msgs/msg/{path.stem}'))
    return store


class Recorder:
    """Records until `close`; OSError: the disk is full, or the folder cannot be written."""

    def __init__(self, node: Node, folder: Path, velocity: type = Twist) -> None:
        """Create a bag in a new folder; `velocity` is the type of cmd_vel."""
        self._node = node
        self._store = definitions()
        self._writer = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        assert isinstance(self._writer.storage, McapWriter)
        self._file = self._writer.storage
        # The name that `ros2 bag reindex` looks for.
        self._file.path = self._file.path.rename(folder / f'{folder.name}_0.mcap')
        self.counts: Counter[str] = Counter()
        """Messages recorded, by topic."""
        self.saved = 0
        """Messages that are in the file already, of all topics."""
        for topic in ALL_TOPICS:
            self._record(topic.name, topic.type, topic.qos)
        self._record(CMD_VEL, velocity, QoSProfile(depth=10))
        # Both published by robot_state_publisher, if it runs.
        self._description = self._record(DESCRIPTION, String, LATCHED)
        self._record('/tf_static', TFMessage, LATCHED)
        self._saving = node.create_timer(SAVED, self._save)

    @property
    def size(self) -> int:
        """Bytes in the bag's file."""
        return self._file.path.stat().st_size

    @property
    def topics(self) -> list[str]:
        return [connection.topic for connection in self._writer.connections]

    def describe(self) -> None:
        """Write the model of the robot, for a bag without robot_state_publisher."""
        model = Path(get_package_share_directory('create_oi_ros')) / 'urdf' / 'create.urdf'
        self._write(self._description, serialize_message(String(data=model.read_text('utf-8'))))

    def _record(self, name: str, type_: type, qos: QoSProfile) -> bag.Connection:
        package, kind = type_name(type_).split('/')
        connection = self._writer.add_connection(
            self._node.resolve_topic_name(name), f'{package}/msg/{kind}', typestore=self._store,
            offered_qos_profiles=[bag_qos(qos)])
        # A best-effort subscription hears every publisher of commands.
        reliability = (ReliabilityPolicy.BEST_EFFORT if name == CMD_VEL
                       else ReliabilityPolicy.RELIABLE)
        deep = QoSProfile(depth=1000, durability=qos.durability, reliability=reliability)
        write: Callable[[bytes], None] = lambda raw: self._write(connection, raw)  # noqa: E731
        self._node.create_subscription(type_, name, write, deep, raw=True)
        return connection

    def _write(self, connection: bag.Connection, raw: bytes) -> None:
        self._writer.write(connection, time.time_ns(), raw)
        self.counts[connection.topic] += 1

    def _save(self) -> None:
        """Write what has arrived as a chunk of its own: readers recover whole chunks only."""
        if self._file.chunk.msgs:
            with self._whole_chunks():
                self._file.close_chunk()
                self._file.bio.flush()
            self.saved = self.counts.total()

    @contextmanager
    def _whole_chunks(self) -> Iterator[None]:
        """When the disk is full, close the file after its last whole chunk."""
        whole = self._file.bio.tell()
        try:
            yield
        except OSError:
            if self._writer.storage is not None:
                with suppress(OSError):  # expected: the rest does not fit either
                    self._writer.abort()
                os.truncate(self._file.path, whole)
            raise

    def close(self) -> None:
        """Close the bag; only then is it complete."""
        self._node.destroy_timer(self._saving)
        if self._writer.storage is not None:
            self._save()
            with self._whole_chunks():
                self._writer.close()


def bag_qos(qos: QoSProfile) -> bag.Qos:
    """Return a quality of service in the form of a bag; `ros2 bag play` offers it again."""
    never = bag.QosTime(9223372036, 854775807)
    return bag.Qos(  # both number the policies as the middleware does
        bag.QosHistory.KEEP_LAST, qos.depth, bag.QosReliability(qos.reliability),
        bag.QosDurability(qos.durability), never, never, bag.QosLiveliness.AUTOMATIC, never, False)
