# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What may be assumed of a robot, and how plausible each assumption is.

An assumption is how readings are rounded, where encoders take their signs from, and the kind of
response that a track begins with.
"""

from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robot import Rounding
from . import states as s
from .encoder_signs import LAST, NONE, Signs, UPWARD
from .mark import MarkedPose
from .request_history import Array

LIKELY_ROUNDING = {Rounding.TRUNCATE: 2.0}
LIKELY_SIGN = {(NONE, False): 1.0, (LAST, False): 2.0, (LAST, True): 4.0, (UPWARD, False): 1.0,
               (UPWARD, True): 1.0}
"""How much likelier than the rest a robot truncates, and signs of encoders are, before the first
reading: the likely ones were reported of real robots. A sign may wait for the dead time."""
SIGNS, LIKELIEST_SIGN = tuple(LIKELY_SIGN), max(LIKELY_SIGN, key=LIKELY_SIGN.__getitem__)
LIKELY_RESPONSE = [1.0] * len(s.LAGS) + [0.4, 0.1]
"""The same of each response: springs were not seen on a first Create, and soft brakes are one more
thing to assume."""
IMPLAUSIBLE, NEGLIGIBLE = 1e-6, 1e-4
"""Weights below which a track is given up, and below which it has no share in the estimate."""
FAINT = 1e-4
"""Part of the weight of the best spring below which a spring is given up, and likewise a lag:
springs learn later than lags what their wheels are like, so these do not judge them."""
UNSTEADY = np.array([0.0, 0.002, 0.005, 0.01]) ** 2
"""How much the speed of wheels that are asked for one speed may wander: variance of their travel,
m² for each metre."""
LIKELY_UNSTEADY = np.log([0.93, 0.04, 0.02, 0.01])
"""How likely each of these is before the first reading, as a logarithm."""
AGAIN, LEAST_AFRESH = 0.45, 1e-3
"""Part of what was learned that counts where the same readings are used again, and the weight that
an assumption has then which was given up."""
WHEELS = slice(s.SEPARATION + 1)
"""The states that are properties of the wheels."""
OF_SPRINGS, OF_LAGS = (
    np.array([max((s.COMMON | response)[index].spread for response in responses)
              for index in range(WHEELS.stop)])
    for responses in (s.SPRINGS, s.LAGS))
"""Standard deviations of these states at first."""
NEAR = 1e-3
"""Part of the weight of the better of two responses up to which the other one is kept: springs
learn later than lags what their wheels are like."""
YOUNG = 30
"""Readings from which on only one track of each kind is kept."""
LOWEST, HIGHEST = np.array([(prior.low, prior.high) for prior in s.PRIORS]).T
"""The range of each state; springs have their own damping."""
SMALLEST_STEP = 1e-5
"""Least difference between a copy of the wheels and its track."""
LEAST = 4.0
"""The most by which one reading may tell two tracks apart, as a logarithm."""


@dataclass
class Assumptions:
    """The rows of all tracks; the best first after each reading."""

    roundings: list[Rounding]
    signs: Signs
    springs: NDArray[np.bool_]
    """Whether wheels overshoot."""
    weights: Array
    doubt: Array
    """What process noise is multiplied by, as innovations have it."""
    means: Array
    p: Array
    """Covariances, a matrix a track."""
    rates: Array
    """How fast the speeds of springs change, m/s², right and left; part of no covariance."""
    readings: int = 0
    taught: float = 0.0
    """How many of these were far enough apart to tell how the wheels run."""
    open_signs: bool = False
    """Whether each track stands for all signs of encoders: none has made a difference yet."""
    patient: bool = False
    """Whether what is right may be faint at first: all is tried again, or the robot may be another
    one than was known."""
    mark: MarkedPose | None = None
    """Where the robot was at a moment; None: nobody wants to know."""
    steadiness: Array = field(init=False)
    """Logarithms of how plausible each of `UNSTEADY` is of the wheels, a row a track."""

    def __post_init__(self) -> None:
        """Suppose of all tracks alike how steady the wheels run."""
        self.steadiness = np.tile(LIKELY_UNSTEADY, (len(self.weights), 1))

    @property
    def unsteady(self) -> Array:
        """Variance of travel by which wheels stray, m² for each metre: the likeliest, a track."""
        likeliest: Array = UNSTEADY.take(self.steadiness.argmax(axis=1))
        return likeliest

    @classmethod
    def all(cls) -> 'Assumptions':
        """Assume anything that is plausible of a robot that nobody knows."""
        kinds = list(product(Rounding, SIGNS, s.RESPONSES))
        springs = np.array([response in s.SPRINGS for _, _, response in kinds])
        weights = np.array([LIKELY_ROUNDING.get(rounding, 1.0) * LIKELY_SIGN[sign]
                            for rounding, sign, _ in kinds])
        weights *= np.resize(LIKELY_RESPONSE, len(kinds))  # the response varies fastest
        means, p = np.zeros((len(kinds), s.SIZE)), np.zeros((len(kinds), s.SIZE, s.SIZE))
        for row, (_, _, response) in enumerate(kinds):
            for index, prior in (s.COMMON | response).items():
                means[row, index], p[row, index, index] = prior.mean, prior.spread ** 2
        signs = Signs(np.array([kind for _, (kind, _), _ in kinds]),
                      np.array([late for _, (_, late), _ in kinds]))
        return cls([rounding for rounding, _, _ in kinds], signs, springs,
                   weights / weights.sum(), np.ones(len(kinds)), means, p,
                   np.zeros((len(kinds), 2)))

    @classmethod
    def new(cls) -> 'Assumptions':
        """Assume the same, with one track for all signs: wheels at rest have none."""
        rows = cls.all()
        rows.keep([i for i, sign in enumerate(zip(*rows.signs)) if sign == LIKELIEST_SIGN])
        rows.open_signs = True
        return rows

    def tell_signs_apart(self) -> None:
        """Let each track become one for each sign: from now on they make a difference."""
        self.open_signs, count = False, len(self.weights)
        self.keep(np.repeat(np.arange(count), len(SIGNS)).tolist())
        self.signs = Signs(*map(np.array, zip(*SIGNS * count)))
        self.weights *= np.tile(list(LIKELY_SIGN.values()), count)
        self.weights /= self.weights.sum()

    def afresh(self) -> 'Assumptions':
        """
        Return tracks that know the wheels as these do, and nothing else: none is given up yet.

        The best of each rounding and sign goes on. What none of these assumes is assumed with the
        wheels of the best one.
        """
        best = self._best_of_each([*range(len(self.roundings))])
        own = [(self.roundings[i], (int(self.signs.kinds[i]), bool(self.signs.late[i])))
               for i in best]
        others = (LIKELIEST_SIGN,) if self.open_signs else SIGNS
        more = [kind for kind in product(Rounding, others) if kind not in own]
        kinds, rows = own + more, best + [0] * len(more)
        means, p = np.zeros((len(rows), s.SIZE)), np.zeros((len(rows), s.SIZE, s.SIZE))
        means[:, WHEELS], means[:, s.MOVES] = self.means[rows, WHEELS], 1.0
        p[:, WHEELS, WHEELS] = _less_sure(self.p[rows, WHEELS, WHEELS], self.springs[rows])
        weights = np.full(len(rows), LEAST_AFRESH)
        weights[:len(own)] = 1.0
        signs = Signs(np.array([kind for _, (kind, _) in kinds]),
                      np.array([late for _, (_, late) in kinds]))
        return Assumptions(
            [rounding for rounding, _ in kinds], signs, self.springs[rows],
            weights / weights.sum(), np.ones(len(rows)), means, p, np.zeros((len(rows), 2)),
            open_signs=self.open_signs)

    def shares(self) -> Array:
        """Return what each track contributes to the estimate."""
        shares: Array = np.where(self.weights < NEGLIGIBLE, 0.0, self.weights)
        shares /= shares.sum()
        return shares

    def steps(self) -> Array:
        """Return by how much the copies of each track's wheels are off, each in its unknown."""
        variances = self.p.diagonal(axis1=1, axis2=2)[:, :s.UNKNOWNS]
        steps: Array = np.sqrt(np.maximum(variances, SMALLEST_STEP ** 2))
        steps[~self.springs, s.BRAKING] *= -1  # softer brakes: harder ones tell nothing
        return steps

    def weigh(self, logs: Array) -> None:
        """Weigh the tracks by how likely each found a reading (logarithms); drop some."""
        weights = self.weights * np.exp(np.maximum(logs - logs.max(), -LEAST))
        weights /= weights.sum()
        least: Array | float = IMPLAUSIBLE
        if not self.patient:
            least = np.maximum(IMPLAUSIBLE, FAINT * self._best_alike(weights))
        plausible = weights > least
        self.weights = weights
        self.readings += 1
        order = [int(i) for i in np.argsort(-weights) if plausible[i]]
        if self.readings > YOUNG:
            order = self._best_of_each(order)
        self.keep(order)

    def _best_alike(self, weights: Array) -> Array:
        """Return for each track the largest of these weights among its kind: springs, or lags."""
        springs, lags = (
            weights[kind].max(initial=0.0) for kind in (self.springs, ~self.springs))
        best: Array = np.where(self.springs, springs, lags)
        return best

    def _best_of_each(self, order: list[int]) -> list[int]:
        """Return the best track of each rounding and sign; its other response if it comes near."""
        kept: list[int] = []
        best: dict[Any, dict[bool, int]] = {}
        for i in order:
            of_sign = best.setdefault(
                (self.roundings[i], int(self.signs.kinds[i]), bool(self.signs.late[i])), {})
            spring = bool(self.springs[i])
            if spring not in of_sign and all(
                    self.weights[i] >= NEAR * self.weights[other] for other in of_sign.values()):
                of_sign[spring] = i
                kept.append(i)
        return kept

    def bound(self) -> None:
        """Keep all unknowns where they can be."""
        np.clip(self.means, LOWEST, HIGHEST, out=self.means)
        damping = s.SPRING[s.DAMPING]
        values = self.means[:, s.DAMPING]
        values[self.springs] = np.clip(values[self.springs], damping.low, damping.high)

    def join(self, others: 'Assumptions', weight: float) -> None:
        """Try others beside these, which have this weight together."""
        def both(mine: Array, theirs: Array) -> Array:
            return np.concatenate([mine, theirs])
        self.roundings = self.roundings + others.roundings
        self.signs = Signs(*map(both, self.signs, others.signs))
        self.weights = both(self.weights * (1 - weight), others.weights * weight)
        self.doubt, self.means = both(self.doubt, others.doubt), both(self.means, others.means)
        self.p, self.rates = both(self.p, others.p), both(self.rates, others.rates)
        self.springs = np.concatenate([self.springs, others.springs])
        self.steadiness = both(self.steadiness, others.steadiness)
        if self.mark is not None:
            self.mark.join(len(others.roundings))

    def clear(self, index: int, mean: float = 0.0, variance: float | Array = 0.0) -> None:
        """Set what all tracks believe of a state, whatever they have learned."""
        self.means[:, index] = mean
        self.p[:, index, :] = self.p[:, :, index] = 0.0
        self.p[:, index, index] = variance
        if self.mark is not None:
            self.mark.clear(index)

    def settle(self, index: int, value: float) -> None:
        """Learn the exact value of a state that all tracks share."""
        column = self.p[:, :, index].copy()
        variance = np.maximum(column[:, index], 1e-12)[:, None]
        if self.mark is not None:
            scale = variance[:, 0]
            self.mark.cut(column, index, (value - self.means[:, index]) / scale, 1 / scale)
        self.means += column * ((value - self.means[:, index, None]) / variance)
        self.p -= column[:, :, None] * column[:, None, :] / variance[:, :, None]
        self.clear(index, value)

    def keep(self, order: list[int]) -> None:
        """Keep these tracks, in this order."""
        self.roundings = [self.roundings[i] for i in order]
        self.signs = Signs(self.signs.kinds[order], self.signs.late[order])
        self.weights = self.weights[order] / self.weights[order].sum()
        self.doubt, self.means, self.p = self.doubt[order], self.means[order], self.p[order]
        self.springs, self.rates = self.springs[order], self.rates[order]
        self.steadiness = self.steadiness[order]
        if self.mark is not None:
            self.mark.keep(order)


def _less_sure(p: Array, springs: NDArray[np.bool_]) -> Array:
    """Return covariances of the wheels in which only a part counts of what was learned."""
    spreads = np.where(springs[:, None], OF_SPRINGS, OF_LAGS)
    prior: Array = np.eye(WHEELS.stop) / spreads[:, :, None] ** 2
    learned: Array = np.linalg.inv(p).astype(np.float64)
    return np.linalg.inv(AGAIN * learned + (1 - AGAIN) * prior).astype(np.float64)
