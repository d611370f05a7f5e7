# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the wheels were asked lately: requests and their signs, as sums over time.

A wheel follows a request some dead time later, its encoder may take the request's sign at once or
as late. Means over a frame that ended a dead time ago are differences of sums at two moments, so
they change smoothly with the dead time.
"""

from collections.abc import Sequence
from math import copysign

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RECENT = 0.35
"""Seconds after which the past of a request no longer matters: longer than any dead time."""


class RequestHistory:
    """Both wheels' requests of the last moments; right first, m/s and seconds."""

    def __init__(self) -> None:
        self.speeds = np.zeros(2)
        self.asked = 0.0, 0.0
        """The same as numbers."""
        self._kept = [1.0, 1.0]
        self.settle()

    @property
    def signs(self) -> tuple[Array, Array]:
        """The signs of the last requests that were not zero, and of these where zero is up."""
        return self._rates[2:4, -1, None, None], self._rates[4:, -1, None, None]

    def settle(self) -> None:
        """Take the present requests to have held for long."""
        self.age = np.inf
        """Seconds since the last change."""
        self._now = 0.0
        self._times = np.array([-RECENT])
        self._rates = self._present()
        self._sums = np.zeros((6, 1))
        self._compare_signs()

    def ask(self, right: float, left: float, stands: Sequence[bool]) -> Array:
        """
        Take requests that hold from now on; return by how much they changed.

        `stands`: whether such a request is too slow to move a wheel. Its sign counts.
        """
        if self.age > RECENT:
            self.settle()
        self.asked = asked = right, left
        speeds = np.array([0.0 if stand else speed for stand, speed in zip(stands, asked)])
        change, self.speeds = speeds - self.speeds, speeds
        self._kept = [copysign(1.0, speed) if speed else kept
                      for speed, kept in zip(asked, self._kept)]
        sums = self._sums[:, -1:] + self._rates[:, -1:] * (self._now - self._times[-1])
        first = max(int(self._times.searchsorted(self._now - RECENT)) - 1, 0)
        self._times = np.concatenate([self._times[first:], [self._now]])
        self._sums = np.concatenate([self._sums[:, first:], sums], axis=1)
        self._rates = np.concatenate([self._rates[:, first:], self._present()], axis=1)
        self.age = 0.0
        self._compare_signs()
        return change

    def stand(self, wheel: int) -> None:
        """Note that the present request never moved a wheel."""
        self.speeds[wheel] = self._rates[wheel, -1] = 0.0

    def step(self, seconds: float) -> None:
        """Let time pass."""
        self.age += seconds
        self._now += seconds

    def sums(self, ago: Array) -> Array:
        """
        Return the sums as they were some seconds ago, with the axes of `ago` last.

        Speeds, kept signs, upward signs (zero is up); of both wheels, right first.
        """
        when = self._now - ago.ravel()
        since = np.maximum(self._times.searchsorted(when) - 1, 0)
        sums = self._rates.take(since, axis=1)  # take: a fifth of what an index costs
        sums *= when - self._times.take(since)
        sums += self._sums.take(since, axis=1)
        return sums.reshape(3, 2, *ago.shape)

    def _present(self) -> Array:
        up = [1.0 if speed >= 0 else -1.0 for speed in self.asked]
        return np.array([*self.speeds, *self._kept, *up]).reshape(6, 1)

    def _compare_signs(self) -> None:
        """See whether it makes a difference where an encoder takes its sign from."""
        signs = self._rates[2:].reshape(2, 2, -1)
        self.one_sign = signs[0, :, :1, None] if (signs == signs[0, :, :1]).all() else None
        """The sign of each wheel, where all kinds of sign have been the same lately."""
