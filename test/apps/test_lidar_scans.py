# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_run --lidar` and `create_lidar`, as SLAM and Nav2 meet them."""

from math import inf, pi
from pathlib import Path
import signal

from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
import yaml

from create_oi_ros.ros.topics import LATCHED
from tf2_msgs.msg import TFMessage

SLAM = Path(__file__).parents[2] / 'config' / 'with' / 'slam_toolbox.yaml'


def test_scans_of_a_room_come_as_slam_and_nav2_expect_them(stage):
    run = stage.program('create_run', '--world', 'room', '--lidar')
    scans = stage.ros.listen(LaserScan, '/scan', qos_profile_sensor_data)
    transforms = stage.ros.listen(TFMessage, '/tf_static', LATCHED)
    odom = stage.ros.listen(Odometry, 'odom')
    stage.ros.until(lambda: len(scans) > 10 and odom)
    slam = yaml.safe_load(SLAM.read_text())['slam_toolbox']['ros__parameters']
    scan = scans[-1]
    assert slam['scan_topic'] == '/scan'
    assert scan.range_max == pytest.approx(slam['max_laser_range'])
    assert (scan.range_min, scan.scan_time) == pytest.approx((0.12, 0.1))
    transform, = (each for message in transforms for each in message.transforms)
    assert transform.header.frame_id == slam['base_frame'] == odom[-1].child_frame_id
    assert transform.child_frame_id == scan.header.frame_id == 'laser'
    assert transform.transform.translation.z == pytest.approx(0.12)
    assert len(scan.ranges) == 360
    assert scan.angle_min == pytest.approx(-pi)
    assert scan.angle_max == pytest.approx(scan.angle_min + 359 * scan.angle_increment)
    for beam, wall in ((0, 2.0), (90, 1.5), (180, 2.0), (270, 1.5)):
        assert scan.ranges[beam] == pytest.approx(wall, abs=0.05)
    stamps = [(each.header.stamp.sec, each.header.stamp.nanosec) for each in scans]
    assert stamps == sorted(set(stamps))
    run.send(signal.SIGINT)
    assert run.ended() == 0
    assert 'Traceback' not in run.output


def test_where_nothing_is_near_all_ranges_are_infinite_and_the_end_of_the_robot_is_its_end(stage):
    sim = stage.program('create_sim', '--link', str(stage.folder / 'create'), '--control',
                        str(stage.folder / 'control'), '--world', 'empty')
    lidar = stage.program('create_lidar', '--control', str(stage.folder / 'control'),
                          '--frame', 'r1/laser', '--base-frame', 'r1/base_footprint')
    scans = stage.ros.listen(LaserScan, 'scan', qos_profile_sensor_data)
    stage.ros.until(lambda: scans)
    assert set(scans[-1].ranges) == {inf}
    assert scans[-1].header.frame_id == 'r1/laser'
    sim.send(signal.SIGINT)
    assert lidar.ended() == 0
    assert 'Traceback' not in lidar.output
