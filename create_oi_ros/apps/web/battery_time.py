# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How long a battery lasts, or charges, from its charge and a smoothed current. Pure."""

from __future__ import annotations

from math import exp, inf, isfinite

SMOOTHING = 20.0
"""Seconds over which the current is averaged."""
LEAST_CURRENT = 0.02
"""Amperes below which no time is told."""
LONGEST = 24 * 60
"""Minutes; a longer time is not told."""


class BatteryTime:
    """Averages the current, and divides the charge by it."""

    def __init__(self) -> None:
        self._current, self._at = 0.0, -inf

    def left(self, charge: float, capacity: float, current: float, now: float) -> int | None:
        """Return the minutes until empty, or while charging until full; None: not known."""
        if not all(map(isfinite, (charge, capacity, current))):
            return None
        kept = exp(-(now - self._at) / SMOOTHING)
        # Plugged in or out: the average of both says nothing.
        if (current > 0) != (self._current > 0):
            kept = 0.0
        self._current, self._at = kept * self._current + (1 - kept) * current, now
        if abs(self._current) < LEAST_CURRENT:
            return None
        hours = (capacity - charge if self._current > 0 else charge) / abs(self._current)
        minutes = round(60 * max(hours, 0.0))
        return minutes if minutes <= LONGEST else None
