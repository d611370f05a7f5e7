# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A coroutine that waits on the events executor, as a service or a goal would: `waiting.py`.

It prints `ready` and waits until SIGTERM; nothing else runs.
"""

import signal

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.task import Future

rclpy.init()
executor = EventsExecutor()
executor.add_node(rclpy.create_node('waiting'))


async def wait() -> None:
    """Wait for something that does not come."""
    await Future()


executor.create_task(wait)
signal.signal(signal.SIGTERM, signal.SIG_DFL)
print('ready', flush=True)
while True:
    executor.spin_once(timeout_sec=1000.0)
