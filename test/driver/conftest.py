# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot and driver that most tests begin with."""

import pytest

from create_oi_ros.driver import Settings
from support.loop import AT_ONCE, Loop


@pytest.fixture
def loop() -> Loop:
    """Return a robot and a driver that have met."""
    return acquainted(Settings())


@pytest.fixture
def at_once() -> Loop:
    """Return the same without limits of acceleration."""
    return acquainted(Settings(limits=AT_ONCE))


def acquainted(settings: Settings) -> Loop:
    """Let a robot and a driver meet."""
    met = Loop(settings)
    met.run(0.3)
    met.commands()
    return met
