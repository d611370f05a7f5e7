# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity commands are heard whoever publishes them: either type, either reliability."""

from collections.abc import Iterator
import threading
from typing import Any

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Twist, TwistStamped, Vector3
import pytest
from rclpy.qos import qos_profile_sensor_data, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from create_oi_ros.ros.topics import LATCHED
from create_oi_ros.ros.velocity import driver_type, RELIABLE_CHECKS, VelocityInput
from support.ros import Listener, Scene, TIMEOUT

RELIABLE, BEST_EFFORT = QoSProfile(depth=1), qos_profile_sensor_data


class Heard:
    """A velocity input that runs, and the commands that it has heard."""

    def __init__(self, ros: Listener) -> None:
        self._ros = ros
        self._got: list[tuple[float, float]] = []
        self.input = VelocityInput(ros.node, 'auto', self._on_command, on_failure=lambda: None)
        self.input.start()

    def _on_command(self, linear: float, angular: float, stamp: Any) -> None:
        self._got.append((linear, angular))

    def until(self, publish: Any, speed: float) -> None:
        """Publish until it is heard; meanwhile the input adapts to its publishers."""
        self._got.clear()

        def heard() -> bool:
            self.input.adapt(self._ros.node.get_publishers_info_by_topic('cmd_vel'))
            publish(speed)
            return (speed, -speed) in self._got
        self._ros.until(heard)


@pytest.fixture
def heard(stage) -> Iterator[Heard]:
    """Return an input of the scene's node."""
    made = Heard(stage.ros)
    yield made
    made.input.close()


def publisher(stage: Scene, type_: type) -> Any:
    """Return a function that publishes a speed, on a context of its own: that has one type."""
    made = stage.listener('other').node.create_publisher(type_, 'cmd_vel', RELIABLE)

    def publish(speed: float) -> None:
        twist = Twist(linear=Vector3(x=speed), angular=Vector3(z=-speed))
        made.publish(twist if type_ is Twist else TwistStamped(twist=twist))
    publish.end = made.destroy  # type: ignore[attr-defined]
    return publish


def test_types_follow_the_publishers_that_are_alone_and_stay_while_both_are_there(stage, heard):
    twist = publisher(stage, Twist)
    heard.until(twist, 0.1)
    stamped = publisher(stage, TwistStamped)
    heard.until(twist, 0.2)
    twist.end()
    heard.until(stamped, 0.3)
    twist = publisher(stage, Twist)
    heard.until(stamped, 0.4)
    assert heard.input.type is TwistStamped
    stamped.end()
    heard.until(twist, 0.5)


def endpoint(qos: QoSProfile = RELIABLE, type_: str = 'Twist') -> TopicEndpointInfo:
    """Return a publisher of this type."""
    return TopicEndpointInfo(topic_type=f'geometry_msgs/msg/{type_}', qos_profile=qos)


def test_best_effort_ends_when_all_have_been_reliable_for_a_while(stage, heard):
    made = heard.input
    made.adapt([endpoint(), endpoint(BEST_EFFORT)])
    stage.ros.until(lambda: made.reliability is ReliabilityPolicy.BEST_EFFORT)
    for _ in range(2):
        for _ in range(RELIABLE_CHECKS - 1):
            made.adapt([endpoint()])
        made.adapt([])
        assert made.reliability is ReliabilityPolicy.BEST_EFFORT
        made.adapt([endpoint(BEST_EFFORT)])
    for _ in range(RELIABLE_CHECKS):
        made.adapt([endpoint()])
    stage.ros.until(lambda: made.reliability is ReliabilityPolicy.RELIABLE)
    heard.until(publisher(stage, Twist), 0.2)


def test_close_waits_for_the_function(stage):
    entered, leave, left, failed = (threading.Event() for _ in range(4))

    def take(linear: float, angular: float, stamp: Any) -> None:
        entered.set()
        assert leave.wait(TIMEOUT)
        left.set()
    made = VelocityInput(stage.ros.node, 'twist', take, on_failure=failed.set)
    never = VelocityInput(stage.ros.node, 'twist', take, on_failure=failed.set)
    made.start()
    publish = publisher(stage, Twist)
    stage.ros.until(lambda: publish(0.1) or entered.is_set())
    threading.Timer(0.1, leave.set).start()
    for each in (made, never):
        each.close()
    assert left.is_set()
    assert not failed.is_set()


# Who takes the commands: only a driver does, a node that publishes its mode.


def test_a_listener_is_no_driver_and_does_not_choose_the_type(stage):
    node = stage.ros.node
    stage.listener('recorder').listen(Twist, 'cmd_vel')
    stage.ros.until(lambda: node.count_subscribers('cmd_vel'))
    assert driver_type(node) is None
    stage.listener('create_cmd_vel').listen(TwistStamped, 'cmd_vel')
    stage.ros.until(lambda: node.count_subscribers('cmd_vel') == 2)
    assert driver_type(node) is None, 'no node create publishes its mode'
    stage.listener('create').node.create_publisher(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: driver_type(node))
    assert driver_type(node) is TwistStamped
    stage.listener('echo').listen(Twist, 'cmd_vel')
    stage.ros.until(lambda: node.count_subscribers('cmd_vel') == 3)
    assert driver_type(node) is TwistStamped
