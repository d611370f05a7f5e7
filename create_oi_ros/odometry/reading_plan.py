# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
When to ask the robot for distance and angle.

Each reading may cost a fraction of a degree, so the robot is asked seldom; longer after a change
of the requests, for then the wheels have had time to follow; soon after a stop.
"""

from ..robot import FIRMWARE_SEPARATION
from .bank import Bank
from .hypotheses import DEGREE, MM

WAIT, KNOWN_WAIT, KNOWN = 1.3, 2.0, 25
"""Windows between two readings at first, and after so many readings in motion."""
UNSETTLED, SETTLED = 2.2, 0.35
"""Factor of these while the requests change, and seconds without a change until they do not."""
STANDING, STOPPED, STOPPED_WAIT = 1.0, 0.6, 0.3
"""Windows between readings at rest; seconds after the request of a stop from which on the wheels
stand, and windows after the last reading at which they are then read."""
FREE_WAIT = 0.5
"""Windows between readings while the wheels do not follow requests."""
ANSWER = 8
"""Frames in which the answer to a question comes."""
PROBE, PROBE_EVERY, PROBE_STEADY, SURE = 8, 1.5, 0.6, 0.97
"""Readings in a row that tell the rounding; seconds between two of these, and without a change of
request before; the probability that ends them."""


class ReadingPlan:
    """Decides after each frame whether the next one should carry a reading."""

    def __init__(self, window: float) -> None:
        self.window = window
        self.due = True
        self._age = self._steady = self._probed = 0.0
        self._probe = self._pause = self._count = 0
        self._request = (0.0, 0.0)

    def hurry(self) -> None:
        """Ask soon."""
        self._age = max(self._age, 1e3)

    def came(self) -> None:
        """Note that a reading has come."""
        self._age, self._pause = 0.0, 0
        self._count += 1

    def step(self, dt: float, request: tuple[float, float], bank: Bank, *, free: bool) -> None:
        """Let a frame pass."""
        if request != self._request:
            self._request, self._steady = request, 0.0
        self._age += dt
        self._steady += dt
        self._probed += dt
        if self._probe:
            self._probe -= 1
            self.due = self._probe > 0
        elif self.due:
            self.due, self._pause = False, ANSWER
        elif self._pause:
            self._pause -= 1
        elif not free and self._tells_rounding(dt, bank):
            self.due, self._probe, self._probed = True, PROBE, 0.0
        else:
            self.due = self._age > self._wait(bank, free)

    def _wait(self, bank: Bank, free: bool) -> float:
        """Seconds from the last reading to the next."""
        if free:
            return FREE_WAIT * self.window
        if not any(self._request):
            if bank.wheels.rests and not bank.wheels.path.any():
                return STANDING * self.window
            if self._steady > STOPPED:
                return STOPPED_WAIT * self.window
        # Varied by the golden ratio: even intervals are rounded alike each time.
        varied = 0.8 + 0.4 * (self._count * 0.618 % 1)
        return self.window * varied * (WAIT if bank.readings < KNOWN else KNOWN_WAIT) * (
            1.0 if self._steady > SETTLED else UNSETTLED)

    def _tells_rounding(self, dt: float, bank: Bank) -> bool:
        """Return whether readings in a row would now tell the roundings apart."""
        right, left = self._request
        if not (right or left) or self._steady < PROBE_STEADY or self._probed < PROBE_EVERY:
            return False
        amounts = (abs(right - left) / FIRMWARE_SEPARATION / DEGREE * dt,
                   abs(right + left) / 2 / MM * dt)
        tells = any(each > 0.15 and (0.22 < each % 1 < 0.38 or 0.62 < each % 1 < 0.88)
                    for each in amounts)
        return tells and float(bank.rounding.max()) <= SURE
