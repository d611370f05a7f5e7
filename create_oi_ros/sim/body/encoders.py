# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the Create says about its own travel: the two accumulators behind packets 19 and 20.

All requests share them; reading one sets it to zero. What becomes of the fraction below a whole
millimetre or degree at that moment is not documented: see `robot.Rounding`.
"""

from __future__ import annotations

import math

from ...robot import Rounding

LOWEST, HIGHEST = -32768, 32767
UNIT_SLACK = 1e-6
"""Units by which a sum of floats may miss a whole number that it means to be."""


class Accumulator:
    """A sum of small floats, read as a 16-bit integer and then set to zero."""

    __slots__ = ('total', '_pending', '_rounding')

    def __init__(self, rounding: Rounding) -> None:
        self.total = 0.0
        """All that was ever added; reading does not touch it."""
        self._pending = 0.0
        self._rounding = rounding

    def add(self, amount: float) -> None:
        """Add; what is waiting to be read stops at the ends of 16 bits, as the manual says."""
        self.total += amount
        pending = self._pending + amount
        if not LOWEST <= pending <= HIGHEST:
            pending = LOWEST if pending < 0 else HIGHEST
        self._pending = pending

    def take(self) -> int:
        """Read and reset: -32768 to 32767."""
        pending = self._pending
        nudge = 0.5 if self._rounding is Rounding.ROUND else UNIT_SLACK
        whole = int(pending + math.copysign(nudge, pending))
        self._pending = pending - whole if self._rounding is Rounding.CARRY else 0.0
        return whole
