# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Mistakes in the ROS graph are reported: wrong types, two publishers, two drivers."""

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped
import pytest
from rclpy.topic_endpoint_info import TopicEndpointInfo

from create_oi_ros.ros.graph_watch import names_of_publishers, node_name, UNNAMED
from support.ros import Scene, scene


@pytest.fixture
def stage(tmp_path):
    """Return an empty scene."""
    with scene(tmp_path) as made:
        yield made


def test_a_publisher_of_another_type_is_named_once(stage: Scene) -> None:
    node = stage.node(stage.robot().link)
    stage.ros.node.create_publisher(TwistStamped, 'cmd_vel', 1)
    warning = ('/listener publishes /cmd_vel as geometry_msgs/TwistStamped, but this driver takes '
               'geometry_msgs/Twist: its commands are ignored')
    stage.ros.until(lambda: warning in node.output)
    beats = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: len(beats) > 2)
    assert node.output.count(warning) == 1
    assert 'enable_stamped_cmd_vel: true' in node.output


def test_two_publishers_are_named(stage: Scene) -> None:
    node = stage.node(stage.robot().link)
    stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    beats = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: any(
        value.key == 'cmd_vel publishers' and value.value == '/listener'
        for beat in beats for status in beat.status for value in status.values))
    assert 'nodes publish' not in node.output
    second = stage.listener('joystick')
    second.node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.until(lambda: '2 nodes publish /cmd_vel: /joystick, /listener.' in node.output)


def test_two_drivers_of_one_name_are_reported(stage: Scene) -> None:
    first = stage.node(stage.robot().link)
    stage.ros.until(lambda: 'robot answers' in first.output)
    second = stage.node(stage.robot('second').link)
    for node in (first, second):
        stage.ros.until(lambda node=node: 'another node is called /create' in node.output)


def test_publishers_are_named_as_people_know_them(stage: Scene) -> None:
    stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    joystick = stage.listener('joystick')
    joystick.node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.until(lambda: stage.ros.node.count_publishers('cmd_vel') == 2)
    assert names_of_publishers(stage.ros.node, 'cmd_vel') == {'/joystick', '/listener'}
    # A program that is no ROS node has no name, however long one waits.
    assert node_name(TopicEndpointInfo(node_name=UNNAMED)) == 'a program without a node name'
