# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Start-up time of the node: `python bench/bench_start.py`, 30 seconds, a table.

Measured from the start of the process to its first `odom` in a listener that runs already. For
comparison: Python alone, rclpy with an empty node, the imports, and the floor (programs/floor.py)
to its first `odom`.
"""

import os
import subprocess
import sys
from time import monotonic, sleep

from results import Figure, repeated, run
from scene import DOMAIN, scene

REPETITIONS = 5
BARE_NODE = 'import rclpy; rclpy.init(); rclpy.create_node("bare"); rclpy.shutdown()'
OURS = 'import create_oi_ros.ros.node'
THEIRS = (
    'import rclpy.executors, rclpy.node, serial; from nav_msgs.msg import Odometry; '
    'from geometry_msgs.msg import Twist; from sensor_msgs.msg import JointState; '
    'from diagnostic_msgs.msg import DiagnosticArray; from tf2_msgs.msg import TFMessage; '
    'import create_oi_msgs.msg, create_oi_msgs.srv, std_srvs.srv')


def run_time(statement: str) -> float:
    """Return how long a Python process takes to run one statement, seconds."""
    begun = monotonic()
    subprocess.run([sys.executable, '-c', statement], check=True, env={
        **os.environ, 'ROS_DOMAIN_ID': DOMAIN})
    return monotonic() - begun


def first_odom(*, floor: bool) -> float:
    """Return the time from the start of a process to its first `odom`, seconds."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener('odom')
        sleep(1)
        begun = monotonic()
        stage.driver(floor=floor)
        listener.line()
        return float(listener.result()['odom'][0][0]) - begun


def measure() -> list[Figure]:
    """Return the figures."""
    runs = [(run_time('pass'), run_time(BARE_NODE), run_time(THEIRS), run_time(OURS),
             first_odom(floor=True), first_odom(floor=False)) for _ in range(REPETITIONS)]
    python, bare, theirs, ours, floor, node = zip(*runs)
    return [
        repeated('process start to first odom', node, 's', 1.5),
        repeated('floor: process start to first odom', floor, 's'),
        repeated('Python, start to end', python, 's'),
        repeated('with rclpy and an empty node', bare, 's'),
        repeated('with rclpy, pyserial and all messages imported', theirs, 's'),
        repeated('with the driver imported', ours, 's'),
        repeated('of that, our own modules', [a - b for a, b in zip(ours, theirs)], 's'),
    ]


if __name__ == '__main__':
    run('bench_start', measure)
