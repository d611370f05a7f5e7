# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot and driver that most tests begin with."""

import pytest

from support.loop import Loop


@pytest.fixture
def loop() -> Loop:
    """Return a robot and a driver that have met."""
    met = Loop()
    met.run(0.3)
    met.commands()
    return met
