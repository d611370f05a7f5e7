# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Robots and nodes of the tests of ROS: of one test, or shared by a module."""

import pytest

from support.ros import Ready, scene


@pytest.fixture(scope='module')
def shared(tmp_path_factory):
    """Return a robot in Safe mode and its node, with `goal_pose`, for the tests of a module."""
    with scene(tmp_path_factory.mktemp('shared')) as made:
        yield Ready(made, goal_pose=True)


@pytest.fixture
def ready(shared):
    """Return the shared robot and node as if they were new."""
    shared.renew()
    return shared
