# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Everything that the node publishes can be recorded, and read with the bag alone."""

from pathlib import Path

import pytest
from rclpy.serialization import deserialize_message

from create_oi_ros.ros.topics import PUBLISHED, Topic, type_name
from support.ros import Scene, scene
from support.source import ROOT

rosbag2 = pytest.importorskip('rosbags.rosbag2', reason='no rosbags here: see tools/pins.txt')
highlevel = pytest.importorskip('rosbags.highlevel')
typesys = pytest.importorskip('rosbags.typesys')

Recording = dict[str, list[bytes]]


def full_name(topic: Topic) -> str:
    """Return the type name of a topic as a bag has it."""
    package, name = type_name(topic.type).split('/')
    return f'{package}/msg/{name}'


def typestore():
    """Return the message definitions of ROS 2 Jazzy, and ours from their source files."""
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    for path in sorted((ROOT / 'msg_defs' / 'msg').glob('*.msg')):
        store.register(typesys.get_types_from_msg(
            path.read_text(), f'create_oi_msgs/msg/{path.stem}'))
    return store


@pytest.fixture(scope='module')
def stage(tmp_path_factory):
    """Return a scene with a robot and its node."""
    with scene(tmp_path_factory.mktemp('recording')) as made:
        made.node(made.robot().link)
        yield made


@pytest.fixture(scope='module')
def recording(stage: Scene) -> Recording:
    """Return serialized messages of every topic, received as a recorder does."""
    taken: Recording = {topic.name: [] for topic in PUBLISHED}
    for topic in PUBLISHED:
        stage.ros.node.create_subscription(
            topic.type, topic.name, taken[topic.name].append, topic.qos, raw=True)
    stage.ros.until(lambda: all(taken.values()), 'a message on every topic')
    return taken


def write(path: Path, recording: Recording, storage) -> None:
    """Write a bag with the definitions of its types."""
    store = typestore()
    with rosbag2.Writer(path, version=9, storage_plugin=storage) as writer:
        for topic in PUBLISHED:
            connection = writer.add_connection(topic.name, full_name(topic), typestore=store)
            for time, message in enumerate(recording[topic.name]):
                writer.write(connection, time, message)


@pytest.mark.parametrize('storage', list(rosbag2.StoragePlugin), ids=lambda each: each.name)
def test_every_message_is_read_back_with_the_definitions_in_the_bag(
    tmp_path, recording, storage,
):
    write(tmp_path / 'bag', recording, storage)
    types = {topic.name: topic.type for topic in PUBLISHED}
    read: Recording = {topic.name: [] for topic in PUBLISHED}
    with highlevel.AnyReader([tmp_path / 'bag']) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            meant = deserialize_message(bytes(raw), types[connection.topic])
            for name in meant.get_fields_and_field_types():
                assert hasattr(message, name)
            stamped = message.transforms[0] if connection.topic == '/tf' else message
            assert stamped.header.stamp.sec > 0
            read[connection.topic].append(bytes(raw))
    assert read == recording


def test_the_definitions_in_the_bag_are_those_on_the_wire(stage, recording):
    store = typestore()
    for topic in PUBLISHED:
        name = topic.name if topic.name.startswith('/') else f'/{topic.name}'
        publisher, = stage.ros.node.get_publishers_info_by_topic(name)
        assert str(publisher.topic_type_hash) == store.hash_rihs01(full_name(topic)), name
