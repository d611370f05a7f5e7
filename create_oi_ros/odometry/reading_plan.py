# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
When to ask the robot for distance and angle.

Each reading may cost a fraction of a degree, so the robot is asked seldom; longer after a change
of the requests, for then the wheels have had time to follow; soon after a stop.
"""

from collections.abc import Sequence
from math import remainder

from ..robot import Rounding
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
PROBE, PROBE_STEADY = 8, 0.6
"""Readings in a row that tell the rounding; seconds of a steady request before them."""
EVEN = 0.006
"""m/s; a request that stays within it is steady: whoever steers along a line corrects always."""
SURE, POSSIBLE = 0.97, 0.015
"""Probability of a rounding that ends them, and below which it is ruled out."""
TELLING = 0.2
"""Part of a unit by which readings of two that are not ruled out must differ."""


class ReadingPlan:
    """Decides after each frame whether the next one should carry a reading."""

    def __init__(self, window: float) -> None:
        self.window = window
        self.due = True
        self._age = self._steady = self._even = 0.0
        self._probe = self._pause = self._count = 0
        self._request = self._near = (0.0, 0.0)

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
        if max(abs(now - near) for now, near in zip(request, self._near)) > EVEN:
            self._near, self._even = request, 0.0
        self._age += dt
        self._steady += dt
        self._even += dt
        if self._probe:
            self._probe = 0 if free else self._probe - 1
            self.due = self._probe > 0
        elif self.due:
            self.due, self._pause = False, ANSWER
        elif self._pause:
            self._pause -= 1
        elif self._age > self._wait(bank, free):
            self.due = True
            self._probe = PROBE if not free and self._tells_rounding(dt, bank) else 0

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
        if not any(self._request) or self._even < PROBE_STEADY:
            return False
        if max(bank.rounding.values()) > SURE:
            return False
        speed, rate = bank.motion(bank.wheels.speed[:, 0])
        amounts = abs(rate) / DEGREE * dt, abs(speed) / MM * dt
        possible = [each for each, chance in bank.rounding.items() if chance > POSSIBLE]
        return any(tells_apart(amount, possible) for amount in amounts)


def tells_apart(amount: float, roundings: Sequence[Rounding]) -> bool:
    """Return whether readings of this amount, not negative, differ in the mean by rounding."""
    lost = {Rounding.TRUNCATE: amount % 1, Rounding.ROUND: remainder(amount, 1),
            Rounding.CARRY: 0.0}
    parts = [lost[each] for each in roundings]
    return max(parts) - min(parts) > TELLING
