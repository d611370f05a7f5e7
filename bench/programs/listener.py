# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Subscribes to topics of the driver and logs when messages arrive: `listener.py TOPIC ...`.

It prints `subscribed`, then `received` once every topic has had a message. On SIGTERM it prints
JSON: for each topic a list of pairs. A pair is the time (monotonic clock, seconds) and, for
`bumper`, whether the left half is pressed, else null.
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
received: dict[str, list[tuple[float, Any]]] = {name: [] for name in sys.argv[1:]}
silent = set(received)


def log(name: str, message: Any) -> None:
    received[name].append((monotonic(), getattr(message, 'left', None)))
    if name in silent:
        silent.remove(name)
        if not silent:
            print('received', flush=True)


# rclpy's own signal handlers sometimes miss the signal when no more messages arrive.
ended = Future()
call_on_signal(lambda: ended.set_result(0))
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node('listener')
for name in received:
    node.create_subscription(TOPICS[name].type, name, partial(log, name), TOPICS[name].qos)
print('subscribed', flush=True)
executor = SingleThreadedExecutor()
executor.add_node(node)
spin_until(executor, ended)
print(json.dumps(received))
