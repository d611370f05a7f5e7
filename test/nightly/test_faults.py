# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Faults of line, robot and process with a real node: once in `make test`, all ten times nightly.

The robot's sensors are held at fixed values: every other value that is published is wrong.
"""

from math import inf
from random import Random
from statistics import median

import pytest

from nightly.faults import FAULTS
from nightly.stage import jump, Pose, staged
from support.nightly import NIGHTLY, times

QUICK = ('cable out and in', 'bad line: 5 % flipped, short, garbage', 'SIGSTOP, SIGCONT',
         'robot told to wait for ever', 'SIGKILL')
"""Faults that `make test` makes once."""
BY_NAME = {fault.name: fault for fault in FAULTS}


@pytest.fixture(scope='module')
def stage(tmp_path_factory):
    """Return a stage whose node lives on from fault to fault."""
    with staged(tmp_path_factory.mktemp('stage')) as made:
        yield made


@pytest.mark.parametrize('name', QUICK)
def test_the_robot_stops_or_all_is_as_before(stage, name):
    fault = BY_NAME[name]
    result = fault.attempt(stage, Random(name))
    failure = fault.failure(result, inf)  # nothing is timed here: the machine may be busy
    if failure:
        failure += stage.node.output if stage.node else ''
        stage.end()
    assert not failure


@NIGHTLY
@pytest.mark.timeout(1200)
@pytest.mark.parametrize('name', BY_NAME)
def test_each_fault_is_survived_each_time_and_in_time(name, tmp_path):
    fault = BY_NAME[name]
    with staged(tmp_path) as stage:
        results = [fault.attempt(stage, Random(f'{name} {number}')) for number in range(times(10))]
    for what in ('recovery', 'zero'):
        if took := [time for each in results if (time := getattr(each, what)) is not None]:
            print(f'{what}: median {median(took):.3f} s, worst {max(took):.3f} s')
    assert not [why for each in results if (why := fault.failure(each, 1.0))]


def test_a_jump_of_the_odometry_is_seen():
    still = Pose(1000.0, 5.0, -2.0, 0.1)
    assert not jump(still, Pose(1000.015, 5.007, -2.0, 0.1))
    assert not jump(still, Pose(1001.0, 5.4, -2.0, 0.1))
    for wrong in (Pose(1000.015, 5.1, -2.0, 0.1), Pose(1000.015, 5.0, -2.0, 0.4),
                  Pose(1001.0, 6.0, -2.0, 0.1), still):
        assert jump(still, wrong)
