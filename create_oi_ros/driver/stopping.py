"""Bytes that stop a robot: in whatever state it is, and when the driver ends."""

from .. import oi
from .supervision import MODE_COMMANDS

DRAIN = b'\xff' + bytes(260)
"""Ends any command that was cut short, harmlessly (manual: "waiting" state).

The first byte, 255, is no baud code, and as a demo it means `abort`. Zeros do no harm as any other
data: a count, a speed, an output. Neither byte is an opcode.
"""
HALT = oi.DriveDirect(right=0, left=0)
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
