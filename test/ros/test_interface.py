# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Every topic and service as a user sees it: through ROS, with the node as a process."""

from dataclasses import replace
from itertools import count
from math import hypot
import re
import signal
from statistics import median
import struct

from create_oi_msgs.msg import (
    Bumper,
    Buttons,
    Charging,
    IrOmni,
    Mode,
    Song,
    Wall,
)
from create_oi_msgs.srv import (
    DefineScript,
    DefineSong,
    PlayScript,
    PlaySong,
    ResetPose,
    SendIr,
    SetDigitalOutputs,
    SetLeds,
    SetLowSideDrivers,
    SetMode,
    StartDemo,
)
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState, Imu, JointState, PointCloud2, PointField
from std_srvs.srv import Trigger

from create_oi_ros import oi
from create_oi_ros.driver.contacts import OUTSIDE
from create_oi_ros.driver.goals import Code
from create_oi_ros.oi.tools.text import parse_script
from create_oi_ros.robot import BODY_RADIUS
from create_oi_ros.ros.actions import ACTIONS
from create_oi_ros.ros.services import SERVICES
from create_oi_ros.ros.topics import LATCHED, PUBLISHED
from create_oi_ros.sim.body.config import DEFAULT_BODY
from support.ros import Ready
from tf2_msgs.msg import TFMessage

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def points(cloud: PointCloud2) -> list[tuple[float, ...]]:
    """Return the points of a cloud, as its fields describe them."""
    assert [(each.name, each.offset, each.datatype) for each in cloud.fields] == [
        ('x', 0, PointField.FLOAT32), ('y', 4, PointField.FLOAT32), ('z', 8, PointField.FLOAT32)]
    assert cloud.row_step == cloud.width * cloud.point_step == len(cloud.data)
    assert not cloud.is_bigendian and cloud.height == 1
    return list(struct.iter_unpack('<fff', bytes(cloud.data)))


def test_bumps_and_cliffs_are_points_for_a_while(ready):
    """With the QoS of Nav2's obstacle layer."""
    body, until = ready.robot.body, ready.ros.until
    assert ready.set('contact_persistence', 0.5)
    clouds = ready.ros.listen(PointCloud2, 'contacts', BEST_EFFORT)
    until(lambda: clouds and not clouds[-1].width, 'a cloud')
    assert points(clouds[-1]) == []
    assert clouds[-1].header.frame_id == 'base_footprint'
    assert clouds[-1].header.stamp.sec > 0
    body.force(bump_left=1, cliff_right=1)
    until(lambda: clouds[-1].width == 2, 'two points')
    for x, y, z in points(clouds[-1]):
        assert hypot(x, y) == pytest.approx(BODY_RADIUS + OUTSIDE, abs=1e-3)
        assert 0 < z < 0.1
    body.unforce('cliff_right')
    until(lambda: clouds[-1].width == 1, 'one point')
    (x, y, _), = points(clouds[-1])
    assert x > 0 and y > 0
    body.unforce()
    until(lambda: clouds[-1].width == 0, 'no points')


def test_songs_play_and_are_published(ready):
    songs = ready.ros.listen(Song, 'song', LATCHED)
    ready.ros.until(lambda: songs)
    said = ready.ask(DefineSong, 'define_song', number=5, pitches=[72, 0, 76], seconds=[1.0] * 3)
    assert '3.000 s' in said
    ready.ask(PlaySong, 'play_song', number=5)
    ready.ros.until(lambda: songs[-1].playing and songs[-1].number == 5)
    assert 'a song plays' in ready.refused(PlaySong, 'play_song', number=5)
    ready.ros.until(lambda: not songs[-1].playing)
    said = ready.ask(DefineSong, 'define_song', number=6, pitches=[72], seconds=[0.1], play=True)
    assert '1/64 s' in said
    ready.ros.until(lambda: songs[-1].number == 6)
    assert 'number' in ready.refused(
        DefineSong, 'define_song', number=16, pitches=[60], seconds=[1.0])


def test_actuators_are_set_refused_in_passive_and_restored(ready):
    def set_all(ask) -> list[str]:
        return [
            ask(SetLeds, 'set_leds', play=True, power_color=255, power_intensity=128),
            ask(SetDigitalOutputs, 'set_digital_outputs', output_1=True),
            ask(SetLowSideDrivers, 'set_low_side_drivers', driver_0=1.0, driver_2=0.5),
            ask(SendIr, 'send_ir', character=IrOmni.REMOTE_PAUSE)]
    robot = ready.robot.create
    set_all(ready.ask)
    ready.ros.until(lambda: robot.lights == (oi.LedBits.PLAY, 255, 128))
    ready.ros.until(lambda: robot.outputs == oi.OutputBits.OUTPUT_1)
    ready.ros.until(lambda: tuple(robot.actuators.duties) == (128, 0, 64))
    ready.ros.until(lambda: IrOmni.REMOTE_PAUSE in robot.actuators.infrared_sent)
    assert 'driver_1' in ready.refused(SetLowSideDrivers, 'set_low_side_drivers', driver_1=1.5)
    ready.ask(SetMode, 'set_mode', mode=SetMode.Request.PASSIVE)
    for message in set_all(ready.refused):
        assert message == 'robot is in PASSIVE: call set_mode with SAFE first'
    ready.ask(SetMode, 'set_mode', mode=SetMode.Request.FULL)
    ready.ros.until(lambda: robot.lights == (oi.LedBits.PLAY, 255, 128))


def test_demos_run_end_and_dock(ready):
    robot = ready.robot.create
    ready.ask(StartDemo, 'start_demo', demo=StartDemo.Request.DRIVE_FIGURE_EIGHT)
    ready.ros.until(lambda: robot.demo is oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    ready.until_mode(Mode.PASSIVE)
    assert ready.modes[-1].wanted == Mode.PASSIVE
    ready.ask(Trigger, 'stop_demo')
    ready.ros.until(lambda: robot.demo is None)
    ready.ask(SetMode, 'set_mode', mode=SetMode.Request.SAFE)
    ready.ask(StartDemo, 'start_demo', demo=StartDemo.Request.COVER_AND_DOCK)
    ready.ros.until(lambda: robot.demo is oi.DemoNumber.COVER_AND_DOCK)
    ready.ask(Trigger, 'stop')
    ready.ros.until(lambda: robot.demo is None)
    for wrong in (10, -1, -5):
        ready.refused(StartDemo, 'start_demo', demo=wrong)


def test_scripts_are_stored_and_played(ready):
    text = 'Drive velocity=200 radius=straight\nWait Time time=5\nDrive velocity=0 radius=0\n'
    assert 'not known' in ready.refused(PlayScript, 'play_script')
    ready.ask(DefineScript, 'define_script', text=text)
    ready.ros.until(lambda: ready.robot.create.script == parse_script(text).script)
    ready.ask(PlayScript, 'play_script')
    ready.ros.until(lambda: ready.robot.body.truth().speed > 0.1)
    ready.ros.until(lambda: 'script has ended' in ready.node.output)
    ready.ros.until(lambda: ready.robot.body.truth().speed == 0)
    ready.ask(DefineScript, 'define_script', code=[155, 1, 153])
    assert 'force' in ready.refused(PlayScript, 'play_script')
    assert 'column' in ready.refused(DefineScript, 'define_script', text='Fly away')
    assert 'both' in ready.refused(DefineScript, 'define_script', text=text, code=[155, 1])


def test_ending_the_node_while_a_script_holds_the_robot_is_an_error_line(stage):
    ready = Ready(stage)
    text = 'Drive velocity=100 radius=straight\nWait Distance distance=-1000'
    ready.ask(DefineScript, 'define_script', text=text)
    assert 'waits for ever' in ready.refused(PlayScript, 'play_script')
    ready.ask(PlayScript, 'play_script', force=True)
    assert 'Power button' in ready.refused(Trigger, 'stop')
    ready.node.send(signal.SIGINT)
    assert ready.node.ended() == 0
    assert '[ERROR]' in ready.node.output
    assert 'the driver ends, but a script plays' in ready.node.output
    assert 'for an unknown time' in ready.node.output


def test_without_a_robot_it_is_said_once_and_every_service_answers_with_what_to_do(stage):
    node = stage.node(stage.folder / 'nothing', cmd_vel_timout=1.0)
    diagnostics = stage.ros.listen(DiagnosticArray, '/diagnostics')
    fields = {'set_mode': {'mode': Mode.SAFE}, 'define_song': {'pitches': [60], 'seconds': [1.0]}}
    says = {'save_odometry_model': '-p odometry_model:=FILE'}
    for service in SERVICES:
        reply = stage.ros.call(service.type, service.name, **fields.get(service.name, {}))
        assert reply.message and says.get(service.name, '') in reply.message, service.name
        assert reply.success == service.name.startswith('reset_'), service.name
    assert 'cmd_vel_timout is unknown and ignored: did you mean cmd_vel_timeout?' in node.output
    stage.ros.until(lambda: len(diagnostics) >= 3)
    assert node.output.count('does not exist') == 1
    link = next(s for s in diagnostics[-1].status if s.name.endswith('serial link'))
    assert link.level == b'\x02' and 'does not exist' in link.message


def typical_rate(heard: list) -> float:
    """Return messages a second by their stamps; those that a busy computer loses count little."""
    stamps = [Time.from_msg(message.header.stamp).nanoseconds / 1e9 for message in heard]
    stretch = min(3, len(stamps) - 1)
    return stretch / median(later - earlier for earlier, later in zip(stamps, stamps[stretch:]))


def test_other_programs_receive_at_the_promised_rates_with_their_usual_qos(ready):
    """The QoS is that of rviz2 and Nav2 (best effort or reliable) and of a late recorder."""
    listen = ready.ros.listen
    odom, walls = listen(Odometry, 'odom', BEST_EFFORT), listen(Wall, 'wall', BEST_EFFORT)
    joints, frames = listen(JointState, 'joint_states'), listen(TFMessage, '/tf', BEST_EFFORT)
    batteries = listen(BatteryState, 'battery_state')
    volatile = listen(Buttons, 'buttons')
    statuses = listen(DiagnosticArray, '/diagnostics')
    ready.ros.until(lambda: len(batteries) >= 3 and len(statuses) >= 3)
    for heard, expected in ((odom, 66.7), (joints, 66.7), (walls, 20), (batteries, 1)):
        assert typical_rate(heard) == pytest.approx(expected, rel=0.1)
    assert len(frames) > 100
    assert not volatile
    names = {status.name for status in statuses[-1].status}
    assert names == {f'create: {part}' for part in (
        'battery', 'safety', 'mode', 'serial link', 'driver', 'odometry', 'parameters')}


def test_commands_of_a_wrong_clock_are_named_and_old_ones_are_dropped(stage):
    ready = Ready(stage, cmd_vel_type='stamped')
    velocity = ready.ros.node.create_publisher(TwistStamped, 'cmd_vel', 1)
    old = [2.0]

    def publish() -> None:
        now = ready.ros.node.get_clock().now().nanoseconds
        command = TwistStamped(twist=Twist(linear=Vector3(x=0.2)))
        command.header.stamp = Time(nanoseconds=now - round(old[0] * 1e9)).to_msg()
        velocity.publish(command)
    ready.ros.node.create_timer(0.1, publish)
    ready.ros.until(lambda: 'cmd_vel of 2.' in ready.node.output)
    assert ready.robot.body.truth().travelled == 0
    old[0] = 0.0
    ready.ros.until(lambda: ready.robot.body.truth().speed > 0.1)
    assert 'ahead' not in ready.node.output
    old[0] = -3600.0
    ready.ros.until(lambda: re.search(
        r'cmd_vel is stamped 3(600|599)\.\d s ahead of now: it is followed', ready.node.output))
    ready.ros.until(lambda: ready.robot.body.truth().speed > 0.1)


@pytest.mark.parametrize(('ours', 'core'), [
    (Mode, oi.Mode), (SetMode.Request, [m for m in oi.Mode if m]), (Charging, oi.ChargingState),
    (IrOmni, oi.Infrared), (StartDemo.Request, [d for d in oi.DemoNumber if d >= 0]),
    *((each.type.Result, Code) for each in ACTIONS if each.name != 'audio_note_sequence'),
], ids=lambda each: getattr(each, '__name__', ''))
def test_constants_of_messages_are_those_of_the_core(ours, core):
    constants = {name: getattr(ours, name) for name in dir(ours)
                 if name.isupper() and name not in ('SLOT_TYPES', 'UNKNOWN')}
    assert constants == {member.name: member.value for member in core}


# The node: its clock, its stamps, its signals, its odometry and its gyro.


def nanoseconds(message) -> int:
    """Return the stamp of a message."""
    return message.header.stamp.sec * 10 ** 9 + message.header.stamp.nanosec


def test_with_use_sim_time_nothing_is_published_before_the_clock_and_stamps_follow_it(stage):
    robot = stage.robot()
    node = stage.node(robot.link, use_sim_time=True)
    heard = {topic.name: stage.ros.listen(topic.type, topic.name, topic.qos)
             for topic in PUBLISHED if topic.name != '/tf'}
    stage.ros.until(lambda: node.output.count('no time comes on /clock') == 2, 'two warnings')
    assert not any(heard.values())
    stage.ros.until(lambda: robot.create.mode is oi.Mode.SAFE)
    ticks, clock = count(1), stage.ros.node.create_publisher(Clock, '/clock', 1)
    newest = [0]

    def tick() -> None:  # half as fast as time
        newest[0] = next(ticks) * 5_000_000
        clock.publish(Clock(clock=Time(nanoseconds=newest[0]).to_msg()))
    stage.ros.node.create_timer(0.01, tick)
    stage.ros.until(lambda: all(heard.values()) and len(heard['odom']) > 50, 'all topics')
    for received in heard.values():
        stamps = [nanoseconds(each) for each in received]
        assert stamps == sorted(stamps)
        assert 0 < stamps[0] and stamps[-1] <= newest[0]
    assert len({nanoseconds(each) for each in heard['odom']}) == len(heard['odom'])


def test_topics_of_a_frame_have_its_stamp(ready):
    transforms = ready.ros.listen(TFMessage, '/tf', 1000)
    contacts = ready.ros.listen(PointCloud2, 'contacts')
    others = contacts, ready.ros.listen(Bumper, 'bumper'), ready.modes
    ready.ros.until(lambda: transforms and all(others))
    ready.robot.body.force(bump_left=1, drop_left=1)
    ready.until_mode(Mode.PASSIVE)
    ready.ros.until(lambda: contacts[-1].width)
    newest = max(nanoseconds(received[-1]) for received in others)
    ready.ros.until(lambda: nanoseconds(transforms[-1].transforms[0]) > newest)
    known = {nanoseconds(each.transforms[0]) for each in transforms}
    assert {nanoseconds(received[-1]) for received in others} <= known


def test_velocities_drive_whatever_all_is_called_and_a_signal_stops_the_wheels(stage):
    robot = stage.robot()
    node = stage.node(robot.link, '__node:=mine', '__ns:=/robot1', 'cmd_vel:=/drive',
                      cmd_vel_timeout=10.0)
    stage.ros.drive(0.2, 0.0, lambda: robot.body.truth().speed > 0.1, 'drive')
    stage.ros.until(lambda: {('mine', '/robot1'), ('mine_cmd_vel', '/robot1')} <= {
        *stage.ros.node.get_node_names_and_namespaces()})
    assert robot.body.truth().speed > 0.1
    node.send(signal.SIGTERM)  # nightly: all signals
    assert node.ended() == 0
    stage.ros.until(lambda: robot.body.truth().speed == 0)
    stage.ros.until(lambda: robot.create.mode is oi.Mode.PASSIVE)
    assert 'Traceback' not in node.output


def test_stop_and_reset_odometry(ready):
    odom = ready.ros.listen(Odometry, 'odom', QoSProfile(depth=1000))  # all, however late
    assert ready.set('cmd_vel_timeout', 10.0)
    velocity = ready.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    ready.ros.until(velocity.get_subscription_count)
    velocity.publish(Twist(linear=Vector3(x=0.2)))
    ready.ros.until(lambda: odom and odom[-1].pose.pose.position.x > 0.1)
    ready.ask(Trigger, 'stop')
    # The odometry predicts braking after a stop; the rest of it would come after the reset.
    ready.ros.until(lambda: odom[-1].twist.twist.linear.x == 0)
    assert odom[-1].pose.pose.position.x < 1.5, 'stopped before the timeout, which is after 2 m'
    before = len(odom)
    ready.ask(Trigger, 'reset_odometry')
    # The next reading, which may have come since then, moves the pose by some 1e-8 m.
    ready.ros.until(lambda: any(abs(each.pose.pose.position.x) < 1e-9 for each in odom[before:]))
    assert abs(odom[-1].pose.pose.position.x) < 1e-6
    place = Pose(position=Point(x=1.0, y=2.0), orientation=Quaternion(z=1.0, w=0.0))
    assert 'x 1 m, y 2 m, yaw 3.14' in ready.ask(ResetPose, 'reset_pose', pose=place)
    ready.ros.until(lambda: odom[-1].pose.pose.position.y == pytest.approx(2, abs=0.001))
    assert odom[-1].pose.pose.orientation.z == pytest.approx(1, abs=0.001)
    stamps = [nanoseconds(each) for each in odom]
    assert stamps == sorted(stamps)
    assert 0 < ready.ros.node.get_clock().now().nanoseconds - stamps[-1] < 5e9
    for place in (0, 7, 35):  # forward, sideways, turning: known, and not beyond doubt
        assert 0 < odom[-1].twist.covariance[place] < 0.1
    assert ready.set('cmd_vel_timeout', 0.5)


def test_a_gyro_is_published_by_rep_145_once_it_follows_the_wheels(stage):
    robot = stage.robot(config=replace(DEFAULT_BODY, gyro=True))
    stage.node(robot.link, gyro='analog', base_frame='robot1/base_footprint')
    heard = stage.ros.listen(Imu, 'imu/data')
    odom = stage.ros.listen(Odometry, 'odom')
    stage.ros.until(
        lambda: robot.create.mode is oi.Mode.SAFE and len(odom) > 250, 'its zero, at rest')
    cmd_vel = stage.ros.node.create_publisher(Twist, 'cmd_vel', 10)
    began = robot.body.truth().turned

    def turns() -> list[Imu]:
        sign = 1 if int(robot.body.truth().turned - began) % 8 < 4 else -1
        cmd_vel.publish(Twist(angular=Vector3(z=1.0 * sign)))
        return heard
    stage.ros.until(
        lambda: turns() and abs(heard[-1].angular_velocity.z - robot.body.truth().rate) < 0.3)
    assert heard[-1].header.frame_id == 'robot1/gyro_link'
    assert 0 < heard[-1].angular_velocity_covariance[8] < 1e-2
    # Both together are surer, but for moments in which the wheels do not follow.
    stage.ros.until(lambda: turns() and (
        odom[-1].twist.covariance[35] < heard[-1].angular_velocity_covariance[8]))
