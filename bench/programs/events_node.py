# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The node on the events executor of `rclpy.experimental`: `events_node.py [ROS ARGUMENTS]`.

Only for measuring: this executor does not run coroutines, so services are not answered.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from create_oi_ros.ros import node

LONG = 1000.0
"""Seconds; without a timeout this executor does not sleep."""


@contextmanager
def ros_executor() -> Iterator[Any]:
    """Replace the one in `ros.process`."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    executor = EventsExecutor()
    yield executor
    executor.shutdown()
    rclpy.shutdown()


def spin_until(executor: Any, ended: Future) -> None:
    """Replace the one in `ros.process`."""
    ended.add_done_callback(lambda _: executor.wake())
    while not ended.done():
        executor.spin_once(timeout_sec=LONG)


node.ros_executor, node.spin_until = ros_executor, spin_until
raise SystemExit(node.main())
