"""
What readings say about the model itself: a model that fails becomes doubt.

Innovations tell how much noise there is. A reading that no noise explains is believed as it is,
and when the best track has explained little for long, everything is tried again.
"""

import numpy as np

from . import accumulators, noise
from . import states as s
from .accumulators import Wholes
from .assumptions import Assumptions, YOUNG
from .noise import Scales
from .request_history import Array

SURPRISE, LEFT = 3.0, 2.0
"""Standard deviations from which on a reading is a surprise, and what is left of it."""
HASTE, FADING, LEAST_DOUBT, MOST_DOUBT = 0.3, 0.96, 0.3, 1e4
"""How fast doubt follows the innovations, by which power it fades at each reading, and between
what it stays."""
LOST, ENOUGH, PAUSE, REBORN = 30.0, 12, 40, 1e-2
"""Doubt, for how many readings, from which on all else is tried again; readings until the next
time; the weight of what is tried."""
UNEASY, RECHECK, REOPENED = 1.1, 30, 0.1
"""Doubt from which on kinds of robot that were given up are tried again, with what was learned;
readings between two trials; the part of what was not known at first that is doubted for it."""
OUTSIDE = slice(s.MOVES_RIGHT, s.DISTANCE)
"""States that have nothing to do with what is assumed of a robot."""


class Doubt:
    """How well the tracks of an odometry explain their readings."""

    def __init__(self) -> None:
        self._astray = 0
        """Readings in a row that the best track did not explain."""
        self._unchecked = 0
        """Readings since other kinds of robot were tried."""
        self.is_surprised = False
        """Whether the best track did not expect the last reading."""

    def meet(self, rows: Assumptions, wholes: Wholes, noisy: Array, scales: Scales) -> Array:
        """
        Learn from the innovations how much noise there is; meet surprises with more of it.

        `noisy`: variance of the accumulators that is process noise. Return the logarithm of what a
        surprise leaves of each track's likelihood.
        """
        gaps, spreads = accumulators.innovation(rows, wholes)
        z = gaps / spreads
        beyond = np.maximum(np.abs(z).max(axis=0) - SURPRISE, 0.0)
        self.is_surprised = bool(beyond[0] > 0)
        share = noisy / spreads ** 2
        growth = HASTE * (share * np.clip(z * z - 1, -1, 6)).sum(axis=0)
        rows.doubt = np.clip(rows.doubt ** FADING * np.exp(growth), LEAST_DOUBT, MOST_DOUBT)
        if beyond.any():
            more = np.where(np.abs(z) > SURPRISE, (gaps / LEFT) ** 2 - spreads ** 2, 0.0)
            rows.p += noise.of_surprise(more[0], more[1], rows.means[:, s.YAW], scales)
        left: Array = -np.minimum(2 * beyond, 3.0)
        return left

    def rethink(self, rows: Assumptions, *, free: bool) -> None:
        """Try other tracks beside those that have explained little for long."""
        self._astray = self._astray + 1 if rows.doubt[0] > LOST else min(self._astray, 0)
        self._unchecked += 1
        if free:
            return
        if self._astray >= ENOUGH:
            self._astray = -PAUSE
            self._begin_again(rows)
        elif rows.doubt[0] > UNEASY and self._unchecked > RECHECK and rows.readings > YOUNG:
            self._unchecked = 0
            self._recheck(rows)

    def _begin_again(self, rows: Assumptions) -> None:
        """Try everything that a robot may be."""
        others = Assumptions.all()
        others.means[:, OUTSIDE] = rows.means[0, OUTSIDE]
        others.p[:, OUTSIDE, OUTSIDE] = rows.p[0, OUTSIDE, OUTSIDE]
        accumulators.empty(others)
        rows.join(others, REBORN)
        rows.readings = 0

    def _recheck(self, rows: Assumptions) -> None:
        """Try the kinds of robot that were given up, otherwise as the best track is."""
        others = rows.given_up()
        if others is None:
            return
        for index, prior in (s.COMMON | s.RESPONSES[0]).items():
            others.p[:, index, index] += (REOPENED * prior.spread) ** 2
        accumulators.empty(others)
        rows.join(others, REBORN)
