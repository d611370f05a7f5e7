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
