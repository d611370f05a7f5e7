# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Mistakes in the ROS graph are reported: types, namespaces, two drivers, frames."""

import signal

from create_oi_msgs.msg import Mode
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, Vector3

from support.ros import Ready


def test_commands_of_a_wrong_type_and_in_another_namespace_are_named_once(stage):
    node = stage.node(stage.robot().link, '__ns:=/robot1', cmd_vel_type='twist')
    stage.ros.node.create_publisher(TwistStamped, '/robot1/cmd_vel', 1)
    stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    warnings = (
        '/listener publishes /robot1/cmd_vel as geometry_msgs/TwistStamped, but this driver takes '
        'geometry_msgs/Twist: its commands are ignored',
        '/listener publishes /cmd_vel, to which nobody listens; this driver listens to '
        '/robot1/cmd_vel')
    stage.ros.until(lambda: all(warning in node.output for warning in warnings))
    beats = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: len(beats) > 2)
    assert [node.output.count(warning) for warning in warnings] == [1, 1]
    assert 'cmd_vel_type: auto' in node.output


def test_stamped_commands_drive_when_alone_and_beside_others_are_named(stage):
    ready = Ready(stage)
    stamped = stage.listener('nav2').node.create_publisher(TwistStamped, 'cmd_vel', 1)
    command = TwistStamped(twist=Twist(linear=Vector3(x=0.1)))
    timer = stage.ros.node.create_timer(0.1, lambda: stamped.publish(command))
    stage.ros.until(lambda: ready.robot.body.truth().speed > 0.05)
    assert '/nav2 publishes' not in ready.node.output
    stage.listener('wheel').node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.until(
        lambda: '/wheel publishes /cmd_vel as geometry_msgs/Twist, but' in ready.node.output)
    assert 'Let all publishers send the same type' in ready.node.output
    timer.cancel()
    stage.ros.until(lambda: ready.robot.body.truth().speed <= 0.05, 'the command timeout')


def test_two_robots_with_the_same_frames_are_reported(stage):
    nodes = [stage.node(stage.robot(name).link, f'__ns:=/{name}') for name in ('one', 'two')]
    third = stage.node(
        stage.robot('three').link, '__ns:=/three', odom_frame='three/odom',
        base_frame='three/base_footprint')
    for node, other in zip(nodes, ('two', 'one')):
        stage.ros.until(lambda node=node, other=other: (
            f'/{other}/create publishes a transform to base_footprint on /tf' in node.output))
    assert 'odom_frame: one/odom' in nodes[0].output
    stage.ros.until(lambda: 'robot answers' in third.output)
    assert '/three/create publishes' not in ''.join(node.output for node in nodes)
    assert 'publishes a transform' not in third.output


def test_two_drivers_of_one_name_are_reported_and_after_the_second_the_first_has_its_say(stage):
    ready = Ready(stage)
    second = stage.node(stage.folder / 'nowhere')
    for node in (ready.node, second):
        stage.ros.until(lambda node=node: 'another node is called /create' in node.output)
    ready.until_mode(Mode.UNKNOWN)  # the second has no robot
    second.send(signal.SIGTERM)
    assert second.ended() == 0
    ready.until_mode(Mode.SAFE)  # the first has one
