# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Several drivers in one process, all on one executor: `together.py PORT ...`."""

import sys

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from create_oi_ros.ros.node import CreateNode
from create_oi_ros.ros.process import call_on_signal, spin_until

ended = Future()
call_on_signal(lambda: ended.set_result(0))
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
nodes = [
    CreateNode(ended, namespace=f'robot{number}', cli_args=['--ros-args', '-p', f'port:={port}'])
    for number, port in enumerate(sys.argv[1:], 1)]
executor = SingleThreadedExecutor()
for each in nodes:
    executor.add_node(each)
    each.start()
spin_until(executor, ended)
for each in nodes:
    each.stop()
