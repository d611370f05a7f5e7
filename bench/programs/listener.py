"""
Subscribes to topics of the driver and notes when messages come: `listener.py TOPIC ...`.

On SIGTERM it prints, for each topic, pairs of time (monotonic clock, seconds) and what of the
message is looked at: whether the bumper's left half is pressed, else nothing.
"""

from contextlib import suppress
from functools import partial
import json
import sys
from time import monotonic
from typing import Any

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException

from create_oi_ros.topics import PUBLISHED

TOPICS = {topic.name: topic for topic in PUBLISHED}
heard: dict[str, list[tuple[float, Any]]] = {name: [] for name in sys.argv[1:]}


def hear(name: str, message: Any) -> None:
    """Note a message."""
    heard[name].append((monotonic(), getattr(message, 'left', None)))


rclpy.init()
node = rclpy.create_node('listener')
for name in heard:
    # The last part of a name in a namespace says which topic it is.
    topic = TOPICS.get(name) or TOPICS[name.rpartition('/')[2]]
    node.create_subscription(topic.type, name, partial(hear, name), topic.qos)
print('listens', flush=True)
# The context ends on SIGTERM, wherever the executor is just then.
with suppress(ExternalShutdownException, RCLError):
    rclpy.spin(node)
print(json.dumps(heard))
