"""
Subscribes to topics of the driver and notes when messages come: `listener.py TOPIC ...`.

It says when it listens, and when it has heard something on each topic. On SIGTERM it prints, for
each topic, pairs of time (monotonic clock, seconds) and what of the message is looked at: whether
the bumper's left half is pressed, else nothing.
"""

from functools import partial
import json
import sys
from time import monotonic
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from create_oi_ros.ros.process import call_on_signal, spin_until
from create_oi_ros.ros.topics import PUBLISHED

TOPICS = {topic.name: topic for topic in PUBLISHED}
heard: dict[str, list[tuple[float, Any]]] = {name: [] for name in sys.argv[1:]}
silent = set(heard)


def hear(name: str, message: Any) -> None:
    """Note a message."""
    heard[name].append((monotonic(), getattr(message, 'left', None)))
    if name in silent:
        silent.remove(name)
        if not silent:
            print('hears', flush=True)


# With rclpy's own handlers the end is missed now and then, when nothing more comes.
ended = Future()
call_on_signal(lambda: ended.set_result(0))
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node('listener')
for name in heard:
    # The last part of a name in a namespace says which topic it is.
    topic = TOPICS.get(name) or TOPICS[name.rpartition('/')[2]]
    node.create_subscription(topic.type, name, partial(hear, name), topic.qos)
print('listens', flush=True)
executor = SingleThreadedExecutor()
executor.add_node(node)
spin_until(executor, ended)
print(json.dumps(heard))
