# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Finds the slowest speed that moves the robot, by halves."""

from ...robot import MILLI
from .moves import CREEP, creep, FASTEST, Move, SLOWEST
from .notebook import Page

PART = 0.3
"""Part of the way asked that a robot which moves at all makes at least."""


class DeadBandSearch:
    """The range in which that speed lies, mm/s."""

    def __init__(self) -> None:
        self.stands, self.moves = SLOWEST, FASTEST
        self._back = False

    def next_move(self) -> Move | None:
        """Return the next creep; None: the speed is found."""
        return creep(self._speed, back=self._back) if self.moves - self.stands > 1 else None

    def learn(self, page: Page) -> None:
        """Learn from a creep."""
        distance, _ = page.counted
        if abs(distance) > PART * self._speed * CREEP:
            self.moves = self._speed
        else:
            self.stands = self._speed
        self._back = not self._back

    @property
    def band(self) -> tuple[float, float]:
        """Fastest speed that moved nothing, slowest that moved the robot, m/s."""
        return self.stands * MILLI, self.moves * MILLI

    @property
    def _speed(self) -> int:
        return (self.stands + self.moves) // 2
