# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Publishes frames: one message for each topic, made once and filled again.

A topic without subscribers is not published, but changes of latched topics always are, for
subscribers that come later.
"""

from collections.abc import Callable
from copy import copy
from functools import partial
from math import inf
import time
from typing import Any

from builtin_interfaces.msg import Time as Stamp
from rclpy.clock import ROSClock
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from ..driver import Moved
from ..driver.contacts import Contacts
from ..link.session import CLOCK
from ..oi import Readings
from ..robot import SLOT
from . import messages, topics
from .parameters import Parameters
from .topics import SensorTopic, Topic

CHECK_INTERVAL = 0.1
"""Seconds between two comparisons of the clocks."""
CLOCK_SPREAD, CLOCK_TRIES = 1e-4, 10
"""Seconds within which two clocks must be read together, and how often that is tried."""
CLOCK_WARNING_INTERVAL = 5.0
"""Seconds between two warnings about a clock."""
CLOCK_JITTER = 1_000_000
"""Nanoseconds by which stamps may seem to go back without a jump of the clock."""
EARLY = SLOT / 2
"""Seconds before its due time at which a topic may be published: it takes the nearest frame."""
EMPTY_PERIOD = 1.0
"""Seconds between two messages of `contacts` without points."""


def publisher(node: Node, topic: Topic) -> Publisher:
    return node.create_publisher(
        topic.type, topic.name, copy(topic.qos),  # rclpy changes it as `qos_overrides` say
        qos_overriding_options=QoSOverridingOptions(topic.overridable))


class StampClock:
    """
    Gives frames their stamps, ns in the node's time.

    The computer's clock is compared with the driver's, so that stamps say when a frame left the
    robot. A simulated one (`use_sim_time`) may run at any speed: a frame gets its newest value.
    """

    def __init__(self, node: Node) -> None:
        clock = node.get_clock()
        assert isinstance(clock, ROSClock), 'the clock of every node'
        self._clock = clock
        self._log = node.get_logger()
        self._offset = 0
        """Nanoseconds from the driver's clock to the node's."""
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
                self._offset = self._measured()
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

    def _measured(self) -> int:
        """Return by how many nanoseconds the node's clock is ahead of the driver's."""
        for _ in range(CLOCK_TRIES):
            before, now = time.clock_gettime_ns(CLOCK), self._clock.now().nanoseconds
            after = time.clock_gettime_ns(CLOCK)
            # On a busy computer much time may pass between reading two clocks.
            if after - before < CLOCK_SPREAD * messages.NANOSECONDS:
                break
        return now - (before + after) // 2


class Pace:
    """Tells when something is due that happens once in a period, in the nearest frame."""

    def __init__(self) -> None:
        self._due_at = -inf

    def due(self, stamp: float, period: float) -> bool:
        """Return whether it is due in the frame with this stamp, s; if so, it counts as done."""
        if stamp < self._due_at - EARLY:
            return False
        # Count the period from the due time, not from the frame: the mean rate is exact.
        next_at = self._due_at + period
        self._due_at = next_at if next_at > stamp else stamp + period
        return True


class FrameTopic:
    """Publishes one topic: its message, filled from a frame."""

    def __init__(self, node: Node, topic: Topic, message: Any,
                 fill: Callable[[Any, Any], None]) -> None:
        """Create the publisher; `fill` sets all but the stamp, from an estimate or readings."""
        self.publisher = publisher(node, topic)
        self._message, self._fill = message, fill
        stamped = message.transforms[0] if topic is topics.TF else message
        self._stamp: Stamp = stamped.header.stamp

    @property
    def heard(self) -> bool:
        """Whether there are subscribers."""
        return self.publisher.get_subscription_count() > 0

    def publish(self, stamp: int, source: Any) -> None:
        """Publish the message of an estimate or of readings with this stamp, ns."""
        self._stamp.sec, self._stamp.nanosec = divmod(stamp, messages.NANOSECONDS)
        self._fill(self._message, source)
        self.publisher.publish(self._message)


class SensorFrameTopic(FrameTopic):
    """Publishes a topic that is made from readings: when they change, else when it is told to."""

    def __init__(self, node: Node, topic: SensorTopic, parameters: Parameters) -> None:
        message = topic.type(header=Header(frame_id=parameters.base_frame))
        fill = topic.fill
        if topic.type is BatteryState:
            fill = partial(messages.battery_state, charge_known=parameters.charge_known)
        super().__init__(node, topic, message, fill)
        self.topic = topic
        self.pace = Pace()
        self._watched = Readings.numbers(*topic.watch)
        self.last: tuple[int, ...] = ()
        """Watched readings at the last change; none before all that it needs have arrived."""

    def publish_change(self, stamp: int, readings: Readings) -> bool:
        """
        Publish it if a watched reading has changed; return whether it has.

        The first time is when all that it needs have arrived.
        """
        if not self.last and not readings.has(*self.topic.watch, *self.topic.needs):
            return False
        watched = self._watched(readings)
        if self.topic.bits is not None:
            watched = (watched[0] & self.topic.bits,)
        changed = watched != self.last
        if changed:
            self.last = watched
            if self.heard or self.topic.latched:
                self.publish(stamp, readings)
        return changed


class ContactTopic(FrameTopic):
    """Publishes what the robot has felt, as points: when their number changes, else when due."""

    def __init__(self, node: Node, parameters: Parameters) -> None:
        cloud = messages.empty_contacts(parameters.base_frame)
        super().__init__(node, topics.CONTACTS, cloud, messages.contacts)
        self._contacts = Contacts()
        self._count, self._due_at = 0, -inf

    def take(self, moved: Moved, stamp: int, parameters: Parameters) -> None:
        """Take a frame in, with its stamp, ns; publish what is felt when it is due."""
        self._contacts.update(
            moved.readings, moved.estimate, moved.stamp, parameters.contact_persistence)
        points = self._contacts.points(moved.estimate)
        if len(points) != self._count or moved.stamp >= self._due_at:
            self._count = len(points)
            self._due_at = moved.stamp + (1 / parameters.sensor_rate if points else EMPTY_PERIOD)
            self.publish(stamp, points)


class FramePublisher:
    """Publishes where the robot is, how it moves and what it senses, frame by frame."""

    def __init__(self, node: Node, parameters: Parameters) -> None:
        self.stamps = StampClock(node)
        frames = parameters.odom_frame, parameters.base_frame
        self._motion = [FrameTopic(
            node, topics.ODOM, messages.empty_odometry(*frames), messages.odometry)]
        if parameters.publish_tf:
            self._motion.append(FrameTopic(
                node, topics.TF, messages.empty_transforms(*frames), messages.transforms))
        self._motion.append(FrameTopic(
            node, topics.JOINT_STATES, messages.empty_joint_states(), messages.joint_states))
        self._imu: FrameTopic | None = None
        if parameters.gyro != 'none':
            imu = messages.empty_imu(parameters.base_frame)
            self._imu = FrameTopic(node, topics.IMU, imu, messages.imu)
        self._sensors = [SensorFrameTopic(node, topic, parameters)
                         for topic in topics.SENSOR_TOPICS]
        # A StateTopic is published on change only.
        self._repeated = [each for each in self._sensors if each.topic.period != inf]
        self._contacts = ContactTopic(node, parameters)
        self._motion_pace = Pace()

    def publish(self, moved: Moved, parameters: Parameters) -> None:
        """
        Publish a frame; nothing without a time.

        Sensors that do not change are published at `sensor_rate`, the estimate and the joints at
        `odom_rate`; 0 is in every frame. While a simulated clock stands, only changes are
        published.
        """
        before, stamp = self.stamps.newest, self.stamps.of_frame(moved.stamp)
        if stamp is None:
            return
        # A change, such as a bump, must not wait; what is only due again can.
        changed = [sensor for sensor in self._sensors
                   if sensor.publish_change(stamp, moved.readings)]
        if stamp != before:
            rate = parameters.odom_rate
            if not rate or self._motion_pace.due(moved.stamp, 1 / rate):
                for topic in self._motion:
                    if topic.heard:
                        topic.publish(stamp, moved.estimate)
            if self._imu is not None and self._imu.heard and moved.estimate.gyro is not None:
                self._imu.publish(stamp, moved.estimate)
            for sensor in self._repeated:
                period = sensor.topic.period or 1 / parameters.sensor_rate
                if (sensor.pace.due(moved.stamp, period) and sensor.heard and sensor.last
                        and sensor not in changed):
                    sensor.publish(stamp, moved.readings)
        if self._contacts.heard:
            self._contacts.take(moved, stamp, parameters)

    def repeat(self) -> None:
        """Publish every sensor in the next frame, as if all had changed."""
        for sensor in self._sensors:
            sensor.last = ()
