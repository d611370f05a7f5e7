# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Calls a robot that does not answer: at which baud rate, and what to tell the user.

When the driver connects, the robot may be off, in the middle of a command that another program
left unfinished, driving, or at another baud rate (that of Baud holds until power is cycled).
"""

from collections.abc import Iterator
from itertools import chain, cycle

from .. import oi
from ..oi.codes import START_BAUDS
from .events import Notice, Severity

CALL_INTERVAL = 0.3
"""Seconds to wait for an answer before the next call."""
GARBAGE_LIMIT = 64
"""Bytes without a frame after which something else must be on the line."""
CALLS_BEFORE_NOTICE = 3
"""Calls without an answer before the user is told; a robot that boots misses one or two."""


def _rates(first: int) -> Iterator[int]:
    """Yield all rates for ever; the likely ones come again before each of the others."""
    usual = (first, *(rate for rate in START_BAUDS if rate != first))
    rest = [code.rate for code in reversed(oi.BaudCode) if code.rate not in usual]
    return cycle(chain.from_iterable((*usual, other) for other in rest))


class BaudSearch:
    """Counts calls, and picks the baud rate of the next one."""

    def __init__(self, baud: int) -> None:
        """Call at one rate; 0 searches for the robot's."""
        self._searching = baud == 0
        self.baud = baud or START_BAUDS[0]
        """Bits per second, now."""
        self._next = _rates(self.baud)
        self._calls = 0
        self._notice_given = False
        self._garbage = bytearray()

    def restart(self) -> None:
        """Start anew: the robot answered until now, or the port has just been opened."""
        self._next = _rates(self.baud)
        self._calls, self._notice_given = 0, False
        self._garbage.clear()

    def next_baud(self) -> int:
        """Return the rate of the next call."""
        self._calls += 1
        if self._searching:
            self.baud = next(self._next)
        return self.baud

    def add_garbage(self, garbage: bytes) -> None:
        """Note bytes that are no frame."""
        if len(self._garbage) < GARBAGE_LIMIT:
            self._garbage += garbage[:GARBAGE_LIMIT]

    def notice(self) -> Notice | None:
        """Say what may be wrong, once, after some calls without an answer."""
        if self._notice_given or self._calls < CALLS_BEFORE_NOTICE:
            return None
        self._notice_given = True
        at = ' and '.join(map(str, START_BAUDS)) if self._searching else str(self.baud)
        if len(self._garbage) >= GARBAGE_LIMIT:
            shown = ' '.join(str(byte) for byte in self._garbage[:12])
            return Notice(Severity.ERROR, (
                f'something sends on the port, but not like a Create at {at} baud (it sent '
                f'{shown} ...): is it another device, or another baud rate (`baud: 0` tries all)? '
                'The driver keeps calling'))
        hint = '' if self._searching else '; the parameter `baud: 0` tries other rates'
        return Notice(Severity.ERROR, (
            f"no answer at {at} baud: is the robot on (Power light)? is it the Create's own "
            f'serial cable, plugged in all the way{hint}? The driver keeps calling'))
