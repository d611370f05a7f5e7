# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Calls a robot that does not answer: at which baud rate, and what to tell the user.

When the driver connects, the robot may be off, in the middle of a command that another program
left unfinished, driving, or at another baud rate (that of Baud holds until power is cycled). At a
rate that is too slow for the stream, the search tells it to change to the usual one.
"""

from collections.abc import Iterator
from itertools import chain, cycle

from .. import oi
from ..oi.codes import FAST_BAUD, START_BAUDS
from .events import Notice, Severity

CALL_INTERVAL = 0.3
"""Seconds between two calls; more at rates where a call and its answer take longer."""
ANSWER_TIME = 0.1
"""Seconds from the end of a call to its answer, or until Baud is done (manual: Baud)."""
SLOWEST_BAUD = START_BAUDS[1]
"""Bits per second below which the stream does not fit."""
GARBAGE_LIMIT = 64
"""Bytes without a frame after which something else must be on the line."""
CALLS_BEFORE_NOTICE = 3
"""Calls without an answer before the user is told; a robot that boots misses one or two."""


def _rates(first: int) -> Iterator[int]:
    """Yield all rates for ever; the likely ones come again before each of the others."""
    usual = (first, *(rate for rate in START_BAUDS if rate != first))
    # 14400 before 38400: a call at 38400 is a Wait to a robot at 14400, which then is deaf.
    rest = sorted((code.rate for code in oi.BaudCode if code.rate not in usual),
                  key=lambda rate: (rate != FAST_BAUD, rate > SLOWEST_BAUD, -rate))
    return cycle(chain.from_iterable((*usual, other) for other in rest))


class BaudSearch:
    """Counts calls, and picks the baud rate of the next one."""

    def __init__(self, baud: int) -> None:
        """Call at one rate; 0 searches for the robot's."""
        self.searching = baud == 0
        """Whether the robot's rate is not known."""
        self.baud = baud or START_BAUDS[0]
        """Bits per second, now."""
        self._next = _rates(self.baud)
        self.raised_from: int | None = None
        """Rate of the call before, if it told the robot to change to START_BAUDS[0]."""
        self.calls = 0
        """Calls since the robot answered, or since the port was opened."""
        self._garbage = bytearray()
        self.problem: str | None = None
        """What the user was told of a robot that does not answer."""

    def restart(self) -> None:
        """Start anew: the robot answered until now, or the port has just been opened."""
        self._next = _rates(START_BAUDS[0] if self.raises else self.baud)
        self.calls, self.problem, self.raised_from = 0, None, None
        self._garbage.clear()

    @property
    def raises(self) -> bool:
        """Whether this call is for a robot that is to change to START_BAUDS[0]."""
        return self.searching and self.baud < SLOWEST_BAUD

    def next_baud(self) -> int:
        """Return the rate of the next call."""
        self.calls += 1
        self.raised_from = self.baud if self.raises else None
        if self.searching:
            self.baud = next(self._next)
        return self.baud

    def add_garbage(self, garbage: bytes) -> None:
        """Note bytes that are no frame."""
        if len(self._garbage) < GARBAGE_LIMIT:
            self._garbage += garbage[:GARBAGE_LIMIT]

    def notice(self) -> Notice | None:
        """Say what may be wrong, once, after some calls without an answer."""
        if self.problem is not None or self.calls < CALLS_BEFORE_NOTICE:
            return None
        at = ' and '.join(map(str, START_BAUDS)) if self.searching else str(self.baud)
        calls = f'The driver keeps calling{", at every rate" if self.searching else ""}'
        if len(self._garbage) >= GARBAGE_LIMIT:
            shown = ' '.join(str(byte) for byte in self._garbage[:12])
            rate = '' if self.searching else ', or another baud rate (`baud: 0` tries all)'
            self.problem = (
                f'something sends on the port, but not like a Create at {at} baud (it sent '
                f'{shown} ...): is it another device{rate}? {calls}')
        else:
            hint = '' if self.searching else '; the parameter `baud: 0` tries other rates'
            self.problem = (
                f"no answer at {at} baud: is the robot on (Power light)? is it the Create's own "
                f'serial cable, plugged in all the way{hint}? {calls}')
        return Notice(Severity.ERROR, self.problem)
