# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
When to ask the robot for distance and angle.

Each reading may cost a fraction of a unit, so the robot is asked seldom: when the filters have
become unsure of the way, and after a stop, when no motion hides anything.
"""

from ..robot import MILLI, Rounding
from .filters import DEGREE, Filters, ROUNDINGS
from .wheels import Speeds

LEAST, MOST = 1.0, 4.0
"""Windows between two readings (tried: shorter loses too much to fractions)."""
TURN_LIMIT, WAY_LIMIT = 2 * DEGREE, 0.03
"""Deviations of turn and way since the last reading from which on it is time for one (tried)."""
CRAWL = 0.05
"""m/s; a wheel that is asked for less may not move (evidence: dead bands), so look soon."""
STANDING, STOPPED, STOPPED_WAIT = 1.0, 0.6, 0.3
"""Windows between readings at rest; seconds after the request of a stop from which on the wheels
stand, and windows after the last reading at which they are then read."""
ANSWER = 8
"""Frames in which the answer to a question comes."""
ROW, EVEN, STEADY = 8, 0.006, 0.25
"""Readings in a row that tell the rounding; m/s and seconds of a steady request before them."""
SURE, CARRIES = 0.97, 0.99
"""Probability of a rounding that needs none, and of one that loses nothing at a reading."""
TELLING = 0.72
"""Part of a unit at which roundings differ most: truncate loses it, round gains the rest."""


class ReadingPlan:
    """Decides after each frame whether the next one should carry a reading."""

    def __init__(self, window: float) -> None:
        self.window, self.due = window, True
        self._age = self._still = self._even = 0.0
        self._row = self._pause = self._count = self._frames = self._every = 0
        self._request: Speeds = (0.0, 0.0)
        self._near: Speeds = (0.0, 0.0)

    @property
    def asked(self) -> bool:
        """Whether an answer may be on its way."""
        return self.due or self._pause > 0

    def hurry(self) -> None:
        """Ask soon."""
        self._age = 1e3

    def came(self) -> None:
        """Note that a reading has come."""
        self._age, self._pause = 0.0, 0
        self._count += 1

    def step(self, dt: float, request: Speeds, filters: Filters, unsure: Speeds) -> None:
        """Let a frame pass; `unsure`: the deviations of way and turn since the last reading."""
        if request != self._request:
            self._request, self._still = request, 0.0
        if max(abs(now - near) for now, near in zip(request, self._near)) > EVEN:
            self._near, self._even = request, 0.0
        self._age += dt
        self._still += dt
        self._even += dt
        if self._row:
            self._frames = (self._frames + 1) % self._every
            if self._even < STEADY / 2 or max(filters.rounding) > CARRIES:
                self._row = 0
            self.due = bool(self._row) and self._frames == 0
            self._row -= self.due
            self._pause = ANSWER
        elif self.due:
            self.due, self._pause = False, ANSWER
        elif self._pause:
            self._pause -= 1
        elif self._time_is_over(filters, unsure):
            self.due, self._frames = True, 0
            self._every = self._telling(dt, filters)
            self._row = ROW if self._every else 0

    def _time_is_over(self, filters: Filters, unsure: Speeds) -> bool:
        """Return whether it is time for a reading."""
        age, wheels = self._age / self.window, filters.wheels
        if age < STOPPED_WAIT:
            return False
        if not any(self._request):
            if not wheels.moving and not wheels.path.any():
                return age > STANDING
            if self._still > STOPPED:
                return True
        # Varied by the golden ratio: even intervals are rounded alike each time.
        varied = 0.8 + 0.4 * (self._count * 0.618 % 1)
        crawls = max(map(abs, self._request)) < CRAWL
        return age > LEAST * varied and (
            crawls or age > MOST * varied or unsure[0] > WAY_LIMIT or unsure[1] > TURN_LIMIT
            or filters.rounding[ROUNDINGS.index(Rounding.CARRY)] > CARRIES)

    def _telling(self, dt: float, filters: Filters) -> int:
        """Return how many frames apart readings in a row would tell the roundings; 0: none."""
        if not any(self._request) or self._even < STEADY or max(filters.rounding) > SURE:
            return 0
        if not filters.wheels.steady:
            return 0
        far, turn = filters.motion((filters.wheels.speed[0] * dt).tolist(), dt, kept=True)
        best, every = 0.15, 0
        for amount in abs(turn) / DEGREE, abs(far) / MILLI:
            for frames in range(1, 7):
                off = abs(amount * frames % 1 - TELLING) + 0.01 * frames + 0.003 * amount * frames
                if off < best:
                    best, every = off, frames
        return every
