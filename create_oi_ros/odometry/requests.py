"""
What the wheels were asked lately: requests and their signs, as sums over time.

A wheel follows a request some dead time later, its encoder may take the request's sign at once or
as late. Means over a frame that ended a dead time ago are differences of sums at two moments, so
they change smoothly with the dead time.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROWS = 48
"""Steps that are kept."""
SPEEDS, KEPT, UP = (0, 1), (2, 3), (4, 5)
"""Rows of the sums, right and left: the speed; the sign of the last speed that was not zero; the
sign where zero counts as forwards."""


class Requests:
    """Both wheels' requests over the last steps; right first, m/s and seconds."""

    def __init__(self) -> None:
        self.speeds = np.zeros(2)
        self.kept = np.ones(2)
        self.age = np.inf
        """Seconds since the last change."""
        self._times = np.linspace(-1.0, 0.0, ROWS)
        self._sums = np.zeros((6, ROWS))
        self._level()

    @property
    def rates(self) -> Array:
        """What the sums grow by in a second: speeds, kept signs, upward signs."""
        up = np.where(self.speeds >= 0, 1.0, -1.0)
        return np.concatenate([self.speeds, self.kept, up])

    def ask(self, right: float, left: float) -> Array:
        """Take requests that hold from now on; return by how much they changed."""
        if self.age > RECENT:
            self._level()
        asked = np.array([right, left])
        change = asked - self.speeds
        self.speeds = asked
        self.kept = np.where(asked != 0, np.sign(asked), self.kept)
        self.age = 0.0
        return change

    def step(self, seconds: float) -> None:
        """Let time pass."""
        self.age += seconds
        if self.age - seconds > RECENT:
            return
        self._times[:-1] = self._times[1:]
        self._times[-1] += seconds
        self._sums[:, :-1] = self._sums[:, 1:]
        self._sums[:, -1] += self.rates * seconds

    def sums(self, rows: tuple[int, int], ago: Array) -> Array:
        """Return a pair of sums as they were some seconds ago, for both wheels."""
        when = self._times[-1] - ago
        return np.stack([np.interp(when, self._times, self._sums[row]) for row in rows])

    def settle(self) -> None:
        """Take the present requests to have held for long."""
        self.age = 10.0
        self._level()

    def _level(self) -> None:
        """Fill the past with the present requests, which have held for long."""
        past = np.linspace(-ROWS * 0.015, 0.0, ROWS)
        self._times = past
        self._sums = np.outer(self.rates, past)


RECENT = 0.35
"""Seconds after which the past of a request no longer matters: longer than any dead time."""
