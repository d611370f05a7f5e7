"""
What is published with every frame: one message a topic, made once and filled again.

A topic that nobody listens to costs nothing but a look now and then whether that is still so.
Latched topics are published all the same, for those who come later.
"""

from collections.abc import Callable
from functools import partial
from math import inf
from operator import attrgetter
import time
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from sensor_msgs.msg import JointState

from tf2_msgs.msg import TFMessage

from ..driver import Moved
from ..oi import Readings
from . import messages, topics
from .parameters import Parameters
from .topics import EARLY, Edge, SensorTopic, Topic

LOOK_EVERY = 0.1
"""Seconds between two looks at who listens, and at the node's clock."""
AT_ONCE, MOST_LOOKS = 1e-4, 10
"""Seconds within which two clocks are read together, and how often that is tried."""


def publisher(node: Node, topic: Topic) -> Publisher:
    """
    Declare a topic to ROS.

    A subscriber that asks for what is not offered says so itself. For the publisher to say so too,
    the executor would have two more things to look at for every topic, at every command.
    """
    return node.create_publisher(
        topic.type, topic.name, topic.qos,
        event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))


class Outlet:
    """One topic, its message, and what fills it."""

    def __init__(self, node: Node, topic: Topic, message: Any,
                 fill: Callable[[Any], None]) -> None:
        """Declare the topic; `fill` fills the message."""
        self._publisher = publisher(node, topic)
        self._latched = topic.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        self._message, self._fill = message, fill
        self._content: object = None
        self.heard = False

    def look(self) -> None:
        """See whether somebody listens."""
        self.heard = self._latched or self._publisher.get_subscription_count() > 0

    def publish(self, content: Any) -> None:
        """Fill the message, and send a copy of it."""
        if content is not self._content:  # the estimate of a robot that stands
            self._fill(content)
            self._content = content
        self._publisher.publish(self._message)


class FramePublisher:
    """Publishes where the robot is, how it moves and what it senses, frame by frame."""

    def __init__(self, node: Node, parameters: Parameters, *, charge_known: bool) -> None:
        """Declare the topics; all messages share one stamp."""
        self._clock = node.get_clock()
        self._stamp = Time()
        self._offset = 0
        self._look_at = -inf
        self._odom, *self._motion = self._motion_outlets(node, parameters)
        self._sensors = [
            (Edge(topic), self._sensor_outlet(node, topic, parameters.base_frame))
            for topic in topics.sensor_topics(charge_known=charge_known)]
        self._watched = attrgetter(*topics.WATCHED)
        self._complete = False
        self._seen: object = None
        self._due_at = -inf
        self._look()

    def _motion_outlets(self, node: Node, parameters: Parameters) -> list[Outlet]:
        header, base = messages.header(parameters.odom_frame, self._stamp), parameters.base_frame
        odom = Odometry(header=header, child_frame_id=base)
        tf = TFMessage(transforms=[TransformStamped(header=header, child_frame_id=base)])
        joints = JointState(header=messages.header('', self._stamp))
        return [Outlet(node, topic, message, fill(message)) for topic, message, fill in (
            (topics.ODOM, odom, messages.odometry),
            *([(topics.TF, tf, messages.transforms)] if parameters.publish_tf else []),
            (topics.JOINT_STATES, joints, messages.joint_states))]

    def _sensor_outlet(self, node: Node, topic: SensorTopic, frame: str) -> Outlet:
        message = topic.type(header=messages.header(frame, self._stamp))
        return Outlet(node, topic, message, partial(topic.fill, message))

    def publish(self, moved: Moved, sensor_period: float) -> None:
        """Publish what a frame told; sensors that do not change, once in a period, s."""
        messages.set_time(
            self._stamp, self._offset + round(moved.stamp * messages.NANOSECONDS))
        # A bump must not wait for anything; what is only due again can.
        changed = self._changed(moved.readings)
        if changed:
            self._publish_sensors(moved, sensor_period)
        if self._odom.heard:
            self._odom.publish(moved.estimate)
        if not changed and moved.stamp >= self._due_at - EARLY:
            self._publish_sensors(moved, sensor_period)
        for outlet in self._motion:
            if outlet.heard:
                outlet.publish(moved.estimate)
        # Not before, since it takes a while.
        if moved.stamp >= self._look_at:
            self._look_at = moved.stamp + LOOK_EVERY
            self._look()

    def _changed(self, readings: Readings) -> bool:
        """Look at all that is watched at once, since most often nothing has changed."""
        self._complete = self._complete or readings.has(*topics.WATCHED)
        if not self._complete:
            return True
        before, self._seen = self._seen, self._watched(readings)
        return self._seen != before

    def _publish_sensors(self, moved: Moved, sensor_period: float) -> None:
        for edge, outlet in self._sensors:
            if outlet.heard and edge.due(moved.readings, moved.stamp, sensor_period):
                outlet.publish(moved.readings)
        self._due_at = min((edge.due_at for edge, outlet in self._sensors if outlet.heard),
                           default=inf)

    def _look(self) -> None:
        """See who listens, and how far the node's clock is from the driver's."""
        self._due_at = -inf  # somebody may listen now who did not before
        for outlet in (self._odom, *self._motion):
            outlet.look()
        for _, outlet in self._sensors:
            outlet.look()
        for _ in range(MOST_LOOKS):
            before, now = time.monotonic_ns(), self._clock.now().nanoseconds
            after = time.monotonic_ns()
            # On a busy computer much time may pass between two looks at two clocks.
            if after - before < AT_ONCE * messages.NANOSECONDS:
                break
        self._offset = now - (before + after) // 2
