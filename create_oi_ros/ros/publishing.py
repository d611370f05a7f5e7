# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Publishes frames: one message for each topic, made once and filled again, as bytes.

A topic without subscribers is not published; how many there are is checked ten times a second.
Latched topics are always published, for subscribers that come later.
"""

from collections.abc import Callable
from math import inf
import time
from typing import Any

from rclpy.clock import ROSClock
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message

from ..driver import Moved
from ..oi import Readings
from . import messages, topics
from .messages import Content
from .parameters import Parameters
from .serialized import Fill, filling, is_number, Packing, packing, PLEASE_REPORT
from .topics import EARLY, Pace, Topic, TopicWatch

CHECK_INTERVAL = 0.1
"""Seconds between two checks of subscribers, and of the node's clock."""
CLOCK_SPREAD, CLOCK_TRIES = 1e-4, 10
"""Seconds within which two clocks must be read together, and how often that is tried."""
CLOCK_WARNING_INTERVAL = 5.0
"""Seconds between two warnings about the node's clock."""
CLOCK_JITTER = 1_000_000
"""Nanoseconds by which stamps may seem to go back without a jump of the clock."""


def publisher(node: Node, topic: Topic) -> Publisher:
    """Create the publisher of a topic."""
    return node.create_publisher(topic.type, topic.name, topic.qos)


def cheapest(node: Node, message: Any, paths: tuple[str, ...]) -> Fill:
    """Return what fills a message: as bytes where all that changes are numbers."""
    if all(is_number(message, path) for path in paths):
        try:
            return packing(message, paths, serialize_message, deserialize_message)
        except ValueError as error:
            node.get_logger().warning(
                f'{type(message).__name__}: {error}. It is published as an object instead, '
                f'{PLEASE_REPORT}')
    return filling(message, paths)


def sending(publisher: Publisher, fill: Fill) -> Callable[[Any], None]:
    """
    Return what publishes the messages of a function that fills them.

    For bytes it is what `Publisher.publish` calls itself, after it has guarded the publisher
    against being destroyed meanwhile. A node's publishers last until its session has ended.
    """
    send: Callable[[Any], None] = publisher.publish
    if isinstance(fill, Packing):
        send = publisher.handle.publish_raw
    return send


class StampClock:
    """
    Gives frames their stamps, ns in the node's time.

    The computer's clock is compared with the driver's, so that stamps say when a frame left the
    robot. A simulated one (`use_sim_time`) may run at any speed: a frame gets its newest value.
    """

    def __init__(self, node: Node) -> None:
        """Take the clock of a node."""
        clock = node.get_clock()
        assert isinstance(clock, ROSClock), 'the clock of every node'
        self._clock = clock
        self._log = node.get_logger()
        self._offset = 0
        self._measure_at = -inf
        self.newest: int | None = None
        """Stamp of the newest frame; None before the first."""

    def now(self) -> int | None:
        """Return the time; None while nobody publishes the simulated one."""
        return self._clock.now().nanoseconds or None

    def of_frame(self, stamp: float) -> int | None:
        """Return the stamp of a frame that left the robot at this moment, s, of the driver."""
        if self._clock.ros_time_is_active:
            found = self.now()
        else:
            if stamp >= self._measure_at:
                self._measure_at = stamp + CHECK_INTERVAL
                self._measure()
            found = self._offset + round(stamp * messages.NANOSECONDS)
        if found is not None and self.newest is not None and found < self.newest:
            if self.newest - found > CLOCK_JITTER:
                self._log.warning(
                    f'the clock went back by {(self.newest - found) / messages.NANOSECONDS:.3f} '
                    's: stamps follow it',
                    throttle_duration_sec=CLOCK_WARNING_INTERVAL)
            else:
                found = self.newest + 1
        self.newest = found
        return found

    def _measure(self) -> None:
        """Measure the node's clock against the driver's."""
        for _ in range(CLOCK_TRIES):
            before, now = time.monotonic_ns(), self._clock.now().nanoseconds
            after = time.monotonic_ns()
            # On a busy computer much time may pass between reading two clocks.
            if after - before < CLOCK_SPREAD * messages.NANOSECONDS:
                break
        self._offset = now - (before + after) // 2


class FilledTopic:
    """One topic, its message, and what fills it."""

    def __init__(self, node: Node, topic: Topic, message: Any, content: Content, *,
                 header: str = 'header') -> None:
        """Create the publisher; `header` is the path of the message's header."""
        made = publisher(node, topic)
        self._latched = topic.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        self._count = made.handle.get_subscription_count
        stamp = tuple(f'{header}.{path}' for path in messages.STAMP)
        self._fill = cheapest(node, message, stamp + content.paths)
        self._send = sending(made, self._fill)
        self._content = content.values
        self.filled_from: object = None
        """The estimate or the readings of the last message."""
        self._values: tuple[Any, ...] = ()
        self.heard = self.wanted = False
        """Whether there are subscribers; whether that, or the topic is latched."""

    def check(self) -> None:
        """Look whether there are subscribers."""
        self.heard = self._count() > 0
        self.wanted = self._latched or self.heard

    def publish(self, stamp: tuple[int, int], source: Any) -> None:
        """Publish the message with this stamp; `source` is an estimate or readings."""
        if source is not self.filled_from:  # a robot that stands has the same estimate again
            self._values = self._content(source)
            self.filled_from = source
        self._send(self._fill(*stamp, *self._values))


WatchedTopic = tuple[TopicWatch, FilledTopic]
Group = tuple[Pace, list[WatchedTopic]]
"""Topics that are published in the same frames, though nothing has changed."""


class FramePublisher:
    """Publishes where the robot is, how it moves and what it senses, frame by frame."""

    def __init__(self, node: Node, parameters: Parameters, *, charge_known: bool) -> None:
        """Create the publishers."""
        self.stamps = StampClock(node)
        self._check_at = -inf
        self._odom, *self._motion = self._motion_topics(node, parameters)
        self._motion_pace = Pace()
        self._sensors: list[WatchedTopic] = []
        self._groups: dict[float | None, Group] = {}
        for topic in topics.sensor_topics(charge_known=charge_known):
            filled = FilledTopic(
                node, topic, messages.empty(topic.type, parameters.base_frame), topic.content)
            self._sensors.append((TopicWatch(topic), filled))
            if topic.period != inf:
                group = self._groups.setdefault(topic.period, (Pace(), []))
                group[1].append(self._sensors[-1])
        self._watched = Readings.numbers(*topics.WATCHED)
        self._complete = False
        self._seen: object = None
        self._due_at = -inf
        self._hears_sensors = False
        """Whether somebody hears a topic that is also published when nothing has changed."""
        self._check()

    @staticmethod
    def _motion_topics(node: Node, parameters: Parameters) -> list[FilledTopic]:
        frames = parameters.odom_frame, parameters.base_frame
        odom = FilledTopic(
            node, topics.ODOM, messages.empty_odometry(*frames), messages.odometry)
        joints = FilledTopic(
            node, topics.JOINT_STATES, messages.empty_joint_states(), messages.joint_states)
        if not parameters.publish_tf:
            return [odom, joints]
        tf = FilledTopic(
            node, topics.TF, messages.empty_transforms(*frames), messages.transforms,
            header='transforms[0].header')
        return [odom, tf, joints]

    @property
    def due_at(self) -> float:
        """Stamp, s, from which on a frame is to be published that says nothing new."""
        sensors_due_at = self._due_at if self._hears_sensors else inf
        return min(self._motion_pace.due_at, sensors_due_at) - EARLY

    def publish(self, moved: Moved, sensor_period: float, motion_period: float) -> int | None:
        """
        Publish a frame, and return its stamp, ns; None, and nothing published, without a time.

        Sensors that do not change are published once in `sensor_period` seconds, the estimate
        and the joints once in `motion_period`; 0 is in every frame. While a simulated clock
        stands, only changes are published.
        """
        before, now = self.stamps.newest, self.stamps.of_frame(moved.stamp)
        if now is None:
            return None
        stamp = messages.stamp(now)
        # A change, such as a bump, must not wait; what is only due again can.
        if self._changed(moved.readings):
            self._publish_changed(moved.readings, stamp)
        passes = now != before
        motion_due = passes and (not motion_period or self._motion_pace.due(moved.stamp))
        if motion_due and motion_period:
            self._motion_pace.done(moved.stamp, motion_period)
        if motion_due and self._odom.wanted:
            self._odom.publish(stamp, moved.estimate)
        if passes and moved.stamp >= self._due_at - EARLY:
            self._publish_due(moved, stamp, sensor_period)
        for filled in self._motion:
            if motion_due and filled.wanted:
                filled.publish(stamp, moved.estimate)
        # Last, since it takes a while.
        if moved.stamp >= self._check_at:
            self._check_at = moved.stamp + CHECK_INTERVAL
            self._check()
        return now

    def _changed(self, readings: Readings) -> bool:
        """Compare all watched values at once, since most often nothing has changed."""
        self._complete = self._complete or readings.has(*topics.NEEDED)
        if not self._complete:
            return True
        before, self._seen = self._seen, self._watched(readings)
        return self._seen != before

    def _publish_changed(self, readings: Readings, stamp: tuple[int, int]) -> None:
        """Publish the topics of which a watched reading has changed."""
        for watch, filled in self._sensors:
            if watch.changed(readings) and filled.wanted:
                filled.publish(stamp, readings)

    def _publish_due(
        self, moved: Moved, stamp: tuple[int, int], sensor_period: float,
    ) -> None:
        """Publish the topics whose time has come; those of one period come in one frame."""
        for period, (pace, members) in self._groups.items():
            if not pace.due(moved.stamp):
                continue
            pace.done(moved.stamp, period or sensor_period)
            for watch, filled in members:
                if filled.wanted and watch.complete and filled.filled_from is not moved.readings:
                    filled.publish(stamp, moved.readings)
        self._due_at = min(pace.due_at for pace, _ in self._groups.values())

    def _check(self) -> None:
        """Check for subscribers."""
        for filled in (self._odom, *self._motion):
            filled.check()
        for _, filled in self._sensors:
            filled.check()
        self._hears_sensors = any(
            filled.heard for _, members in self._groups.values() for _, filled in members)
