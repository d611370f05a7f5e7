# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Start and end of a program, also where ROS hangs."""

from pathlib import Path
import subprocess
import sys
import threading

import pytest

from create_oi_ros.ros import process
from create_oi_ros.ros.programs import PROGRAMS, UserError
from support.ros import own_domain, TIMEOUT

READY = 2
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


def write_port(port: Path, mark: int, size: int = 52400) -> Path:
    """Write a port of shared memory; READY is the mark of one that is made."""
    port.write_bytes((mark.to_bytes(4, sys.byteorder) + bytes(size))[:size])
    return port


@pytest.mark.parametrize(('number', 'mark', 'size'), [
    (7400, 0, 0), (7649, 0, 52400), (7000, 1, 52400)])
def test_a_port_that_nobody_finishes_is_named(number, mark, size, tmp_path, monkeypatch):
    monkeypatch.setattr(process, 'PORT_TIMEOUT', 0.2)
    port = write_port(tmp_path / f'fastrtps_port{number}', mark, size)

    with pytest.raises(UserError, match=f'Remove it: `rm {port}`'):
        process.check_shared_memory(0, tmp_path)
    assert port.exists()


def test_ports_that_are_made_or_of_another_domain_are_not_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(process, 'PORT_TIMEOUT', 0.2)
    for name, mark, size in (
            ('fastrtps_port7411', READY, 52400), ('fastrtps_port7650', 0, 52400),
            ('fastrtps_port7411_el', 0, 0), ('sem.fastrtps_port7411_mutex', 0, 32)):
        write_port(tmp_path / name, mark, size)

    process.check_shared_memory(0, tmp_path)
    process.check_shared_memory(0, tmp_path / 'no shared memory here')


def test_a_port_that_its_program_finishes_is_waited_for(tmp_path):
    port = write_port(tmp_path / 'fastrtps_port7411', 1)
    finishing = threading.Timer(0.3, write_port, (port, READY))
    finishing.start()

    process.check_shared_memory(0, tmp_path)
    finishing.join()


def test_a_node_on_a_port_that_nobody_finishes_ends_and_names_it(monkeypatch):
    monkeypatch.delenv('FASTDDS_BUILTIN_TRANSPORTS')  # shared memory, as users have it
    with own_domain() as domain:
        port = write_port(process.SHARED_MEMORY / f'fastrtps_port{7411 + 250 * domain}', 0)
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        try:
            done = subprocess.run(
                [sys.executable, '-c', PROGRAMS['create_node']], text=True, capture_output=True,
                timeout=TIMEOUT, check=False)
        finally:
            port.unlink()

    assert (done.stdout, done.returncode) == ('', 2)
    assert done.stderr.startswith(f'create_node: ROS waits for {port} for ever')
