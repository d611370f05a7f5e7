# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The topic `contacts`, as a costmap receives it."""

from math import hypot
import struct

import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2, PointField

from create_oi_ros.driver.contacts import OUTSIDE
from create_oi_ros.robot import BODY_RADIUS

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
