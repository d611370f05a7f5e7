"""
Plays a bag into the graph as `ros2 bag play` of Jazzy does; that itself cannot be installed here.

What it does of its own accord is from the sources of rosbag2: it offers each topic with the
recorded quality of service, but always with a history of ten; with rosbag2's own one where
recorded publishers differ in what matters; and it publishes the bytes as they are, in the order
in which they were recorded, each at its time.

    python player.py BAG

plays a bag, once somebody listens to every topic, and ends when all has arrived.
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
"""Of the history that `ros2 bag play` offers, whatever was recorded."""
DEFAULT = QoSProfile(depth=DEPTH)
PATIENCE = Duration(seconds=30)


@dataclass(frozen=True)
class Played:
    """A message as it is in the bag."""

    time: int
    """Nanoseconds since the epoch at which it was recorded."""
    topic: str
    raw: bytes


def messages(bag: Path) -> list[Played]:
    """Return all that is in a bag, in the order of recording."""
    with Reader(bag) as reader:
        return [Played(time, connection.topic, bytes(raw))
                for connection, time, raw in reader.messages()]


def offer(profiles: list[Qos]) -> QoSProfile:
    """Return what to offer for a topic, of whose publishers these were the offers."""
    matters = {(each.reliability, each.durability, each.deadline, each.liveliness,
                each.liveliness_lease_duration) for each in profiles}
    if len(matters) != 1:
        return DEFAULT
    first = profiles[0]
    return QoSProfile(
        depth=DEPTH, reliability=ReliabilityPolicy[first.reliability.name],
        durability=DurabilityPolicy[first.durability.name], lifespan=duration(first.lifespan),
        deadline=duration(first.deadline), liveliness=LivelinessPolicy[first.liveliness.name],
        liveliness_lease_duration=duration(first.liveliness_lease_duration))


def duration(time: QosTime) -> Duration:
    """Return a duration of the bag."""
    return Duration(seconds=time.sec, nanoseconds=time.nsec)


def message_class(name: str) -> type:
    """Return the class of a type such as nav_msgs/msg/Odometry."""
    package, _, kind = name.split('/')
    return getattr(import_module(f'{package}.msg'), kind)


class Player:
    """A node that offers what is in a bag, from its making until `close`."""

    def __init__(self, bag: Path, domain: int | None = None) -> None:
        """Offer every topic; `domain`: else that of the environment."""
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = rclpy.create_node('player', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        # Nothing is done when somebody comes, but `wait` wakes up.
        wakes = PublisherEventCallbacks(matched=lambda _: None)
        with Reader(bag) as reader:
            self.publishers = {
                each.topic: self._node.create_publisher(
                    message_class(each.msgtype), each.topic,
                    offer(each.ext.offered_qos_profiles), event_callbacks=wakes)
                for each in reader.connections}

    def heard(self) -> bool:
        """Tell whether somebody listens to every topic."""
        return all(each.get_subscription_count() for each in self.publishers.values())

    def wait(self) -> None:
        """Wait until somebody listens to every topic."""
        while not self.heard():
            self._executor.spin_once()

    def play(self, played: Iterable[Played], *, paced: bool = True) -> None:
        """Publish messages, each as long after the first as when it was recorded."""
        ahead: float | None = None
        for each in played:
            now, recorded = time.monotonic(), each.time / 1e9
            ahead = recorded - now if ahead is None else ahead
            if paced:
                time.sleep(max(0.0, recorded - ahead - now))
            self.publishers[each.topic].publish(each.raw)

    def arrived(self) -> bool:
        """Wait until all who listen have got everything; False: they have not."""
        return all(each.wait_for_all_acked(PATIENCE) for each in self.publishers.values())

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def main(bag: Path) -> int:
    """Play a bag; 1: not everything has arrived."""
    player = Player(bag)
    player.wait()
    player.play(messages(bag))
    arrived = player.arrived()
    player.close()
    return 0 if arrived else 1


if __name__ == '__main__':
    sys.exit(main(Path(sys.argv[1])))
