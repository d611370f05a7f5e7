# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_record` as a user sees it: a real terminal, the real node, a complete bag."""

from pathlib import Path
import re
import resource
import signal

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import String
import yaml

pytest.importorskip('rosbags')

from rosbags.rosbag2 import Reader

from create_oi_ros.apps.record import main
from create_oi_ros.apps.report.recording import read
from create_oi_ros.ros.bags import Recorder
from create_oi_ros.ros.topics import ALL_TOPICS, LATCHED, PUBLISHED
from support.source import blocks, ROOT

CTRL_C = '\x03'


def amount(recorder) -> tuple[int, int]:
    """Return the last printed number of messages and of topics."""
    found = re.findall(r'(\d+) messages of (\d+) topics, \d+\.\d MB', recorder.output)
    return (int(found[-1][0]), int(found[-1][1])) if found else (0, 0)


def test_ctrl_c_leaves_a_complete_bag_of_all_topics(stage, tmp_path):
    stage.node(stage.robot().link, '__ns:=/robot1', cmd_vel_type='stamped')
    recorder = stage.program(
        'create_record', '-o', str(tmp_path / 'walk'), '--ros-args', '-r', '__ns:=/robot1',
        terminal=True)
    stage.ros.until(lambda: amount(recorder)[1] == len(PUBLISHED), 'a message of each topic')
    publisher = stage.ros.node.create_publisher(
        TwistStamped, '/robot1/cmd_vel', qos_profile_sensor_data)
    stage.ros.until(lambda: publisher.get_subscription_count() == 2)

    def commanded() -> bool:  # the recorder listens as best effort: one alone may be lost
        publisher.publish(TwistStamped())
        return amount(recorder)[1] == len(PUBLISHED) + 1
    stage.ros.until(commanded, 'a command')
    recorder.type(CTRL_C)
    assert recorder.ended() == 0
    *_, told, missing = recorder.output.splitlines()
    assert told.endswith(f'MB are in {tmp_path / "walk"}')
    assert missing == ('create_record: nothing was recorded of /robot1/imu/data, '
                       '/robot1/robot_description, /tf_static')
    with Reader(tmp_path / 'walk') as bag:
        counts = {each.topic: each.msgcount for each in bag.connections}
        types = {each.topic: each.msgtype for each in bag.connections}
    assert sum(counts.values()) == amount(recorder)[0] > 50
    for topic in PUBLISHED:
        absolute = topic.name.startswith('/')
        assert counts[topic.name if absolute else f'/robot1/{topic.name}'] > 0
    assert types['/robot1/cmd_vel'] == 'geometry_msgs/msg/TwistStamped'
    recording = read(tmp_path / 'walk')
    assert recording.robot == 'robot1'
    assert recording.events.spans['mode'].all and len(recording.odom) > 10
    file, = (tmp_path / 'walk').glob('*.mcap')
    assert f', {file.stat().st_size / 1e6:.1f} MB are in' in recorder.output


def test_an_empty_recording_is_reported(stage, tmp_path):
    recorder = stage.program('create_record', '-o', str(tmp_path / 'walk'))
    waits = f'create_record: waits for a driver in ROS domain {stage.domain}; on this computer '
    stage.ros.until(lambda: waits in recorder.output)
    recorder.send(signal.SIGINT)
    assert recorder.ended() == 1
    assert recorder.output.endswith(
        f'create_record: 0 messages of 0 topics, 0.0 MB are in {tmp_path / "walk"}\n'
        f'create_record: nothing was heard in ROS domain {stage.domain}\n')


def test_a_type_that_comes_later_is_named_since_a_bag_has_one(stage, tmp_path):
    recorder = stage.program('create_record', '-o', str(tmp_path / 'walk'), terminal=True)
    stage.ros.until(lambda: 'until Ctrl-C' in recorder.output)
    other = stage.listener('sends_twist')
    publisher = other.node.create_publisher(Twist, 'cmd_vel', qos_profile_sensor_data)
    other.node.create_timer(0.05, lambda: publisher.publish(Twist()))
    other.until(lambda: amount(recorder)[1], 'it is recorded')
    other.node.destroy_node()
    stage.listener('late').node.create_publisher(TwistStamped, 'cmd_vel', 1)
    named = ('/cmd_vel is published as geometry_msgs/TwistStamped now, which is not recorded: a '
             'bag has one type of a topic, in this one geometry_msgs/Twist')
    stage.ros.until(lambda: named in recorder.output)
    recorder.send(signal.SIGINT)
    assert recorder.ended() == 0
    with Reader(tmp_path / 'walk') as bag:
        assert [each.msgtype for each in bag.connections
                if each.topic == '/cmd_vel' and each.msgcount] == ['geometry_msgs/msg/Twist']
    assert recorder.output.count(named) == 1


def test_an_existing_folder_is_left_alone(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr('sys.argv', ['create_record', '-o', str(tmp_path)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.endswith(
        f'create_record: error: {tmp_path} is there already\n')


@pytest.fixture(scope='module')
def driver(shared_stage):
    """Return a scene with a robot and its driver."""
    shared_stage.node(shared_stage.robot().link)
    return shared_stage


def recorded(stage, recorder) -> Path:
    """Wait until a recorder without a terminal has written messages; return its file."""
    stage.ros.until(lambda: 'until Ctrl-C' in recorder.output)
    folder = Path(re.search(r' to (\S+) until Ctrl-C', recorder.output)[1])
    file, = folder.glob('*.mcap')
    stage.ros.until(lambda: file.stat().st_size > 200_000, 'two seconds are in the file')
    return file


def test_kill_9_loses_two_seconds_at_most(driver, tmp_path):
    recorder = driver.program('create_record', '-o', str(tmp_path / 'walk'))
    file = recorded(driver, recorder)
    heard = driver.ros.listen(Odometry, 'odom')
    driver.ros.until(lambda: heard, 'a frame')
    last = heard[-1].header.stamp
    recorder.send(signal.SIGKILL)
    recorder.ended()
    bag = read(file.parent)
    assert last.sec + last.nanosec / 1e9 - (bag.began + bag.seconds) < 2.0


def test_all_but_the_last_second_survives_a_full_disk(unmeasured, driver, tmp_path):
    recorder = driver.program('create_record', '-o', str(tmp_path / 'walk'))
    file = recorded(driver, recorder)
    full = file.stat().st_size + 100_000
    resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (full, full))
    assert recorder.ended() == 1
    assert recorder.printed[-2] == (
        'create_record: recording has ended: [Errno 27] File too large\n')
    assert recorder.printed[-1] == (
        f'create_record: all but the last second is in {tmp_path}/walk; create_report reads it\n')
    recording = read(file.parent)
    assert recording.odom.times[-1] > 2.0


# A bag of the recorder has the form that rosbag2 of Jazzy reads and plays.


LATCHING = {f'/{topic.name}' for topic in ALL_TOPICS if topic.qos is LATCHED}
DESCRIBED = '/robot_description'
FOREVER = {'sec': 9223372036, 'nsec': 854775807}
OFFERED = {
    'history': 'keep_last', 'reliability': 'reliable', 'durability': 'volatile',
    'deadline': FOREVER, 'lifespan': FOREVER, 'liveliness': 'automatic',
    'liveliness_lease_duration': FOREVER, 'avoid_ros_namespace_conventions': False}
"""QoS as rosbag2 of Jazzy parses it (convert<rclcpp::QoS>), without the depth."""


@pytest.fixture(scope='module')
def walk(driver) -> tuple[Path, int]:
    """Return a bag that was recorded from the driver, and how many messages it has."""
    other = driver.listener('records')
    recorder = Recorder(other.node, driver.folder / 'walk')
    described = other.node.create_publisher(String, DESCRIBED, LATCHED)
    described.publish(String(data='<robot name="create"/>'))
    other.until(lambda: recorder.counts['/odom'] > 100, 'two seconds')
    other.until(lambda: LATCHING | {DESCRIBED} <= set(recorder.counts), 'every latched topic')
    recorder.close()
    return driver.folder / 'walk', recorder.counts.total()


def test_the_metadata_is_what_rosbag2_of_jazzy_parses(walk):
    folder, messages = walk
    bag = yaml.safe_load((folder / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert (bag['version'], bag['storage_identifier']) == (9, 'mcap')
    assert bag['relative_file_paths'] == ['walk_0.mcap'] == [each['path'] for each in bag['files']]
    assert (bag['compression_format'], bag['compression_mode'], bag['custom_data']) == (
        '', '', None)
    assert isinstance(bag['ros_distro'], str)
    for times in (bag, *bag['files']):
        assert times['duration']['nanoseconds'] > 10**9
        assert times['starting_time']['nanoseconds_since_epoch'] > 10**18
        assert times['message_count'] == messages
    depths = {f'/{topic.name.lstrip("/")}': topic.qos.depth for topic in ALL_TOPICS}
    depths[DESCRIBED] = 1
    for each in bag['topics_with_message_count']:
        topic = each['topic_metadata']
        latched = topic['name'] in LATCHING | {DESCRIBED}
        assert topic['offered_qos_profiles'] == [{
            **OFFERED, 'depth': depths.pop(topic['name']),
            'durability': 'transient_local' if latched else 'volatile'}]
        assert topic['serialization_format'] == 'cdr' and each['message_count'] > 0
        assert re.fullmatch('RIHS01_[0-9a-f]{64}', topic['type_description_hash'])
    assert depths.keys() == {'/imu/data'}, 'there is no gyro'


def test_the_program_in_the_documentation_reads_the_bag_and_writes_its_track(walk, monkeypatch):
    program, = (block.text for block in blocks(ROOT / 'docs/recording.md')
                if block.language == 'python')
    folder = walk[0].parent
    monkeypatch.chdir(folder)
    exec(program, {})
    rows = [[float(each) for each in line.split(',')]
            for line in (folder / 'track.csv').read_text().splitlines()]
    assert len(rows) > 100
    assert all(before[0] < after[0] for before, after in zip(rows, rows[1:])), 'seconds'
    assert {len(row) for row in rows} == {3}
