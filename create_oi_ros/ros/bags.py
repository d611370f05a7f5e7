# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A recorder of the driver's topics and its commands, and the types of their messages.

The libraries `mcap` and `rosbags` write bags without an installed rosbag2.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
import os
from pathlib import Path
import time
from typing import Any

from ament_index_python.packages import get_package_share_directory
from mcap.writer import CompressionType, Writer
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore
from std_msgs.msg import String
import yaml

from tf2_msgs.msg import TFMessage

from .topics import ALL_TOPICS, CMD_VEL, LATCHED, type_name
from .velocity import COMMANDS, driver_type

SAVED = 1.0
"""Seconds between two writes to the file; what `kill -9` or a full disk loses at most."""
FITTED = 0.2
"""Seconds between two looks whether the publishers have another type or QoS."""
FOREVER = {'sec': 9223372036, 'nsec': 854775807}
METADATA_VERSION = 9
"""Of rosbag2 in Jazzy."""


def definitions() -> Typestore:
    """Return the message definitions of ROS 2 Jazzy and ours."""
    store = get_typestore(Stores.ROS2_JAZZY)
    share = Path(get_package_share_directory('create_oi_msgs'))
    for path in sorted(share.glob('msg/*.msg')):
        store.register(get_types_from_msg(path.read_text(), f'create_oi_msgs/msg/{path.stem}'))
    return store


@dataclass
class Recorded:
    """A topic of a recording."""

    name: str
    types: Mapping[str, Any]
    """Message types that it may have, by their full names."""
    type: Any
    """The one that is subscribed to."""
    qos: QoSProfile
    """What its usual publisher offers."""
    reliability: ReliabilityPolicy
    subscription: Subscription | None = None
    channel: int | None = None
    """Its number in the file; None before the first message."""
    count: int = 0
    """Messages that were recorded."""


class Recorder:
    """Records until `close`; OSError: the disk is full, or the folder cannot be written."""

    def __init__(self, node: Node, folder: Path) -> None:
        """Create a bag in a new folder, and subscribe."""
        self._node, self._folder = node, folder
        self._definitions = definitions()
        folder.mkdir(parents=True)
        self._path = folder / f'{folder.name}_0.mcap'  # what `ros2 bag reindex` looks for
        self._stream = self._path.open('xb')
        self._file = Writer(self._stream, compression=CompressionType.NONE)
        self._file.start('ros2')
        self._began = self._ended = 0
        """Times of the first and the newest message, ns."""
        self._whole = 0
        """Bytes of the file that end with a whole chunk."""
        self.topics = [self._recorded(each.name, (each.type,), each.qos) for each in ALL_TOPICS]
        # Best effort, which gets what any publisher of commands sends.
        self.topics.append(self._recorded(
            CMD_VEL, COMMANDS.values(), QoSProfile(depth=10), ReliabilityPolicy.BEST_EFFORT))
        # Both published by robot_state_publisher, if it runs.
        self.topics += [self._recorded('robot_description', (String,), LATCHED),
                        self._recorded('/tf_static', (TFMessage,), LATCHED)]
        self._timers = [node.create_timer(SAVED, self._save), node.create_timer(FITTED, self._fit)]
        self._fit()

    @property
    def counts(self) -> Counter[str]:
        """Messages recorded, by topic."""
        return Counter({each.name: each.count for each in self.topics if each.count})

    @property
    def size(self) -> int:
        """Bytes in the bag's file."""
        return self._path.stat().st_size

    def _recorded(self, name: str, types: Iterable[type], qos: QoSProfile,
                  reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE) -> Recorded:
        by_name = {full_name(each): each for each in types}
        return Recorded(self._node.resolve_topic_name(name), by_name,
                        next(iter(by_name.values())), qos, reliability)

    def _fit(self) -> None:
        """Subscribe, anew where publishers have another type, or are best effort."""
        for topic in self.topics:
            found = [each for each in self._node.get_publishers_info_by_topic(topic.name)
                     if each.topic_type in topic.types]
            type_ = self._type_of(topic, {topic.types[each.topic_type] for each in found})
            reliability = topic.reliability
            if any(each.qos_profile.reliability is ReliabilityPolicy.BEST_EFFORT
                   for each in found):
                reliability = ReliabilityPolicy.BEST_EFFORT
            if topic.subscription is None or (type_, reliability) != (
                    topic.type, topic.reliability):
                topic.type, topic.reliability = type_, reliability
                self._subscribe(topic)

    def _type_of(self, topic: Recorded, offered: set[Any]) -> Any:
        """Return the type to record: what is published; of two, what the driver takes."""
        if topic.count:  # a topic of a bag has one type
            for late in offered - {topic.type}:
                self._node.get_logger().warning(
                    f'{topic.name} is published as {type_name(late)} now, which is not recorded: '
                    f'a bag has one type of a topic, in this one {type_name(topic.type)}. Start '
                    'another recording', once=True)
            return topic.type
        if len(offered) == 1:
            return next(iter(offered))
        return (driver_type(self._node) or topic.type) if offered else topic.type

    def _subscribe(self, topic: Recorded) -> None:
        if topic.subscription is not None:
            self._node.destroy_subscription(topic.subscription)
            topic.subscription = None
        deep = QoSProfile(depth=1000, durability=topic.qos.durability,
                          reliability=topic.reliability)
        write: Callable[[bytes], None] = partial(self._write, topic)
        with suppress(RuntimeError):  # the executor still has the other type: tried again
            topic.subscription = self._node.create_subscription(
                topic.type, topic.name, write, deep, raw=True,
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False))

    def _write(self, topic: Recorded, raw: bytes) -> None:
        with self._whole_chunks():
            if topic.channel is None:
                topic.channel = self._channel(topic)
            now = time.time_ns()
            self._file.add_message(topic.channel, now, raw, now)
        self._began = self._began or now
        self._ended = now
        topic.count += 1

    def _channel(self, topic: Recorded) -> int:
        """Register a topic in the file."""
        name = full_name(topic.type)
        definition, _ = self._definitions.generate_msgdef(name, ros_version=2)
        schema = self._file.register_schema(name, 'ros2msg', definition.encode())
        return self._file.register_channel(topic.name, 'cdr', schema, {
            'offered_qos_profiles': yaml.safe_dump([bag_qos(topic.qos)])})

    def _save(self) -> None:
        """Write what has arrived as a chunk of its own: readers recover whole chunks only."""
        with self._whole_chunks():
            self._file.flush()
        self._whole = self._stream.tell()

    @contextmanager
    def _whole_chunks(self) -> Iterator[None]:
        """When the disk is full, close the file after its last whole chunk."""
        try:
            yield
        except OSError:
            with suppress(OSError):  # expected: the rest does not fit either
                self._stream.close()
            os.truncate(self._path, self._whole)
            raise

    def close(self) -> None:
        """Close the bag; only then is it complete."""
        for timer in self._timers:
            self._node.destroy_timer(timer)
        if self._stream.closed:  # the disk was full
            return
        self._save()
        metadata = self._metadata()
        with self._whole_chunks():
            self._file.add_metadata('rosbag2', {'serialized_metadata': yaml.safe_dump(metadata)})
            self._file.finish()
            self._stream.close()
        (self._folder / 'metadata.yaml').write_text(
            yaml.safe_dump({'rosbag2_bagfile_information': metadata}))

    def _metadata(self) -> dict[str, Any]:
        """Return what rosbag2 reads of a bag."""
        times = {'starting_time': {'nanoseconds_since_epoch': self._began},
                 'duration': {'nanoseconds': self._ended - self._began},
                 'message_count': self.counts.total()}
        topics = [{'message_count': each.count, 'topic_metadata': {
            'name': each.name, 'type': full_name(each.type), 'serialization_format': 'cdr',
            'offered_qos_profiles': [bag_qos(each.qos)],
            'type_description_hash': self._definitions.hash_rihs01(full_name(each.type)),
        }} for each in self.topics if each.count]
        return {'version': METADATA_VERSION, 'storage_identifier': 'mcap', **times,
                'relative_file_paths': [self._path.name],
                'files': [{'path': self._path.name, **times}],
                'topics_with_message_count': topics, 'compression_format': '',
                'compression_mode': '', 'custom_data': None, 'ros_distro': 'jazzy'}


def full_name(type_: type) -> str:
    """Return the name of a message type as ROS has it: geometry_msgs/msg/Twist."""
    return type_name(type_).replace('/', '/msg/')


def bag_qos(qos: QoSProfile) -> dict[str, Any]:
    """Return a quality of service in the form of a bag; `ros2 bag play` offers it again."""
    return {'history': 'keep_last', 'depth': qos.depth,
            'reliability': qos.reliability.name.lower(), 'durability': qos.durability.name.lower(),
            'deadline': FOREVER, 'lifespan': FOREVER, 'liveliness': 'automatic',
            'liveliness_lease_duration': FOREVER, 'avoid_ros_namespace_conventions': False}
