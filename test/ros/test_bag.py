# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A bag of the recorder has the form that rosbag2 of Jazzy reads and plays."""

from pathlib import Path
import re
from typing import Any

import pytest
from rclpy.topic_endpoint_info import TopicEndpointInfo
import yaml

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from rosbags.rosbag2 import Reader

from create_oi_ros.ros.bags import Recorder
from create_oi_ros.ros.topics import ALL_TOPICS, LATCHED, PUBLISHED
from support.pages import blocks, ROOT
from support.ros import scene

LATCHING = {f'/{topic.name}' for topic in ALL_TOPICS if topic.qos is LATCHED}
DESCRIBED = '/robot_description'
FOREVER = {'sec': 9223372036, 'nsec': 854775807}
OFFERED = {
    'history': 'keep_last', 'reliability': 'reliable', 'durability': 'volatile',
    'deadline': FOREVER, 'lifespan': FOREVER, 'liveliness': 'automatic',
    'liveliness_lease_duration': FOREVER, 'avoid_ros_namespace_conventions': False}
"""QoS as rosbag2 of Jazzy parses it (convert<rclcpp::QoS>), without the depth."""


NAMES = [f'/{topic.name.lstrip("/")}' for topic in PUBLISHED]


class Walk:
    """A bag that was recorded from the driver, and what the driver offered meanwhile."""

    def __init__(self, folder: Path) -> None:
        self.bag = folder / 'walk'
        with scene(folder) as made:
            recorder = Recorder(made.ros.node, self.bag)
            recorder.describe()
            made.node(made.robot().link)
            made.ros.until(lambda: recorder.counts['/odom'] > 100, 'two seconds')
            made.ros.until(lambda: LATCHING <= set(recorder.counts), 'every latched topic')
            self.offered: dict[str, list[TopicEndpointInfo]] = {
                name: made.ros.node.get_publishers_info_by_topic(name) for name in NAMES}
            recorder.close()
            self.messages = recorder.counts.total()

    @property
    def metadata(self) -> Any:
        """The contents of metadata.yaml."""
        return yaml.safe_load((self.bag / 'metadata.yaml').read_text())[
            'rosbag2_bagfile_information']


@pytest.fixture(scope='module')
def walk(tmp_path_factory) -> Walk:
    """Return a recorded bag."""
    return Walk(tmp_path_factory.mktemp('walk'))


def test_the_metadata_is_what_rosbag2_of_jazzy_parses(walk):
    bag = walk.metadata
    assert (bag['version'], bag['storage_identifier']) == (9, 'mcap')
    assert bag['relative_file_paths'] == ['walk_0.mcap'] == [each['path'] for each in bag['files']]
    assert (bag['compression_format'], bag['compression_mode'], bag['custom_data']) == (
        '', '', None)
    assert isinstance(bag['ros_distro'], str)
    for times in (bag, *bag['files']):
        assert times['duration']['nanoseconds'] > 10**9
        assert times['starting_time']['nanoseconds_since_epoch'] > 10**18
        assert times['message_count'] == walk.messages
    depths = {f'/{topic.name.lstrip("/")}': topic.qos.depth for topic in ALL_TOPICS}
    depths |= {'/cmd_vel': 10, DESCRIBED: 1, '/tf_static': 1}
    for each in bag['topics_with_message_count']:
        topic = each['topic_metadata']
        latched = topic['name'] in LATCHING | {DESCRIBED, '/tf_static'}
        assert topic['offered_qos_profiles'] == [{
            **OFFERED, 'depth': depths.pop(topic['name']),
            'durability': 'transient_local' if latched else 'volatile'}]
        assert topic['serialization_format'] == 'cdr' and each['message_count'] >= 0
        assert re.fullmatch('RIHS01_[0-9a-f]{64}', topic['type_description_hash'])
    assert not depths


def test_the_file_alone_has_the_same_metadata_of_its_topics(walk):
    """`ros2 bag play` also takes a single .mcap file, without metadata.yaml."""
    with Reader(walk.bag) as reader, Reader(walk.bag / 'walk_0.mcap') as alone:
        folder, file = (
            {each.topic: (each.msgtype, each.msgcount, each.ext) for each in bag.connections}
            for bag in (reader, alone))
    assert folder == file and len(file) == len(ALL_TOPICS) + 3


def test_types_and_qos_in_the_bag_are_those_that_the_driver_offers(walk):
    topics = {each['topic_metadata']['name']: each['topic_metadata']
              for each in walk.metadata['topics_with_message_count']}
    for name in NAMES:
        offered, = walk.offered[name]
        assert str(offered.topic_type_hash) == topics[name]['type_description_hash']
        wanted, = topics[name]['offered_qos_profiles']
        assert offered.qos_profile.durability.name.lower() == wanted['durability']
        assert offered.qos_profile.reliability.name.lower() == wanted['reliability']


def test_the_program_in_the_documentation_reads_the_bag_and_draws_its_track(walk, monkeypatch):
    program, = (block.text for block in blocks(ROOT / 'docs/recording.md')
                if block.language == 'python')
    monkeypatch.setenv('MPLBACKEND', 'agg')
    monkeypatch.chdir(walk.bag.parent)
    space: dict[str, Any] = {}
    exec(program, space)
    assert len(space['track']) > 100
    assert (walk.bag.parent / 'track.png').read_bytes().startswith(b'\x89PNG')
