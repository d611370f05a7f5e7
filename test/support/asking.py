# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What services ask of a driver, in memory."""

from create_oi_ros import oi
from create_oi_ros.driver import Outcome
from support.loop import Loop


def ask(loop: Loop, request, *arguments, seconds: float = 0.2, **named) -> Outcome:
    """Make a request, let time pass, and return the outcome, which must be known then."""
    pending = request(*arguments, **named)
    loop.run(seconds)
    assert pending.outcome is not None
    return pending.outcome


def in_mode(loop: Loop, mode: oi.Mode) -> None:
    """Have the robot in a mode."""
    assert ask(loop, loop.driver.modes.set, mode, loop.now).ok


def power_cycle(loop: Loop) -> None:
    """Switch the robot off and on, and let the driver find it again."""
    loop.robot.power(False, loop.now)
    loop.run(1.0)
    loop.robot.power(True, loop.now)
    loop.run(6.0)
    assert loop.driver.state.answered
