# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity commands are heard whoever publishes them: either type, either reliability."""

from collections.abc import Iterator
from contextlib import closing
import threading
from typing import Any

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Twist, TwistStamped, Vector3
import pytest
from rclpy.qos import qos_profile_sensor_data, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from create_oi_ros.ros.topics import LATCHED
from create_oi_ros.ros.velocity import driver_type, RELIABLE_CHECKS, VelocityInput
from support.ros import Listener, own_domain, TIMEOUT

RELIABLE, BEST_EFFORT = QoSProfile(depth=1), qos_profile_sensor_data


class Stage:
    """A node with a velocity input, whose publishers are looked at in each round of waiting."""

    def __init__(self, domain: int) -> None:
        self.domain = domain
        self.ros = Listener(domain)
        self.others: list[Listener] = []
        self.got: list[tuple[float, float]] = []
        self.failed = threading.Event()
        self.inputs: list[VelocityInput] = []

    def start(self) -> VelocityInput:
        """Subscribe, and take commands."""
        made = VelocityInput(self.ros.node, 'auto', self._on_command, on_failure=self.failed.set)
        self.inputs.append(made)
        made.start()
        return made

    def _on_command(self, linear: float, angular: float, stamp: Any) -> None:
        self.got.append((linear, angular))

    def publisher(self, type_: type) -> Any:
        """Return a function that publishes a speed, on a context of its own: that has one type."""
        self.others.append(Listener(self.domain, f'other{len(self.others)}'))
        made = self.others[-1].node.create_publisher(type_, 'cmd_vel', RELIABLE)

        def publish(speed: float) -> None:
            twist = Twist(linear=Vector3(x=speed), angular=Vector3(z=-speed))
            made.publish(twist if type_ is Twist else TwistStamped(twist=twist))
        publish.end = made.destroy  # type: ignore[attr-defined]
        return publish

    def hears(self, publish: Any, speed: float) -> None:
        """Publish until it is heard; meanwhile the input adapts to its publishers."""
        self.got.clear()

        def heard() -> bool:
            self.inputs[-1].adapt(self.ros.node.get_publishers_info_by_topic('cmd_vel'))
            publish(speed)
            return (speed, -speed) in self.got
        self.ros.until(heard)

    def close(self) -> None:
        """End it."""
        for each in self.inputs:
            each.close()
        for other in (self.ros, *self.others):
            other.close()


@pytest.fixture
def stage() -> Iterator[Stage]:
    """Return a stage in a domain of its own."""
    with own_domain() as domain, closing(Stage(domain)) as made:
        yield made


def test_types_follow_the_publishers_that_are_alone_and_stay_while_both_are_there(stage):
    made = stage.start()
    twist = stage.publisher(Twist)
    stage.hears(twist, 0.1)
    stamped = stage.publisher(TwistStamped)
    stage.hears(twist, 0.2)
    twist.end()
    stage.hears(stamped, 0.3)
    twist = stage.publisher(Twist)
    stage.hears(stamped, 0.4)
    assert made.type is TwistStamped
    stamped.end()
    stage.hears(twist, 0.5)


def endpoint(qos: QoSProfile = RELIABLE, type_: str = 'Twist') -> TopicEndpointInfo:
    """Return a publisher of this type."""
    return TopicEndpointInfo(topic_type=f'geometry_msgs/msg/{type_}', qos_profile=qos)


def test_best_effort_ends_when_all_have_been_reliable_for_a_while(stage):
    made = stage.start()
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
    stage.hears(stage.publisher(Twist), 0.2)


def test_close_waits_for_the_function(stage):
    entered, leave, left = threading.Event(), threading.Event(), threading.Event()

    def take(linear: float, angular: float, stamp: Any) -> None:
        entered.set()
        assert leave.wait(TIMEOUT)
        left.set()
    made = VelocityInput(stage.ros.node, 'twist', take, on_failure=stage.failed.set)
    never = VelocityInput(stage.ros.node, 'twist', take, on_failure=stage.failed.set)
    made.start()
    publish = stage.publisher(Twist)
    stage.ros.until(lambda: publish(0.1) or entered.is_set())
    threading.Timer(0.1, leave.set).start()
    for each in (made, never):
        each.close()
    assert left.is_set()
    assert not stage.failed.is_set()


# Who takes the commands: only a driver does, a node that publishes its mode.


class Others:
    """Nodes of other programs, each with a context of its own."""

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self._listeners: list[Listener] = []

    def node(self, name: str, *rules: str, takes: type | None = None, topic: str = 'cmd_vel',
             mode: str = '') -> Listener:
        """Add a node that takes velocities of a type from a topic, and publishes its mode."""
        made = Listener(self._domain, name, *rules)
        self._listeners.append(made)
        if takes is not None:
            made.listen(takes, topic)
        if mode:
            made.node.create_publisher(Mode, mode, LATCHED)
        return made

    def close(self) -> None:
        """End them, the newest first."""
        for each in reversed(self._listeners):
            each.close()


@pytest.fixture
def others(stage) -> Iterator[Others]:
    """Return the other programs of the graph, none yet."""
    with closing(Others(stage.domain)) as made:
        yield made


def test_a_listener_is_no_driver_and_does_not_choose_the_type(stage, others):
    others.node('recorder', takes=Twist)
    stage.ros.until(lambda: stage.ros.node.count_subscribers('cmd_vel'))
    assert driver_type(stage.ros.node) is None
    others.node('create_cmd_vel', takes=TwistStamped)
    stage.ros.until(lambda: stage.ros.node.count_subscribers('cmd_vel') == 2)
    assert driver_type(stage.ros.node) is None, 'no node create publishes its mode'
    others.node('create', mode='mode')
    stage.ros.until(lambda: driver_type(stage.ros.node))
    assert driver_type(stage.ros.node) is TwistStamped
    others.node('echo', takes=Twist)
    stage.ros.until(lambda: stage.ros.node.count_subscribers('cmd_vel') == 3)
    assert driver_type(stage.ros.node) is TwistStamped
