# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The node as a process on a simulated serial port, with a subscriber in the test."""

from dataclasses import replace
from itertools import count
from math import hypot, nan, pi
import signal

from create_oi_msgs.msg import Bumper, Mode
from create_oi_msgs.srv import ResetPose
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3
from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import QoSProfile
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, PointCloud2
from std_srvs.srv import Trigger

from create_oi_ros import oi
from create_oi_ros.ros.messages import yaw_of
from create_oi_ros.ros.topics import LATCHED, PUBLISHED
from create_oi_ros.sim.body.config import DEFAULT_BODY
from support.loop import turn_difference
from tf2_msgs.msg import TFMessage


def in_mode(modes: list[Mode], mode: int) -> bool:
    """Return whether the newest `mode` message has this mode."""
    return bool(modes) and modes[-1].mode == mode


def test_a_drive_and_a_turn_agree_with_the_truth(ready):
    robot = ready.robot

    def driven() -> list[Odometry] | None:
        """Drive and turn; return what was heard, or None after a gap: the computer stood still."""
        ready.renew()
        odom, heard = ready.ros.listen(Odometry, 'odom'), len(ready.node.output)
        ready.drive(0.3, 0.0, lambda: robot.body.truth().pose.x >= 0.5)
        ready.ros.until(lambda: robot.body.truth().speed == 0)
        ready.drive(0.0, 1.5, lambda: robot.body.truth().pose.yaw >= pi / 2)
        ready.ros.until(lambda: robot.body.truth().rate == 0)
        truth = robot.body.truth().pose

        def gap() -> bool:
            return 'no frame for' in ready.node.output[heard:]

        def agrees() -> bool:  # frames that were late are made up for by the next readings
            place, yaw = odom[-1].pose.pose.position, yaw_of(odom[-1].pose.pose.orientation)
            return (hypot(place.x - truth.x, place.y - truth.y) < 0.02
                    and turn_difference(yaw, truth.yaw) < 0.05)
        ready.ros.until(lambda: gap() or agrees(), 'the odometry agrees with the truth')
        return None if gap() else odom
    odom = ready.ros.until(driven, 'a drive without a gap')
    last = odom[-1]
    assert (last.header.frame_id, last.child_frame_id) == ('odom', 'base_footprint')
    stamps = [nanoseconds(message) for message in odom]
    assert stamps == sorted(stamps)
    assert 0 < ready.ros.node.get_clock().now().nanoseconds - stamps[-1] < 5e9
    for place in (0, 7, 35):  # forward, sideways, turning: known, and not beyond doubt
        assert 0 < last.twist.covariance[place] < 0.1


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
    assert robot.create.mode is oi.Mode.SAFE
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
    others = {name: ready.ros.listen(type_, name, qos) for name, type_, qos in (
        ('contacts', PointCloud2, 10), ('mode', Mode, LATCHED), ('bumper', Bumper, 10))}
    ready.ros.until(lambda: transforms and all(others.values()) and in_mode(others['mode'], 2))
    ready.robot.body.force(bump_left=1, drop_left=1)
    ready.ros.until(lambda: others['contacts'][-1].width and in_mode(others['mode'], 1))
    newest = max(nanoseconds(received[-1]) for received in others.values())
    ready.ros.until(lambda: nanoseconds(transforms[-1].transforms[0]) > newest)
    known = {nanoseconds(each.transforms[0]) for each in transforms}
    assert {nanoseconds(received[-1]) for received in others.values()} <= known


def test_without_further_velocities_the_wheels_stop_and_one_that_is_no_number_is_refused(ready):
    velocity = ready.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    ready.ros.until(velocity.get_subscription_count)
    velocity.publish(Twist(linear=Vector3(x=0.2)))
    ready.ros.until(lambda: ready.robot.body.truth().speed > 0.1)
    ready.ros.until(lambda: ready.robot.body.truth().speed == 0)
    assert ready.set('cmd_vel_timeout', 10.0)
    velocity.publish(Twist(linear=Vector3(x=0.2)))
    ready.ros.until(lambda: ready.robot.body.truth().speed > 0.1)
    velocity.publish(Twist(angular=Vector3(z=nan)))
    ready.ros.until(lambda: ready.robot.body.truth().speed == 0)
    ready.ros.until(lambda: 'not finite' in ready.node.output)
    assert ready.set('cmd_vel_timeout', 0.5)


def test_velocities_drive_whatever_all_is_called_and_a_signal_stops_the_wheels(stage):
    robot = stage.robot()
    node = stage.node(robot.link, '__node:=mine', '__ns:=/robot1', 'cmd_vel:=/drive',
                      cmd_vel_timeout=10.0)
    velocity = stage.ros.node.create_publisher(Twist, 'drive', 1)

    def drives() -> bool:
        velocity.publish(Twist(linear=Vector3(x=0.2)))
        return robot.body.truth().speed > 0.1
    stage.ros.until(drives)
    stage.ros.until(lambda: {('mine', '/robot1'), ('mine_cmd_vel', '/robot1')} <= {
        *stage.ros.node.get_node_names_and_namespaces()})
    assert robot.body.truth().speed > 0.1
    node.send(signal.SIGTERM)  # nightly: all signals
    assert node.ended() == 0
    stage.ros.until(lambda: robot.body.truth().speed == 0)
    assert robot.create.mode is oi.Mode.PASSIVE
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
    assert ready.set('cmd_vel_timeout', 0.5)


def test_a_gyro_is_published_by_rep_145_once_it_follows_the_wheels(stage):
    robot = stage.robot(config=replace(DEFAULT_BODY, gyro=True))
    stage.node(robot.link, gyro='analog', base_frame='robot1/base_footprint')
    heard = stage.ros.listen(Imu, 'imu/data')
    odom = stage.ros.listen(Odometry, 'odom')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE) and len(odom) > 250, 'its zero, at rest')
    cmd_vel = stage.ros.node.create_publisher(Twist, 'cmd_vel', 10)
    began = robot.body.truth().turned

    def turns() -> list[Imu]:
        sign = 1 if int(robot.body.truth().turned - began) % 8 < 4 else -1
        cmd_vel.publish(Twist(angular=Vector3(z=1.0 * sign)))
        return heard
    stage.ros.until(turns, 'a turn rate')
    stage.ros.until(
        lambda: len(heard) > 20 and turns()
        and abs(heard[-1].angular_velocity.z - robot.body.truth().rate) < 0.3, 'its turn rate')
    imu = heard[-1]
    assert imu.header.frame_id == 'robot1/gyro_link'
    assert imu.orientation_covariance[0] == imu.linear_acceleration_covariance[0] == -1
    assert 0 < imu.angular_velocity_covariance[8] < 1e-2
    # Both together are surer, but for moments in which the wheels do not follow.
    stage.ros.until(lambda: turns() and (
        odom[-1].twist.covariance[35] < heard[-1].angular_velocity_covariance[8]))
