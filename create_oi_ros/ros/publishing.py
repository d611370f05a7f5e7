"""
Publishes frames: one message for each topic, made once and filled again.

A topic without subscribers is not published; how many there are is checked ten times a second.
Latched topics are always published, for subscribers that come later.
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
from .topics import EARLY, Schedule, SensorTopic, Topic

CHECK_INTERVAL = 0.1
"""Seconds between two checks of subscribers and of the node's clock."""
CLOCK_SPREAD, CLOCK_TRIES = 1e-4, 10
"""Seconds within which two clocks must be read together, and how often that is tried."""


def publisher(node: Node, topic: Topic) -> Publisher:
    """
    Create the publisher of a topic, without its event callbacks.

    A subscriber with incompatible QoS reports it. With event callbacks the publisher would too,
    but the executor would have two more entities to check for every topic, at every command.
    """
    return node.create_publisher(
        topic.type, topic.name, topic.qos,
        event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))


class FilledTopic:
    """One topic, its message, and what fills it."""

    def __init__(self, node: Node, topic: Topic, message: Any,
                 fill: Callable[[Any], None]) -> None:
        """Create the publisher; `fill` fills the message."""
        self._publisher = publisher(node, topic)
        self._latched = topic.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        self._message, self._fill = message, fill
        self._content: object = None
        self.wanted = False
        """Whether there are subscribers, or the topic is latched."""

    def check(self) -> None:
        """Look whether there are subscribers."""
        self.wanted = self._latched or self._publisher.get_subscription_count() > 0

    def publish(self, content: Any) -> None:
        """Fill the message and publish it."""
        if content is not self._content:  # a robot that stands has the same estimate again
            self._fill(content)
            self._content = content
        self._publisher.publish(self._message)


class FramePublisher:
    """Publishes where the robot is, how it moves and what it senses, frame by frame."""

    def __init__(self, node: Node, parameters: Parameters, *, charge_known: bool) -> None:
        """Create the publishers; all messages share one stamp."""
        self._clock = node.get_clock()
        self._stamp = Time()
        self._offset = 0
        self._check_at = -inf
        self._odom, *self._motion = self._motion_topics(node, parameters)
        self._sensors = [
            (Schedule(topic), self._sensor_topic(node, topic, parameters.base_frame))
            for topic in topics.sensor_topics(charge_known=charge_known)]
        self._watched = attrgetter(*topics.WATCHED)
        self._complete = False
        self._seen: object = None
        self._due_at = -inf
        self._check()

    def _motion_topics(self, node: Node, parameters: Parameters) -> list[FilledTopic]:
        header, base = messages.header(parameters.odom_frame, self._stamp), parameters.base_frame
        odom = Odometry(header=header, child_frame_id=base)
        tf = TFMessage(transforms=[TransformStamped(header=header, child_frame_id=base)])
        joints = JointState(header=messages.header('', self._stamp))
        return [FilledTopic(node, topic, message, fill(message)) for topic, message, fill in (
            (topics.ODOM, odom, messages.odometry),
            *([(topics.TF, tf, messages.transforms)] if parameters.publish_tf else []),
            (topics.JOINT_STATES, joints, messages.joint_states))]

    def _sensor_topic(self, node: Node, topic: SensorTopic, frame: str) -> FilledTopic:
        message = topic.type(header=messages.header(frame, self._stamp))
        return FilledTopic(node, topic, message, partial(topic.fill, message))

    def publish(self, moved: Moved, sensor_period: float) -> None:
        """Publish a frame; sensors that do not change, once in `sensor_period` seconds."""
        messages.set_time(
            self._stamp, self._offset + round(moved.stamp * messages.NANOSECONDS))
        # A change, such as a bump, must not wait; what is only due again can.
        changed = self._changed(moved.readings)
        if changed:
            self._publish_sensors(moved, sensor_period)
        if self._odom.wanted:
            self._odom.publish(moved.estimate)
        if not changed and moved.stamp >= self._due_at - EARLY:
            self._publish_sensors(moved, sensor_period)
        for filled in self._motion:
            if filled.wanted:
                filled.publish(moved.estimate)
        # Last, since it takes a while.
        if moved.stamp >= self._check_at:
            self._check_at = moved.stamp + CHECK_INTERVAL
            self._check()

    def _changed(self, readings: Readings) -> bool:
        """Compare all watched values at once, since most often nothing has changed."""
        self._complete = self._complete or readings.has(*topics.WATCHED)
        if not self._complete:
            return True
        before, self._seen = self._seen, self._watched(readings)
        return self._seen != before

    def _publish_sensors(self, moved: Moved, sensor_period: float) -> None:
        for schedule, filled in self._sensors:
            if filled.wanted and schedule.due(moved.readings, moved.stamp, sensor_period):
                filled.publish(moved.readings)
        due_times = (schedule.due_at for schedule, filled in self._sensors if filled.wanted)
        self._due_at = min(due_times, default=inf)

    def _check(self) -> None:
        """Check for subscribers; measure the node's clock against the driver's."""
        self._due_at = -inf  # there may be a new subscriber
        for filled in (self._odom, *self._motion):
            filled.check()
        for _, filled in self._sensors:
            filled.check()
        for _ in range(CLOCK_TRIES):
            before, now = time.monotonic_ns(), self._clock.now().nanoseconds
            after = time.monotonic_ns()
            # On a busy computer much time may pass between reading two clocks.
            if after - before < CLOCK_SPREAD * messages.NANOSECONDS:
                break
        self._offset = now - (before + after) // 2
