"""
How a robot is called that does not answer: at which baud rate, and what to tell the user.

A robot may be anything when the driver comes: off, in the middle of a command that another
program left unfinished, driving, or at another baud rate (that of Baud holds until power is
cycled).
"""

from collections.abc import Iterator
from itertools import chain, cycle

from .. import oi
from .events import Notice, Severity

DRAIN = b'\xff' + bytes(260)
"""Ends any command that was cut short, harmlessly (manual: "waiting" state).

The first byte completes Baud or Demo as no baud code and as `abort`; zeros complete any count,
speed or output as nothing. Neither byte is an opcode.
"""
HALT = oi.DriveDirect(right=0, left=0).encode() + oi.Start().encode()
LAST_WORDS = HALT + DRAIN + HALT
"""What stops a robot whose driver has died, even in the middle of a command."""
CALL_AGAIN = 0.3
"""Seconds to wait for an answer."""
USUAL = (57600, 19200)
"""Rates that a Create begins with (manual: Serial Port Settings)."""
SPEECH = 64
"""Bytes that are no frames after which something else is taken to be speaking."""
ROUNDS = 3
"""Calls without an answer before the user is told; a robot that boots misses one or two."""


def _rates(first: int) -> Iterator[int]:
    """Go through all rates for ever, the likely ones in between."""
    usual = (first, *(rate for rate in USUAL if rate != first))
    rest = [code.rate for code in reversed(oi.BaudCode) if code.rate not in usual]
    return cycle(chain.from_iterable((*usual, other) for other in rest))


class Calling:
    """Keeps count of calls, and picks the baud rate of the next one."""

    def __init__(self, baud: int) -> None:
        """Call at one rate; 0 is to look for the robot's."""
        self._searching = baud == 0
        self.baud = baud or USUAL[0]
        """Bits per second, now."""
        self._next = _rates(self.baud)
        self._calls = 0
        self._told = False
        self._heard = bytearray()

    def begin(self) -> None:
        """Begin anew: the robot was there until now, or the port has just been opened."""
        self._next = _rates(self.baud)
        self._calls, self._told = 0, False
        self._heard.clear()

    def call(self) -> int:
        """Return the rate to call at now."""
        self._calls += 1
        if self._searching:
            self.baud = next(self._next)
        return self.baud

    def overheard(self, garbage: bytes) -> None:
        """Note bytes that are no frame."""
        if len(self._heard) < SPEECH:
            self._heard += garbage[:SPEECH]

    def complaint(self) -> Notice | None:
        """Say what may be wrong, once it is time to."""
        if self._told or self._calls < ROUNDS:
            return None
        self._told = True
        at = ' and '.join(map(str, USUAL)) if self._searching else str(self.baud)
        if len(self._heard) >= SPEECH:
            shown = ' '.join(str(byte) for byte in self._heard[:12])
            return Notice(Severity.ERROR, (
                f'something speaks on the port, but not like a Create at {at} baud (it said '
                f'{shown} ...): is it another device, or another baud rate (`baud: 0` looks)?'))
        hint = '' if self._searching else '; the parameter `baud: 0` looks at other rates'
        return Notice(Severity.ERROR, (
            f"no answer at {at} baud: is the robot on (Power light)? is it the Create's own "
            f'serial cable, and in to the stop{hint}? The driver keeps calling'))
