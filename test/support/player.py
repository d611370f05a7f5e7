# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Plays a bag as `ros2 bag play` of Jazzy does, which the wheels do not have.

As in the sources of rosbag2, it offers each topic with the recorded quality of service, but with
a history of ten, and with the default one if recorded publishers differ in more than history. It
publishes the recorded bytes unchanged, in their order and at their pace.

    python player.py BAG

plays a bag as soon as every topic has a subscriber, and ends when everything has arrived.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
import sys
import time

import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rosbags.interfaces import Qos, QosTime
from rosbags.rosbag2 import Reader

DEPTH = 10
"""History that `ros2 bag play` offers, whatever was recorded."""
DEFAULT = QoSProfile(depth=DEPTH)
TIMEOUT = Duration(seconds=30)


@dataclass(frozen=True)
class Played:
    """A message of the bag."""

    time: int
    """When it was recorded, nanoseconds since the epoch."""
    topic: str
    raw: bytes


def messages(bag: Path) -> list[Played]:
    """Return all messages of a bag, in the order of recording."""
    with Reader(bag) as reader:
        return [Played(time, connection.topic, bytes(raw))
                for connection, time, raw in reader.messages()]


def offer(profiles: list[Qos]) -> QoSProfile:
    """Return the quality of service to offer, from those of the recorded publishers."""
    offers = {(each.reliability, each.durability, each.deadline, each.liveliness,
                each.liveliness_lease_duration) for each in profiles}
    if len(offers) != 1:
        return DEFAULT
    first = profiles[0]
    return QoSProfile(
        depth=DEPTH, reliability=ReliabilityPolicy[first.reliability.name],
        durability=DurabilityPolicy[first.durability.name], lifespan=duration(first.lifespan),
        deadline=duration(first.deadline), liveliness=LivelinessPolicy[first.liveliness.name],
        liveliness_lease_duration=duration(first.liveliness_lease_duration))


def duration(time: QosTime) -> Duration:
    """Convert a duration of the bag."""
    return Duration(seconds=time.sec, nanoseconds=time.nsec)


def message_class(name: str) -> type:
    """Return the class of a type such as nav_msgs/msg/Odometry."""
    package, _, kind = name.split('/')
    return getattr(import_module(f'{package}.msg'), kind)


class Player:
    """A node that publishes the topics of a bag, until `close`."""

    def __init__(self, bag: Path, domain: int | None = None) -> None:
        """Create the publishers; without a `domain`, in that of the environment."""
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = rclpy.create_node('player', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        # A new subscriber only wakes up `wait`.
        wakes = PublisherEventCallbacks(matched=lambda _: None)
        with Reader(bag) as reader:
            self.publishers = {
                each.topic: self._node.create_publisher(
                    message_class(each.msgtype), each.topic,
                    offer(each.ext.offered_qos_profiles), event_callbacks=wakes)
                for each in reader.connections}

    def subscribed(self) -> bool:
        """Return whether every topic has a subscriber."""
        return all(each.get_subscription_count() for each in self.publishers.values())

    def wait(self) -> None:
        """Wait until every topic has a subscriber."""
        while not self.subscribed():
            self._executor.spin_once()

    def play(self, played: Iterable[Played], *, paced: bool = True) -> None:
        """Publish messages; `paced`: with the delays of the recording."""
        ahead: float | None = None
        for each in played:
            now, recorded = time.monotonic(), each.time / 1e9
            ahead = recorded - now if ahead is None else ahead
            if paced:
                time.sleep(max(0.0, recorded - ahead - now))
            self.publishers[each.topic].publish(each.raw)

    def arrived(self) -> bool:
        """Wait until all subscribers have received everything; False: timeout."""
        return all(each.wait_for_all_acked(TIMEOUT) for each in self.publishers.values())

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def main(bag: Path) -> int:
    """Play a bag; 1: not everything arrived in time."""
    player = Player(bag)
    player.wait()
    player.play(messages(bag))
    arrived = player.arrived()
    player.close()
    return 0 if arrived else 1


if __name__ == '__main__':
    sys.exit(main(Path(sys.argv[1])))
