# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Subscribes to topics and logs when messages arrive: `listener.py [TOPIC ...]`; without any, to all.

It subscribes to each topic once somebody publishes it. On SIGTERM it prints JSON: for each topic a
list of pairs. A pair is the time (monotonic clock, seconds) and, for `bumper`, whether the left
half is pressed, else null.
"""

from functools import partial
from importlib import import_module
import json
import sys
from time import monotonic
from typing import Any

import rclpy
from rclpy.qos import QoSProfile
from rclpy.task import Future

from create_oi_ros.ros.process import call_on_signal, ros_executor, spin_until

LOOK_INTERVAL = 0.2
OTHERS = ('cmd_vel', 'rosout', 'parameter_events')
"""Topics that every driver has beside its own."""
wanted = sys.argv[1:]
received: dict[str, list[tuple[float, Any]]] = {name: [] for name in wanted}
taken: set[str] = set()


def log(name: str, message: Any) -> None:
    received[name].append((monotonic(), getattr(message, 'left', None)))


def look() -> None:
    """Subscribe to what is published since the last look."""
    for topic, (type_, *_) in node.get_topic_names_and_types():
        name = topic.removeprefix('/')
        hidden = '/_' in topic or name in OTHERS
        publishers = node.get_publishers_info_by_topic(topic)
        if name in taken or not publishers or (name not in wanted if wanted else hidden):
            continue
        package, _, kind = type_.split('/')
        taken.add(name)
        received.setdefault(name, [])
        node.create_subscription(
            getattr(import_module(f'{package}.msg'), kind), name, partial(log, name),
            QoSProfile(depth=50, reliability=publishers[0].qos_profile.reliability),
            raw=not wanted)


# rclpy's own signal handlers sometimes miss the signal when no more messages arrive.
ended = Future()
call_on_signal(lambda: ended.set_result(0))
with ros_executor() as executor:
    node = rclpy.create_node('listener')
    node.create_timer(LOOK_INTERVAL, look)
    executor.add_node(node)
    spin_until(executor, ended)
print(json.dumps(received))
