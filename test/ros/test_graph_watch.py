# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Mistakes in the ROS graph are reported: types, QoS, two publishers, two drivers, frames."""

from contextlib import closing, ExitStack

from create_oi_msgs.msg import Mode
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import qos_profile_sensor_data, QoSProfile
from rclpy.timer import Timer
from rclpy.topic_endpoint_info import TopicEndpointInfo

from create_oi_ros.ros.graph_watch import node_name
from create_oi_ros.ros.topics import LATCHED
from create_oi_ros.ros.velocity import UNNAMED
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


def test_a_best_effort_publisher_drives_and_is_named_once(ready, other):
    every(ready, other('stick'), Twist, qos_profile_sensor_data)
    ready.ros.until(lambda: drives(ready))
    beats = ready.ros.listen(DiagnosticArray, '/diagnostics')
    ready.ros.until(lambda: len(beats) > 2)
    assert ready.node.output.count('/stick publishes /cmd_vel as best effort, so this driver') == 1


def test_two_publishers_are_named_when_both_send(ready, other):
    first, second = other('first'), other('second')
    every(ready, first, Twist)
    second.node.create_publisher(Twist, 'cmd_vel', 1)
    beats = ready.ros.listen(DiagnosticArray, '/diagnostics')
    ready.ros.until(lambda: any(
        value.key == 'cmd_vel publishers' and value.value == '/first, /second'
        for beat in beats for status in beat.status for value in status.values))
    beats.clear()
    ready.ros.until(lambda: len(beats) > 1)
    assert 'nodes publish' not in ready.node.output
    every(ready, second, Twist)
    ready.ros.until(lambda: '3 nodes publish' in ready.node.output
                    or '2 nodes publish /cmd_vel: /first, /second.' in ready.node.output)
    ready.ros.until(lambda: any(
        'cmd_vel: the newest command wins' in status.message
        for beat in beats for status in beat.status))


def test_a_subscriber_that_gets_nothing_is_told_why(ready):
    odoms = ready.ros.listen(Odometry, 'odom', qos_profile_sensor_data)
    ready.ros.until(lambda: len(odoms) > 100)
    assert 'incompatible' not in ready.node.output
    ready.ros.listen(Odometry, 'odom', LATCHED)
    ready.ros.until(lambda: 'incompatible QoS. No messages will be sent to it. Last incompatible '
                    'policy: DURABILITY' in ready.node.output)
    ready.ros.listen(Twist, 'joint_states')
    ready.ros.until(lambda: (
        '/listener subscribes to /joint_states, but gets nothing: it takes geometry_msgs/Twist, '
        'and this driver publishes sensor_msgs/JointState' in ready.node.output))


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


def test_the_mode_of_another_driver_is_heard_while_it_runs(ready, other):
    count = ready.ros.node.count_subscribers
    for _ in range(2):
        driver = other('create')
        driver.node.create_publisher(Mode, '/second/mode', LATCHED)
        ready.ros.until(lambda: count('/second/mode') == 1, 'the driver listens to it')
        driver.node.destroy_node()
        ready.ros.until(lambda: count('/second/mode') == 0, 'and does not any more')


def test_two_drivers_of_one_name_are_reported(stage):
    first = stage.node(stage.robot().link)
    stage.ros.until(lambda: 'robot answers' in first.output)
    second = stage.node(stage.robot('second').link)
    for node in (first, second):
        stage.ros.until(lambda node=node: 'another node is called /create' in node.output)


def test_publishers_are_named_as_people_know_them():
    named = TopicEndpointInfo(node_name='joystick', node_namespace='/')
    assert node_name(named) == '/joystick'
    assert node_name(TopicEndpointInfo(node_name=UNNAMED)) == 'a program without a node name'
