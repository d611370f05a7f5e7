# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What readings say about the model itself: a model that fails becomes doubt.

Innovations tell how much noise there is. A reading that no noise explains is believed as it is,
and when the best track has explained little for long, everything is tried again.
"""

import numpy as np

from . import accumulators, noise
from . import states as s
from .accumulators import Wholes
from .assumptions import Assumptions, LIKELY_UNSTEADY, UNSTEADY, YOUNG
from .noise import Scales
from .request_history import Array

SURPRISE, LEFT = 3.0, 2.0
"""Standard deviations from which on a reading is a surprise, and what is left of it."""
HASTE, FADING, LEAST_DOUBT, MOST_DOUBT = 0.3, 0.96, 0.3, 1e4
"""How fast doubt follows the innovations, by which power it fades at each reading, and between
what it stays."""
LOST, ENOUGH, PAUSE, REBORN = 4.0, 12, 40, 1e-2
"""Doubt, for how many readings, from which on all else is tried again; readings until the next
time; the weight of what is tried."""
UNLIKE = 0.03
"""Factor of that weight where a track takes the readings for rounded in another way: steady wheels
have told the rounding, and that does not depend on how wheels follow a change."""
UNSEEN, ODD = 0.2, 4.0
"""Part of a reading's oddity that becomes doubt even where process noise has no share in it; the
square of the standard deviations from which on a reading is odd. Readings of a robot that is
new may be."""
KEPT, FARTHEST, UNLIKELY = 0.97, 16.0, -8.0
"""How much of what was learned of unsteady wheels the next reading leaves; the square of the
standard deviations beyond which a reading tells no more of them; the least of a logarithm."""
LEAST_VARIANCE = 1e-12
"""m² and rad²."""
OUTSIDE = slice(s.MOVES_RIGHT, s.DISTANCE)
"""States that have nothing to do with what is assumed of a robot."""


class Doubt:
    """How well the tracks of an odometry explain their readings."""

    def __init__(self) -> None:
        self._astray = 0
        """Readings in a row that the best track did not explain."""
        self.is_surprised = False
        """Whether the best track did not expect the last reading."""
        self._gaps = self._spreads = np.ones((2, 1))
        """How far the last reading was from what was expected, and the standard deviations."""

    def meet(self, rows: Assumptions, wholes: Wholes, noisy: Array, scales: Scales) -> Array:
        """
        Learn from the innovations how much noise there is; meet surprises with more of it.

        `noisy`: variance of the accumulators that is process noise. Return the logarithm of what a
        surprise leaves of each track's likelihood.
        """
        gaps, spreads = self._gaps, self._spreads = accumulators.innovation(rows, wholes)
        z = gaps / spreads
        beyond = np.maximum(np.abs(z).max(axis=0) - SURPRISE, 0.0)
        self.is_surprised = bool(beyond[0] > 0)
        share = noisy / spreads ** 2
        growth = share * np.clip(z * z - 1, -1, 6)
        if rows.readings > YOUNG:
            growth += UNSEEN * np.clip(z * z - ODD, 0, 6)
        rows.doubt = np.clip(rows.doubt ** FADING * np.exp(HASTE * growth.sum(axis=0)),
                             LEAST_DOUBT, MOST_DOUBT)
        if beyond.any():
            more = np.where(np.abs(z) > SURPRISE, (gaps / LEFT) ** 2 - spreads ** 2, 0.0)
            rows.p += noise.of_surprise(more[0], more[1], rows.means[:, s.YAW], scales)
        left: Array = -np.minimum(2 * beyond, 3.0)
        return left

    def watch(self, rows: Assumptions, path: Array, width: Array) -> None:
        """
        Learn from the reading just met how steadily the wheels run whose requests stayed the same.

        `path`: metres that each wheel rolled since the reading before.
        """
        way = path.sum(axis=0)
        logs = KEPT * rows.steadiness + (1 - KEPT) * LIKELY_UNSTEADY
        for gap, spread, each in zip(self._gaps, self._spreads, (way / 4, way / width ** 2)):
            known = np.maximum(spread ** 2 - each * rows.unsteady, LEAST_VARIANCE)
            variance = known[:, None] + each[:, None] * UNSTEADY
            logs -= (np.minimum(gap[:, None] ** 2 / variance, FARTHEST) + np.log(variance)) / 2
        rows.steadiness = np.maximum(logs - logs.max(axis=1)[:, None], UNLIKELY)

    def rethink(self, rows: Assumptions, *, free: bool) -> None:
        """Try everything again beside the tracks that have explained little for long."""
        self._astray = self._astray + 1 if rows.doubt[0] > LOST else min(self._astray, 0)
        if self._astray < ENOUGH or free:
            return
        self._astray = -PAUSE
        others = Assumptions.new() if rows.open_signs else Assumptions.all()
        others.means[:, OUTSIDE] = rows.means[0, OUTSIDE]
        others.p[:, OUTSIDE, OUTSIDE] = rows.p[0, OUTSIDE, OUTSIDE]
        others.rates[:] = rows.rates[0]
        accumulators.empty(others)
        others.weights[[each is not rows.roundings[0] for each in others.roundings]] *= UNLIKE
        others.weights /= others.weights.sum()
        rows.doubt[:] = 1.0  # else what the readings say would count for nothing
        rows.join(others, REBORN)
        rows.patient = True
        rows.readings = 0
        rows.taught = 0.0
