# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A bag that is played gives the same messages, recording and report as the robot did.

`support/player.py` plays it, because the ROS from wheels has no `ros2 bag play`.
"""

from collections import defaultdict
from functools import partial
from pathlib import Path
import re

from create_oi_msgs.srv import SetMode
from nav_msgs.msg import Odometry
import pytest
from rclpy.serialization import deserialize_message
from std_msgs.msg import String
import yaml

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from rosbags.rosbag2 import Reader

from create_oi_ros.apps.demo import tour
from create_oi_ros.apps.demo.pilot import Pilot
from create_oi_ros.apps.report import bag_reader as reading
from create_oi_ros.apps.report.recording import Recording
from create_oi_ros.apps.report.summary import events, summary, warnings
from create_oi_ros.ros.recorder import Recorder
from create_oi_ros.ros.topics import LATCHED, PUBLISHED
from support import player
from support.ros import scene

LATCHING = {f'/{topic.name}' for topic in PUBLISHED if topic.qos is LATCHED}
DESCRIBED = '/robot_description'
LATE = 1.0
"""Seconds by which a replay may lag: time stamps of two recorders are compared."""
SECONDS = re.compile(r'\b(\d+:)?\d+(:\d+)?\.\d s\b')
FOREVER = {'sec': 9223372036, 'nsec': 854775807}
OFFERED = {
    'history': 'keep_last', 'reliability': 'reliable', 'durability': 'volatile',
    'deadline': FOREVER, 'lifespan': FOREVER, 'liveliness': 'automatic',
    'liveliness_lease_duration': FOREVER, 'avoid_ros_namespace_conventions': False}
"""QoS as rosbag2 of Jazzy parses it (convert<rclcpp::QoS>), without the depth."""


def drive(pilot: Pilot, body) -> None:
    """Make the robot do everything that a report shows."""
    tour.hello(pilot)
    pilot.go_to(0.2, 0.0)
    body.force(bump_left=1, play=1)
    pilot.until(lambda: pilot.bumped, 'a bump')
    body.unforce()
    pilot.until(lambda: not pilot.bumped, 'the end of a bump')
    pilot.turn_to(1.0)
    pilot.call(SetMode, 'set_mode', mode=SetMode.Request.PASSIVE)
    pilot.until(lambda: pilot.mode.mode == SetMode.Request.PASSIVE, 'Passive')


@pytest.fixture(scope='module')
def first(tmp_path_factory) -> Path:
    """Return a bag that was recorded from the driver."""
    folder = tmp_path_factory.mktemp('first')
    with scene(folder) as made:
        robot = made.robot()
        recorder = Recorder(made.ros.node, folder / 'walk')
        recorder.describe()
        made.node(robot.link)
        drive(Pilot(made.ros.node, made.ros._executor, lambda: None), robot.body)
        made.ros.until(lambda: LATCHING <= set(recorder.counts), 'every latched topic')
        recorder.close()
    return folder / 'walk'


@pytest.fixture(scope='module')
def second(first, tmp_path_factory) -> Path:
    """Return a bag that was recorded while another process played the first one."""
    folder = tmp_path_factory.mktemp('second')
    with scene(folder) as made:
        recorder = Recorder(made.ros.node, folder / 'walk')
        playing = made.script(Path(player.__file__), str(first))
        recorded = len(player.messages(first))
        made.ros.until(lambda: recorder.counts.total() == recorded, 'all is recorded again')
        assert playing.ended() == 0
        recorder.close()
    return folder / 'walk'


def by_topic(played: list[player.Played]) -> dict[str, list[bytes]]:
    """Return the messages of each topic as bytes, in order."""
    found = defaultdict(list)
    for each in played:
        found[each.topic].append(each.raw)
    return dict(found)


def test_every_message_is_played_byte_for_byte_and_in_order(first, second):
    before, after = by_topic(player.messages(first)), by_topic(player.messages(second))
    assert min(len(before[topic]) for topic in ('/odom', '/tf', '/joint_states')) > 200
    assert LATCHING | {DESCRIBED, '/cmd_vel', '/diagnostics'} <= set(before)
    assert len(before['/mode']) >= 3 and len(before['/song']) >= 3
    # The recorder wrote the model itself, so it lacks the padding that it has on the wire.
    models = [deserialize_message(raw, String).data
              for raw in (*before.pop(DESCRIBED), *after.pop(DESCRIBED))]
    assert models[0].startswith('<?xml') and models[1:] == models[:1]
    assert after == before


def told(recording: Recording) -> dict[str, object]:
    """Return what a report shows, without times, durations, gaps and date."""
    curves = {'odom': ('x', 'y', 'yaw', 'speed', 'turn'), 'commands': ('speed', 'turn'),
              'battery': ('volts', 'amperes', 'charge'), 'link': ('frames', 'damaged', 'garbage')}
    words = defaultdict(list)
    for each in (*events(recording), *warnings(recording)):
        words[each.kind].append(SECONDS.sub('#', each.text))
    # Milliseconds decide the order of two kinds of entry, and whether a pause counts as a gap.
    words.pop('gap', None)
    _, *sentences = (SECONDS.sub('#', line) for line in summary(recording))
    return {
        'name': recording.name, 'robot': recording.robot, 'storage': recording.storage,
        'messages': recording.messages, 'settings': recording.settings,
        'words': dict(sorted(words.items())), 'damage': recording.damage,
        'sentences': [line for line in sentences if 'gap' not in line],
        **{(name, column): list(getattr(recording, name)[column])
           for name, columns in curves.items() for column in columns}}


def test_the_report_is_the_same_but_for_times(first, second, monkeypatch):
    # Else one of two messages that were recorded at the same time may be left out.
    monkeypatch.setattr(reading, 'POINTS', 10**9)
    before, after = (reading.read(bag, lambda part: None) for bag in (first, second))
    said = told(before)
    assert len(said['odom', 'x']) > 200 and len(said['sentences']) >= 5
    assert {'mode', 'song', 'bumper', 'buttons'} <= set(said['words'])
    assert len(said['settings']) > 10
    assert repr(told(after)) == repr(said)  # the charge of a battery may be NaN
    assert after.seconds == pytest.approx(before.seconds, abs=LATE)
    for curve in ('odom', 'commands', 'battery', 'link'):
        assert list(getattr(after, curve).times) == pytest.approx(
            list(getattr(before, curve).times), abs=LATE)
    for kind, spans in before.spans.items():
        for was, is_now in zip(spans.all, after.spans[kind].all, strict=True):
            assert (is_now.start, is_now.end) == pytest.approx((was.start, was.end), abs=LATE)


def test_a_late_subscriber_gets_the_present_state_of_latched_topics(first, tmp_path):
    every = player.messages(first)
    songs = [place for place, each in enumerate(every) if each.topic == '/song']
    # At the second change, so that the present state is not the first one.
    middle = songs[1] + 1
    present = {each.topic: each.raw for each in every[:middle] if each.topic in
               LATCHING | {DESCRIBED}}
    assert set(present) == LATCHING | {DESCRIBED}
    assert present['/song'] != every[songs[0]].raw
    with scene(tmp_path) as made:
        playing = player.Player(first, made.domain)
        try:
            playing.play(every[:middle], paced=False)
            latest: dict[str, bytes] = {}
            for topic in present:
                made.ros.node.create_subscription(
                    playing.publishers[topic].msg_type, topic,
                    lambda raw, topic=topic: latest.update({topic: raw}), LATCHED, raw=True)
            made.ros.until(lambda: latest == present, 'the present state of all that is latched')
        finally:
            playing.close()


def test_a_late_subscriber_gets_no_old_messages_of_other_topics(first, tmp_path):
    odometry = [each for each in player.messages(first) if each.topic == '/odom'][:20]
    with scene(tmp_path) as made:
        playing = player.Player(first, made.domain)
        try:
            playing.play(odometry[:10], paced=False)
            heard: list[bytes] = []
            listens = made.ros.node.create_subscription(
                Odometry, 'odom', heard.append, 10, raw=True)
            made.ros.until(lambda: listens.get_publisher_count()
                           and playing.publishers['/odom'].get_subscription_count())
            playing.play(odometry[10:])
            made.ros.until(lambda: heard and heard[-1] == odometry[-1].raw)
        finally:
            playing.close()
    assert heard == [each.raw for each in odometry[10:]]


def test_the_metadata_is_what_rosbag2_of_jazzy_parses(first):
    metadata = yaml.safe_load((first / 'metadata.yaml').read_text())
    bag = metadata['rosbag2_bagfile_information']
    assert (bag['version'], bag['storage_identifier']) == (9, 'mcap')
    assert bag['relative_file_paths'] == ['walk.mcap'] == [each['path'] for each in bag['files']]
    assert (bag['compression_format'], bag['compression_mode'], bag['custom_data']) == (
        '', '', None)
    assert isinstance(bag['ros_distro'], str)
    for times in (bag, *bag['files']):
        assert times['duration']['nanoseconds'] > 10**9
        assert times['starting_time']['nanoseconds_since_epoch'] > 10**18
        assert times['message_count'] == len(player.messages(first))
    depths = {f'/{topic.name.lstrip("/")}': topic.qos.depth for topic in PUBLISHED}
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


def test_the_file_alone_has_the_same_metadata_of_its_topics(first):
    """`ros2 bag play` also takes a single .mcap file, without metadata.yaml."""
    with Reader(first) as reader, Reader(first / 'walk.mcap') as alone:
        folder, file = (
            {each.topic: (each.msgtype, each.msgcount, each.ext) for each in bag.connections}
            for bag in (reader, alone))
    assert folder == file and len(file) == len(PUBLISHED) + 3


def test_the_types_in_the_bag_are_those_on_the_wire(first, tmp_path):
    metadata = yaml.safe_load((first / 'metadata.yaml').read_text())
    topics = [each['topic_metadata'] for each in
              metadata['rosbag2_bagfile_information']['topics_with_message_count']]
    assert len(topics) == len(PUBLISHED) + 3
    with scene(tmp_path) as made:
        playing = player.Player(first, made.domain)
        try:
            found = made.ros.node.get_publishers_info_by_topic
            for topic in topics:
                offered, = made.ros.until(partial(found, topic['name']), topic['name'])
                assert str(offered.topic_type_hash) == topic['type_description_hash']
                wanted, = topic['offered_qos_profiles']
                assert offered.qos_profile.durability.name.lower() == wanted['durability']
                assert offered.qos_profile.reliability.name.lower() == wanted['reliability']
        finally:
            playing.close()
