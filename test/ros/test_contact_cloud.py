# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The topic `contacts`, as a costmap receives it."""

from itertools import count
from math import hypot
import struct

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Twist, Vector3
import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2, PointField

from create_oi_ros import oi
from create_oi_ros.driver import Moved
from create_oi_ros.driver.contacts import OUTSIDE
from create_oi_ros.driver.stream import ALL
from create_oi_ros.odometry import Estimate
from create_oi_ros.robot import BODY_RADIUS, SLOT
from create_oi_ros.ros.parameters import Parameters
from create_oi_ros.ros.publishing import ContactCloud
from create_oi_ros.ros.topics import LATCHED

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""What Nav2's obstacle layer subscribes with."""


def points(cloud: PointCloud2) -> list[tuple[float, ...]]:
    """Return the points of a cloud, as its fields describe them."""
    assert [(each.name, each.offset, each.datatype) for each in cloud.fields] == [
        ('x', 0, PointField.FLOAT32), ('y', 4, PointField.FLOAT32), ('z', 8, PointField.FLOAT32)]
    assert cloud.row_step == cloud.width * cloud.point_step == len(cloud.data)
    assert not cloud.is_bigendian and cloud.height == 1
    return list(struct.iter_unpack('<fff', bytes(cloud.data)))


def test_bumps_and_cliffs_are_points_for_a_while(stage):
    robot = stage.robot()
    stage.node(robot.link, contact_persistence=0.5)
    clouds = stage.ros.listen(PointCloud2, 'contacts', BEST_EFFORT)
    stage.ros.until(lambda: clouds, 'a cloud')
    assert points(clouds[-1]) == []
    assert clouds[-1].header.frame_id == 'base_footprint'
    assert clouds[-1].header.stamp.sec > 0
    robot.body.force(bump_left=1, cliff_right=1)
    stage.ros.until(lambda: clouds[-1].width == 2, 'two points')
    for x, y, z in points(clouds[-1]):
        assert hypot(x, y) == pytest.approx(BODY_RADIUS + OUTSIDE, abs=1e-3)
        assert 0 < z < 0.1
    robot.body.unforce('cliff_right')
    stage.ros.until(lambda: clouds[-1].width == 1, 'one point')
    (x, y, _), = points(clouds[-1])
    assert x > 0 and y > 0
    robot.body.unforce()
    stage.ros.until(lambda: clouds[-1].width == 0, 'no points')


def test_with_bump_stop_the_robot_does_not_push(stage):
    robot = stage.robot()
    stage.node(robot.link, bump_stop='forward')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: modes and modes[-1].mode == Mode.SAFE)
    velocity = stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.node.create_timer(0.1, lambda: velocity.publish(Twist(linear=Vector3(x=0.2))))
    wheels = robot.create.actuators
    stage.ros.until(lambda: wheels.wheels == (200, 200), 'it drives')
    robot.body.force(bump_left=1)
    stage.ros.until(lambda: wheels.wheels == (0, 0), 'it stops')
    robot.body.unforce()
    stage.ros.until(lambda: wheels.wheels == (200, 200), 'it drives again')


def test_a_bump_stop_that_does_not_exist_is_refused(stage):
    robot = stage.robot()
    node = stage.node(robot.link, bump_stop='both')
    assert node.ended() == 2
    assert "parameter bump_stop = 'both'; allowed: none, forward" in node.output


def test_a_cloud_has_the_stamp_of_its_frame_and_comes_when_it_is_due(stage):
    heard = stage.ros.listen(PointCloud2, 'contacts', BEST_EFFORT)
    cloud, slots = ContactCloud(stage.ros.node, Parameters()), count()

    def publish(**readings: int) -> bool:
        moved = Moved(
            next(slots) * SLOT, oi.Readings(dict.fromkeys(ALL, 0) | readings), Estimate())
        cloud.publish(moved, 7_000_000_005, Parameters())
        return bool(heard)
    stage.ros.until(publish, 'a cloud')
    assert (heard[-1].header.stamp.sec, heard[-1].header.stamp.nanosec) == (7, 5)
    heard.clear()
    publish(bumps_and_wheel_drops=1)
    stage.ros.until(lambda: heard and heard[-1].width, 'a cloud with points')
