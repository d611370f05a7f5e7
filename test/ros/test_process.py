# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The end of a program, also where ROS hangs."""

import subprocess
import sys

import pytest

HANGS = """
import ctypes
from create_oi_ros.ros import process
{begin}
    node.destroy_node = lambda: ctypes.PyDLL(None).sleep(600)  # Python can do nothing meanwhile
    process.END_TIME = 0.2
    print('done', flush=True)
"""
EXECUTOR = """
import rclpy
with process.ros_executor() as executor:
    node = rclpy.create_node('program')
    executor.add_node(node)
"""
GOALS = """
from create_oi_ros.ros.goal_client import GoalClient
with GoalClient() as robot:
    node = robot.node
"""


@pytest.mark.parametrize('begin', [EXECUTOR, GOALS], ids=['a node', 'a client of goals'])
def test_a_program_ends_though_ros_hangs_at_its_end_and_tells_where(begin: str) -> None:
    done = subprocess.run([sys.executable, '-c', HANGS.format(begin=begin)], text=True,
                          capture_output=True, timeout=60, check=False)

    assert (done.stdout, done.returncode) == ('done\n', 1)
    assert done.stderr.startswith('Timeout (')
    assert f'in {"ros_executor" if begin == EXECUTOR else "__exit__"}\n' in done.stderr
