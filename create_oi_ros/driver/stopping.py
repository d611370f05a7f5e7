# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bytes that stop a robot: in whatever state it is, and when the driver ends."""

from .. import oi
from .supervision import MODE_COMMANDS

HALT = oi.DriveDirect(right=0, left=0)
DRAIN = bytes(2 * HALT.opcode)
"""Ends any command that was cut short after a `HALT` (manual: "waiting" state).

Zero is no opcode. The longest such command is a Song that takes the opcode for its count of
notes, of two bytes each.
"""
WAKE_UP = 2 * HALT.encode() + DRAIN + HALT.encode()
"""Stops a robot that may wait for the rest of a command, and has it listen again.

The first `HALT` may be taken as that rest, even as a speed; then the second one stops the wheels.
docs/reliability.md shows what becomes of each command.
"""
END_DEMO = oi.Demo(demo=oi.DemoNumber.ABORT)
LAST_WORDS = b''.join((
    HALT.encode(), oi.Start().encode(), DRAIN, HALT.encode(), oi.Start().encode()))
"""Stops a robot whose driver has died, even in the middle of a command."""


def farewell(mode: oi.Mode | None, mode_on_exit: oi.Mode) -> list[oi.Command]:
    """Return the last commands of a driver that ends, to a robot in this mode."""
    demo = [END_DEMO] if mode is oi.Mode.PASSIVE else []
    return [
        HALT, oi.PwmLowSideDrivers(driver_0=0, driver_1=0, driver_2=0), *demo,
        oi.PauseResumeStream(state=oi.StreamState.PAUSE), MODE_COMMANDS[mode_on_exit]()]
