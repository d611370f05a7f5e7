# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Slow requests that may not move a wheel at all: what is known of the edge.

A Create's wheels do not turn when they are asked for less than some speed. Between the fastest
request that was seen not to move a wheel and the slowest that was seen to, the state `MOVES` of a
wheel (0 to 1) is open; readings tell, and the edge is known better from then on. Requests that
pass quickly through the slow speeds share one answer: what a wheel does on average under them.
"""

from . import states as s
from .assumptions import Assumptions

SLOWEST, FASTEST = 0.0, 0.0255
"""m/s between which the edge is looked for at the start."""
OPEN = 0.5
"""Mean and standard deviation of what an undecided wheel moves by."""
ALIKE = 0.9
"""Correlation of two wheels that are asked for the same speed."""
QUICK = 0.05
"""Seconds from one request to the next within which they share an answer."""
MOSTLY = 5.0
"""How many times as long as those before it the last request must have held, for a shared answer
to be its own."""
SURE, NEAR = 0.15, 0.35
"""An answer is decided when the standard deviation is below this, and the mean so near."""


class DeadBand:
    """Where the edge lies, and which wheels are undecided."""

    def __init__(self, stands: float = SLOWEST, moves: float = FASTEST) -> None:
        self.stands, self.moves = stands, moves
        """Fastest request known to stand, slowest known to move, m/s."""
        self.asked = [0.0, 0.0]
        self.open = [False, False]
        self.goes_on = False
        """Whether the last request shares the answers to the one before."""
        self._answers: list[float | None] = [1.0, 1.0]
        self._told = False
        """Whether a reading has come since they were given."""
        self._shared = 0.0
        """Seconds of the requests before the last one that share its answers."""

    def doubt(self) -> None:
        """Note that a reading was not what was expected."""
        if any(0 < speed < FASTEST for speed in self.asked):
            self.forget()

    def forget(self) -> None:
        """Doubt again where the edge lies."""
        self.stands, self.moves = SLOWEST, FASTEST

    def ask(self, right: float, left: float, held: float) -> list[float | None]:
        """
        Take a request for both wheels; return what each moves by, None where nobody knows.

        `held`: for how many seconds the one before has held.
        """
        before, self.asked = self.asked, [abs(right), abs(left)]
        answers: list[float | None] = []
        for speed in self.asked:
            if not speed or speed >= self.moves:
                answers.append(1.0)
            else:
                answers.append(0.0 if speed <= self.stands else None)
        self.open = [answer is None for answer in answers]
        self.goes_on = (any(self.open) and answers == self._answers and not self._told
                        and held < QUICK and _are_alike(self.asked) == _are_alike(before))
        self._shared = self._shared + held if self.goes_on else 0.0
        self._answers, self._told = answers, False
        return answers

    def decide(self, rows: Assumptions, answers: list[float | None]) -> None:
        """Set what the wheels move by at their requests; None is open."""
        for index, answer in zip(s.MOVES, answers):
            if answer is None:
                rows.clear(index, OPEN, OPEN ** 2)
            else:
                rows.clear(index, answer)
        if answers == [None, None] and _are_alike(self.asked):
            right, left = s.MOVES
            rows.p[:, right, left] = rows.p[:, left, right] = ALIKE * OPEN ** 2

    def learn(self, rows: Assumptions, held: float) -> list[int]:
        """
        Decide the wheels of which the best track is sure by now; return those that stand.

        `held`: for how many seconds the last request has.
        """
        self._told = True
        if any(self.open) and held < MOSTLY * self._shared:
            self._shared = 0.0
            self.decide(rows, self._answers)
            return []
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


def _are_alike(speeds: list[float]) -> bool:
    return speeds[0] == speeds[1]
