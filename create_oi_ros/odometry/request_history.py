# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the wheels were asked lately: requests and their signs, as sums over time.

A wheel follows a request some dead time later, its encoder may take the request's sign at once or
as late. Means over a frame that ended a dead time ago are differences of sums at two moments, so
they change smoothly with the dead time.
"""

from collections.abc import Iterator, Sequence
from math import copysign

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RECENT = 0.35
"""Seconds after which the past of a request no longer matters: longer than any dead time."""
STEP = 0.03
"""A change of request from one frame to the next that is larger is a step, m/s. The driver's
limits allow less, unless somebody sets others."""
ROOM = 64
"""Changes of request that are remembered: more than come within that time, one a frame."""


class RequestHistory:
    """Both wheels' requests of the last moments; right first, m/s and seconds."""

    def __init__(self) -> None:
        self.speeds = np.zeros(2)
        self.asked = 0.0, 0.0
        """The same as numbers."""
        self._kept = [1.0, 1.0]
        self._of_signs: list[float] = []
        """The signs as numbers: kept, then upward, right first in each."""
        self._times = np.full(ROOM, np.inf)
        """When each request came, then infinity."""
        self._later = self._times[1:]
        self._rates, self._sums = np.zeros((6, ROOM)), np.zeros((6, ROOM))
        """Each request as a column: speeds, kept signs, upward signs; and their sums when it came.
        """
        self.settle()

    def settle(self) -> None:
        """Take the present requests to have held for long."""
        self.age = np.inf
        """Seconds since the last change."""
        self._broken_at: list[float] = []
        """When requests were a step, or changed a sign."""
        self._now = 0.0
        self._times[:] = np.inf
        self._alike_since = -np.inf
        """Since when all signs have been the same; infinity: they are not."""
        self._begin(0, -RECENT, [0.0] * 6)
        self._compare_signs()

    def ask(self, right: float, left: float, stands: Sequence[bool]) -> Array:
        """
        Take requests that hold from now on; return by how much they changed.

        `stands`: whether such a request is too slow to move a wheel. Its sign counts.
        """
        if self.age > RECENT:
            self.settle()
        if any(self.turning(right, left)) or any(
                abs(speed - before) > STEP for speed, before in zip((right, left), self.asked)):
            recent = [at for at in self._broken_at if at > self._now - RECENT]
            self._broken_at = [*recent, self._now]
        self.asked = asked = right, left
        speeds = np.array([0.0 if stand else speed for stand, speed in zip(stands, asked)])
        change, self.speeds = speeds - self.speeds, speeds
        self._kept = [copysign(1.0, speed) if speed else kept
                      for speed, kept in zip(asked, self._kept)]
        held, signs = self._now - self._since, self.signs
        sums = [total + rate * held for total, rate in zip(self._total, self._rate)]
        self._begin(self._make_room(), self._now, sums)
        if self.signs is not signs:
            self._alike_since = self._now
        self.age = 0.0
        self._compare_signs()
        return change

    def turning(self, right: float, left: float) -> list[bool]:
        """Return of which wheel such requests would change a sign."""
        return [(speed >= 0) != (upward > 0) or bool(speed and copysign(1.0, speed) != kept)
                for speed, kept, upward in zip((right, left), self._kept, self._of_signs[2:])]

    def broken(self, first: Array, last: Array) -> Iterator[Array]:
        """
        Return the moments between two others at which requests broke, all as seconds ago.

        The last axis is for a track's own dead time and its copy's. Only what broke within the
        time of some track itself is told, as an array like those and within their times.
        """
        for at in self._broken_at:
            ago = self._now - at
            if np.count_nonzero(((last < ago) & (ago < first))[..., :1]):
                yield np.minimum(np.maximum(ago, last), first)

    def stand(self, wheel: int) -> None:
        """Note that the present request never moved a wheel."""
        self.speeds[wheel] = self._rate[wheel] = self._rates[wheel, self._last] = 0.0

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
        since = self._later.searchsorted(when)
        sums = self._rates.take(since, axis=1)  # take: a fifth of what an index costs
        sums *= when - self._times.take(since)
        sums += self._sums.take(since, axis=1)
        return sums.reshape(3, 2, *ago.shape)

    def _begin(self, column: int, since: float, sums: list[float]) -> None:
        """Write the present requests down."""
        signs = [*self._kept, *(1.0 if speed >= 0 else -1.0 for speed in self.asked)]
        self._last, self._since, self._total = column, since, sums
        self._rate: list[float] = [*self.speeds.tolist(), *signs]
        if signs != self._of_signs:
            self._of_signs = signs
            kept, up = np.array(signs).reshape(2, 2, 1, 1)
            self.signs: tuple[Array, Array] = kept, up
            """The signs of the last requests that were not zero, and of these where zero is up."""
        self._times[column] = since
        self._rates[:, column] = self._rate
        self._sums[:, column] = sums

    def _make_room(self) -> int:
        """Return the next free column, the first half of them forgotten where there is none."""
        if self._last + 1 < ROOM:
            return self._last + 1
        left = ROOM // 2
        for array in (self._times, self._rates, self._sums):
            array[..., :left] = array[..., left:]
        self._later[left - 1:] = np.inf
        return left

    def _compare_signs(self) -> None:
        """See whether it makes a difference where an encoder takes its sign from."""
        kept, up = self._rate[2:4], self._rate[4:]
        alike = kept == up and self._alike_since < self._now - RECENT
        self.one_sign = self.signs[0] if alike else None
        """The sign of each wheel, where all kinds of sign have been the same lately."""
