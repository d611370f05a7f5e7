# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a program loads when it starts."""

import subprocess
import sys

import pytest

from create_oi_ros.ros.process import GENERATOR, leave_out_generator

START = f"""
import sys
from create_oi_ros.ros.process import ros_executor
import rclpy
from geometry_msgs.msg import Twist
with ros_executor():
    node = rclpy.create_node('program')
    node.create_publisher(Twist, 'cmd_vel', 1).publish(Twist())
    node.destroy_node()
print([name for name in ('rosidl_generator_py', 'lark', {GENERATOR!r}) if name in sys.modules])
import {GENERATOR}
print('lark' in sys.modules)
"""
SELDOM = ('argparse', 'difflib', 'json', 'shutil', 'create_oi_ros.ros.reference',
          'create_oi_ros.oi.tools.markdown')
"""What only documents, typing errors and wrong arguments need."""
NODE = f"""
import sys
import numpy, rclpy, rclpy.action, rclpy.serialization, serial
before = set(sys.modules)  # what others load is not ours to say
from create_oi_ros.ros import node, node_arguments
node_arguments.parse(['--ros-args', '-p', 'port:=/dev/create'])
print(sorted(({{*sys.modules}} - before) & {{*{SELDOM!r}}}), len(sys.modules) > len(before))
"""
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


def test_a_node_loads_nothing_that_it_seldom_needs() -> None:
    done = subprocess.run(
        [sys.executable, '-c', NODE], text=True, capture_output=True, timeout=60, check=True)

    assert done.stdout == '[] True\n'


def test_a_program_does_without_the_code_generator_of_messages_until_it_imports_it() -> None:
    done = subprocess.run(
        [sys.executable, '-c', START], text=True, capture_output=True, timeout=60, check=True)

    assert done.stdout.splitlines() == ["['rosidl_generator_py']", 'True']


def test_a_generator_that_is_loaded_already_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, GENERATOR, pytest)

    leave_out_generator()

    assert sys.modules[GENERATOR] is pytest


def test_a_ros_without_that_package_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, GENERATOR, raising=False)
    monkeypatch.setitem(sys.modules, 'rosidl_generator_py', None)

    leave_out_generator()

    assert GENERATOR not in sys.modules


@pytest.mark.parametrize('begin', [EXECUTOR, GOALS], ids=['a node', 'a client of goals'])
def test_a_program_ends_though_ros_hangs_at_its_end_and_tells_where(begin: str) -> None:
    done = subprocess.run([sys.executable, '-c', HANGS.format(begin=begin)], text=True,
                          capture_output=True, timeout=60, check=False)

    assert (done.stdout, done.returncode) == ('done\n', 1)
    assert done.stderr.startswith('Timeout (')
    assert f'in {"ros_executor" if begin == EXECUTOR else "__exit__"}\n' in done.stderr
