# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Mistakes in the ROS graph are reported: types, namespaces, two drivers, frames."""

from contextlib import closing, ExitStack
import signal

from create_oi_msgs.msg import Mode
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, Vector3
import pytest
from rclpy.qos import QoSProfile
from rclpy.timer import Timer

from create_oi_ros.ros.topics import LATCHED
from support.ros import Listener, Ready


@pytest.fixture
def other(shared):
    """Return a function that adds a node with a name to the graph, until the test ends."""
    with ExitStack() as stack:
        yield lambda name: stack.enter_context(closing(Listener(shared.stage.domain, name)))


def every(ready: Ready, who: Listener, type_: type, qos: QoSProfile | int = 1) -> Timer:
    """Publish a velocity of 0.1 m/s ten times a second while the test waits."""
    made = who.node.create_publisher(type_, 'cmd_vel', qos)
    twist = Twist(linear=Vector3(x=0.1))
    return ready.ros.node.create_timer(
        0.1, lambda: made.publish(twist if type_ is Twist else TwistStamped(twist=twist)))


def drives(ready: Ready) -> bool:
    """Return whether the wheels turn."""
    return ready.robot.body.truth().speed > 0.05


def test_a_publisher_of_a_type_that_was_not_chosen_is_named_once(stage):
    node = stage.node(stage.robot().link, cmd_vel_type='twist')
    stage.ros.node.create_publisher(TwistStamped, 'cmd_vel', 1)
    warning = ('/listener publishes /cmd_vel as geometry_msgs/TwistStamped, but this driver takes '
               'geometry_msgs/Twist: its commands are ignored')
    stage.ros.until(lambda: warning in node.output)
    beats = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: len(beats) > 2)
    assert node.output.count(warning) == 1
    assert 'cmd_vel_type: auto' in node.output


def test_stamped_commands_drive_when_alone_and_beside_others_are_named(ready, other):
    stamped = every(ready, other('nav2'), TwistStamped)
    ready.ros.until(lambda: drives(ready))
    assert '/nav2 publishes' not in ready.node.output
    other('wheel').node.create_publisher(Twist, 'cmd_vel', 1)
    ready.ros.until(
        lambda: '/wheel publishes /cmd_vel as geometry_msgs/Twist, but' in ready.node.output)
    assert 'Let all publishers send the same type' in ready.node.output
    stamped.cancel()
    ready.ros.until(lambda: not drives(ready), 'the command timeout')


def test_commands_in_another_namespace_are_a_hint(stage):
    node = stage.node(stage.robot().link, '__ns:=/robot1')
    stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.until(lambda: '/listener publishes /cmd_vel, to which nobody listens; this driver '
                    'listens to /robot1/cmd_vel' in node.output)


def test_two_robots_with_the_same_frames_are_reported(stage):
    nodes = [stage.node(stage.robot(name).link, f'__ns:=/{name}') for name in ('one', 'two')]
    third = stage.node(
        stage.robot('three').link, '__ns:=/three', odom_frame='three/odom',
        base_frame='three/base_footprint')
    for node, other in zip(nodes, ('two', 'one')):
        stage.ros.until(lambda node=node, other=other: (
            f'/{other}/create publishes a transform to base_footprint on /tf' in node.output))
    assert 'odom_frame: one/odom' in nodes[0].output
    assert 'robot answers' in third.output
    assert '/three/create publishes' not in ''.join(node.output for node in nodes)
    assert 'publishes a transform' not in third.output


def test_when_a_second_driver_has_ended_subscribers_have_the_state_of_the_first(stage):
    first = stage.node(stage.robot().link)
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: modes and modes[-1].mode == Mode.SAFE)
    second = stage.node(stage.folder / 'nowhere')
    stage.ros.until(lambda: 'another node is called /create' in first.output)
    stage.ros.until(lambda: modes[-1].mode == Mode.UNKNOWN, 'it has no robot')
    second.send(signal.SIGTERM)
    assert second.ended() == 0
    stage.ros.until(lambda: modes[-1].mode == Mode.SAFE, 'the first has one')


def test_two_drivers_of_one_name_are_reported(stage):
    first = stage.node(stage.robot().link)
    stage.ros.until(lambda: 'robot answers' in first.output)
    second = stage.node(stage.robot('second').link)
    for node in (first, second):
        stage.ros.until(lambda node=node: 'another node is called /create' in node.output)
