# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Robots and nodes of the tests of ROS: of one test, or shared by a module."""

import pytest

from support.ros import Ready


@pytest.fixture(scope='module')
def shared(shared_stage):
    """Return a robot in Safe mode and its node, with `goal_pose`, for the tests of a module."""
    return Ready(shared_stage, goal_pose=True)


@pytest.fixture
def ready(shared):
    """Return the shared robot and node as if they were new."""
    shared.renew()
    return shared
