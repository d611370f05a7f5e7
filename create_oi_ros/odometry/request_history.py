"""
What the wheels were asked lately: requests and their signs, as sums over time.

A wheel follows a request some dead time later, its encoder may take the request's sign at once or
as late. Means over a frame that ended a dead time ago are differences of sums at two moments, so
they change smoothly with the dead time.
"""

import numpy as np
from numpy.typing import NDArray

from ..robot import SLOT

Array = NDArray[np.float64]

ROWS = 48
"""Steps that are kept."""
RECENT = 0.35
"""Seconds after which the past of a request no longer matters: longer than any dead time."""


class RequestHistory:
    """Both wheels' requests over the last steps; right first, m/s and seconds."""

    def __init__(self) -> None:
        self.speeds = np.zeros(2)
        self._kept = np.ones(2)
        self.settle()

    @property
    def signs(self) -> tuple[Array, Array]:
        """The signs of the last requests that were not zero, and of these where zero is up."""
        return self._rates[2:4, None, None], self._rates[4:, None, None]

    def settle(self) -> None:
        """Take the present requests to have held for long."""
        self.age = np.inf
        """Seconds since the last change."""
        up = np.where(self.speeds >= 0, 1.0, -1.0)
        self._rates = np.concatenate([self.speeds, self._kept, up])
        self._level()

    def ask(self, right: float, left: float) -> Array:
        """Take requests that hold from now on; return by how much they changed."""
        if self.age > RECENT:
            self._level()
        asked = np.array([right, left])
        change = asked - self.speeds
        self.speeds = asked
        self._kept = np.where(asked != 0, np.sign(asked), self._kept)
        self._rates = np.concatenate([asked, self._kept, np.where(asked >= 0, 1.0, -1.0)])
        self.age = 0.0
        return change

    def step(self, seconds: float) -> None:
        """Let time pass."""
        before = self.age
        self.age += seconds
        if before > RECENT:
            return
        self._times[:-1] = self._times[1:]
        self._times[-1] += seconds
        self._sums[:, :-1] = self._sums[:, 1:]
        self._sums[:, -1] += self._rates * seconds

    def sums(self, ago: Array) -> Array:
        """
        Return the sums as they were some seconds ago, with the axes of `ago` last.

        Speeds, kept signs, upward signs (zero is up); of both wheels, right first.
        """
        when = (self._times[-1] - ago).ravel()
        sums = [np.interp(when, self._times, row) for row in self._sums]
        return np.array(sums).reshape((3, 2) + ago.shape)

    def _level(self) -> None:
        """Fill the past with the present requests, which have held for long."""
        self._times = np.linspace(-ROWS * SLOT, 0.0, ROWS)
        self._sums = np.outer(self._rates, self._times)
