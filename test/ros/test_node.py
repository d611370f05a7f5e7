# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The node as a process on a simulated serial port, with a subscriber in the test."""

from dataclasses import replace
from itertools import count
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
from create_oi_ros.ros.topics import PUBLISHED
from create_oi_ros.sim.body.config import DEFAULT_BODY
from tf2_msgs.msg import TFMessage


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
