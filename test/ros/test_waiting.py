# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A program that waits says for what, in which ROS domain, and where a driver runs."""

from types import SimpleNamespace

import pytest

from create_oi_ros.ros import waiting
from create_oi_ros.ros.waiting import (
    announce,
    DISCOVERY_TIMEOUT,
    drivers,
    waits_for,
    WARNING_DELAY,
)

WAITS = """
import rclpy
from create_oi_ros.ros.waiting import wait_for_robot
rclpy.init()
wait_for_robot(rclpy.create_node('waits'))
print('found', flush=True)
"""


def node(namespace: str = '/') -> SimpleNamespace:
    """Return what stands for a node in domain 7."""
    return SimpleNamespace(context=SimpleNamespace(get_domain_id=lambda: 7),
                           get_namespace=lambda: namespace)


def test_drivers_of_this_computer_are_known_while_they_run():
    with announce(221, '/robot1/create'), announce(221, '/robot1/create'):
        assert drivers().count((221, '/robot1/create')) == 1
    assert (221, '/robot1/create') not in drivers()
    with announce(221, '/' + 200 * 'long'):
        assert (221, '/long') not in drivers()


@pytest.mark.parametrize(('found', 'namespace', 'words'), [
    ([], '/', 'waits for odom in ROS domain 7; on this computer no driver runs: start one with '
              'create_run'),
    ([(215, '/create'), (216, '/r/create')], '/',
     '/create runs in domain 215 (export ROS_DOMAIN_ID=215), /r/create runs in domain 216 '
     '(export ROS_DOMAIN_ID=216, --ros-args -r __ns:=/r)'),
    ([(7, '/robot1/create')], '/',
     '/robot1/create runs in domain 7 (--ros-args -r __ns:=/robot1)'),
    ([(7, '/create')], '/robot1',
     'in ROS domain 7, namespace /robot1; on this computer /create runs in domain 7 '
     '(--ros-args -r __ns:=/)'),
])
def test_it_says_what_it_waits_for_and_where_a_driver_runs(monkeypatch, found, namespace, words):
    monkeypatch.setattr(waiting, 'drivers', lambda: found)
    assert waits_for(node(namespace), 'odom', WARNING_DELAY - 0.1) is None
    assert words in waits_for(node(namespace), 'odom', WARNING_DELAY)


def test_a_driver_that_runs_here_is_given_more_time_to_be_found(monkeypatch):
    monkeypatch.setattr(waiting, 'drivers', lambda: [(7, '/robot1/create')])
    assert waits_for(node('/robot1'), 'odom', DISCOVERY_TIMEOUT - 0.1) is None
    assert 'but ROS does not find it' in waits_for(node('/robot1'), 'odom', DISCOVERY_TIMEOUT)


def test_a_program_waits_for_a_driver_then_for_its_robot(stage, tmp_path):
    script = tmp_path / 'waits.py'
    script.write_text(WAITS)
    program = stage.script(script)
    stage.ros.until(lambda: f'in ROS domain {stage.domain}; on this' in program.output)
    stage.node(tmp_path / 'create')
    stage.ros.until(lambda: 'waits for a robot (no robot answers)' in program.output)
    stage.robot()
    assert program.ended() == 0
    assert program.printed[-1] == 'found\n'
