# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Slow requests that may not move a wheel at all: what is known of the edge.

A Create's wheels do not turn when they are asked for less than some speed. Between the fastest
request that was seen not to move a wheel and the slowest that was seen to, the state `MOVES` of a
wheel (0 to 1) is open; readings tell, and the edge is known better from then on.
"""

from . import states as s
from .assumptions import Assumptions

SLOWEST, FASTEST = 0.0, 0.0255
"""m/s between which the edge is looked for at the start."""
OPEN = 0.5
"""Mean and standard deviation of what an undecided wheel moves by."""
ALIKE = 0.9
"""Correlation of two wheels that are asked for the same speed."""
SURE, NEAR = 0.15, 0.35
"""An answer is decided when the standard deviation is below this, and the mean so near."""


class DeadBand:
    """Where the edge lies, and which wheels are undecided."""

    def __init__(self, stands: float = SLOWEST, moves: float = FASTEST) -> None:
        self.stands, self.moves = stands, moves
        """Fastest request known to stand, slowest known to move, m/s."""
        self.asked = [0.0, 0.0]
        self.open = [False, False]

    def doubt(self) -> None:
        """Note that a reading was not what was expected."""
        if any(0 < speed < FASTEST for speed in self.asked):
            self.forget()

    def forget(self) -> None:
        """Doubt again where the edge lies."""
        self.stands, self.moves = SLOWEST, FASTEST

    def ask(self, right: float, left: float) -> list[float | None]:
        """Take a request for both wheels; return what each moves by, None where nobody knows."""
        self.asked = [abs(right), abs(left)]
        answers: list[float | None] = []
        for speed in self.asked:
            if not speed or speed >= self.moves:
                answers.append(1.0)
            else:
                answers.append(0.0 if speed <= self.stands else None)
        self.open = [answer is None for answer in answers]
        return answers

    def decide(self, rows: Assumptions, answers: list[float | None]) -> None:
        """Set what the wheels move by at their requests; None is open."""
        for index, answer in zip(s.MOVES, answers):
            if answer is None:
                rows.clear(index, OPEN, OPEN ** 2)
            else:
                rows.clear(index, answer)
        if answers == [None, None] and self.asked[0] == self.asked[1]:
            right, left = s.MOVES
            rows.p[:, right, left] = rows.p[:, left, right] = ALIKE * OPEN ** 2

    def learn(self, rows: Assumptions) -> list[int]:
        """Decide the wheels of which the best track is sure by now; return those that stand."""
        stand = []
        for wheel, index in enumerate(s.MOVES):
            mean, spread = float(rows.means[0, index]), float(rows.p[0, index, index]) ** 0.5
            if not self.open[wheel] or spread > SURE:
                continue
            answer = round(mean)
            if abs(mean - answer) > NEAR:
                continue
            if answer:
                self.moves = min(self.moves, self.asked[wheel])
            else:
                self.stands = max(self.stands, self.asked[wheel])
                stand.append(wheel)
            rows.settle(index, answer)
            self.open[wheel] = False
        if self.stands >= self.moves:
            self.forget()
        return stand
