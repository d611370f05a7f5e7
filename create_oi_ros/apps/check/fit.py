# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Finds the kind of wheels that explains a check best, by least squares.

The readings of all moves are compared with those of simulated wheels (`trial_wheels`), for both
families of response and each source of signs. Which rounding the robot has is known before
(`fractions`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from ...odometry import Family, Rounding
from ...robot import MILLI
from .notebook import Page
from .trial_wheels import Array, Kind, Sign, simulate
from .windows import Windows, windows


class Belief(NamedTuple):
    """What is believed of a number before, where it can be, and a step for its derivative."""

    mean: float
    spread: float
    low: float
    high: float
    step: float


LOG_TAU = (np.log(0.003), np.log(0.8))
COMMON = {
    Kind.RIGHT_GAIN: Belief(1.0, 0.1, 0.5, 1.6, 1e-3),
    Kind.LEFT_GAIN: Belief(1.0, 0.1, 0.5, 1.6, 1e-3),
    Kind.RIGHT_OFFSET: Belief(0.0, 0.003, -0.02, 0.03, 1e-4),
    Kind.LEFT_OFFSET: Belief(0.0, 0.003, -0.02, 0.03, 1e-4),
    Kind.DEAD_TIME: Belief(0.06, 0.05, 0.0, 0.25, 1e-3),
    Kind.SLOW: Belief(np.log(0.15), 1.0, *LOG_TAU, 1e-2),
    Kind.MIDDLE: Belief(np.log(0.15), 1.0, *LOG_TAU, 1e-2),
    Kind.QUICK: Belief(np.log(0.15), 1.0, *LOG_TAU, 1e-2),
    Kind.BRAKING: Belief(0.0, 0.6, -1.5, 1.5, 1e-2),
    Kind.SEPARATION: Belief(0.0, 0.03, -0.15, 0.15, 1e-3),
}
TAUS = (Kind.SLOW, Kind.MIDDLE, Kind.QUICK)
ALIKE = 0.7
"""How far logarithms of time constants at neighbouring speeds are apart: standard deviation."""


class InitialGuess(NamedTuple):
    """A kind of response that a fit begins with."""

    family: Family
    bound: Belief
    tau: float
    """Seconds."""


INITIAL_GUESSES = (
    InitialGuess(Family.LAG, Belief(0.0, 1.0, 0.0, 4.0, 1e-2), 0.15),
    InitialGuess(Family.LAG, Belief(1.0, 1.0, 0.0, 4.0, 1e-2), 0.01),
    InitialGuess(Family.SPRING, Belief(np.log(0.15), 1.0, np.log(0.005), np.log(0.6), 1e-2), 0.06),
)
ROUNDS, FEW = 25, 4
"""Rounds of a fit at most, and of one that only shows how much worse another sign is."""
ENOUGH = 0.5
"""Gain of a round below which no other round follows."""
USUAL = 0.5
"""Cost of a reading of distance or angle where the wheels are right."""
BAD = 0.6
"""Cost of a reading above which the wheels that were found are not right."""
SPRINGY = 0.7
"""Time constant of a spring over that of a lag that does much the same."""
OVERSHOOTS, TAU_FACTORS, BRAKINGS = np.log([0.05, 0.3]), (0.5, 1.5), (-0.8, 0.8)
"""Logarithms of overshoots and of how many times as fast a wheel brakes, and factors of time
constants, that are tried where no wheels were found to be right."""
CANDIDATES = 4
"""Fits that go on to the end."""
SOFT = 0.55 * np.array([0.3 * MILLI, np.radians(0.15)])
"""How soft the ends of intervals are, m and rad: an encoder's ticks are coarse, and a request
comes at some moment within a frame."""
LENGTHS = np.array([3.0, 1.5, 1.0, 0.5, 0.2, 0.05, 0.0])
"""Parts of a step that are tried."""


@dataclass(frozen=True)
class Fit:
    """Wheels that explain the readings."""

    start: InitialGuess
    sign: Sign
    kind: Array
    cost: float
    """How badly it explains the readings, as a logarithm of likelihood."""
    covariance: Array
    readings: int

    @property
    def cost_of_reading(self) -> float:
        """How badly it explains a reading."""
        return self.cost / self.readings

    @property
    def is_bad(self) -> bool:
        """Whether other wheels should be looked for."""
        return self.cost_of_reading > BAD

    @property
    def excess(self) -> float:
        """How much worse it explains readings than the right wheels would; at least 1."""
        return max(1.0, self.cost_of_reading / (2 * USUAL))


def fit(pages: Sequence[Page], rounding: Rounding, period: float) -> list[Fit]:
    """Return the best fit of each source of signs and each start that came far; best first."""
    seen = windows(pages, rounding, period)
    certain = seen.only([
        number for number, page in enumerate(pages)
        if all(min(segment.right, segment.left) >= 0 for segment in page.move.segments)])
    tried = []
    for start in INITIAL_GUESSES:
        kind = _first(start)
        kind = _finished(certain, start, Sign.MOTION, kind).kind
        tried += [(float(_costs(seen, start, sign, kind[None])[0]), start, sign, kind)
                  for sign in Sign]
    tried.sort(key=lambda each: each[0])
    best = {(start.family, start.tau): (start, sign, kind)
            for _, start, sign, kind in reversed(tried)}
    chosen = [(start, sign, kind) for _, start, sign, kind in tried[:CANDIDATES]]
    chosen += [each for each in best.values()
               if not any(each[:2] == other[:2] for other in chosen)]
    fits = [_finished(seen, *each) for each in chosen]
    fits.append(_as_spring(seen, min(fits, key=lambda each: each.cost)))
    return _with_other_signs(seen, fits)


def search(pages: Sequence[Page], rounding: Rounding, period: float) -> list[Fit]:
    """Return the best fits of many starts under all signs, best first; this takes a minute."""
    seen = windows(pages, rounding, period)
    tried = []
    for start in INITIAL_GUESSES:
        bounds = OVERSHOOTS if start.family is Family.SPRING else (start.bound.mean,)
        for bound, factor, braking, sign in product(bounds, TAU_FACTORS, BRAKINGS, Sign):
            kind = _first(start)
            kind[[Kind.BOUND, Kind.BRAKING]] = bound, braking
            kind[list(TAUS)] += np.log(factor)
            tried.append(_finished(seen, start, sign, kind, FEW))
    tried.sort(key=lambda each: each.cost)
    return _with_other_signs(seen, [
        _finished(seen, each.start, each.sign, each.kind) for each in tried[:CANDIDATES]])


def _with_other_signs(seen: Windows, fits: list[Fit]) -> list[Fit]:
    """Return fits, and what becomes of the best one under other signs; best first."""
    winner = min(fits, key=lambda each: each.cost)
    others = [_finished(seen, winner.start, sign, winner.kind, FEW)
              for sign in Sign if sign is not winner.sign]
    return sorted([*fits, *others], key=lambda each: each.cost)


def _first(start: InitialGuess) -> Array:
    kind = np.zeros(len(Kind))
    for each, belief in COMMON.items():
        kind[each] = belief.mean
    kind[Kind.BOUND] = start.bound.mean
    kind[list(TAUS)] = np.log(start.tau)
    return kind


def _as_spring(seen: Windows, found: Fit) -> Fit:
    """Return the best spring near wheels that were found."""
    start, kind = INITIAL_GUESSES[-1], found.kind.copy()
    kind[Kind.BOUND] = start.bound.mean
    kind[list(TAUS)] += np.log(SPRINGY)
    return _finished(seen, start, found.sign, kind)


def _finished(seen: Windows, start: InitialGuess, sign: Sign, kind: Array,
              rounds: int = ROUNDS) -> Fit:
    """Return the best fit near a kind, in so many rounds at most."""
    before = np.inf
    for _ in range(rounds):
        kind, cost, inverse = _improved(seen, start, sign, kind)
        if before - cost < ENOUGH:
            break
        before = cost
    return Fit(start, sign, kind, cost, inverse, len(seen.move))


def _beliefs(start: InitialGuess) -> list[Belief]:
    return [start.bound if each is Kind.BOUND else COMMON[each] for each in Kind]


def _predicted(seen: Windows, start: InitialGuess, sign: Sign, kinds: Array) -> Array:
    """Return what readings should be; axes (kind, reading, unit)."""
    counts = simulate(start.family, kinds, (sign,), seen.asked, seen.period)[0]
    return seen.predicted(counts, kinds[:, Kind.SEPARATION])


def _prior(start: InitialGuess, kind: Array) -> tuple[Array, Array]:
    """Return gradient and curvature of what is believed before; of half the squares."""
    beliefs = _beliefs(start)
    weights = np.diag([each.spread ** -2 for each in beliefs])
    gradient = weights @ (kind - np.array([each.mean for each in beliefs]))
    for one, other in zip(TAUS, TAUS[1:]):
        row = np.zeros(len(Kind))
        row[one], row[other] = 1 / ALIKE, -1 / ALIKE
        weights = weights + np.outer(row, row)
        gradient = gradient + row * (row @ kind)
    return gradient, weights


def _penalty(start: InitialGuess, kind: Array) -> float:
    beliefs = _beliefs(start)
    off = (kind - np.array([each.mean for each in beliefs])) / [each.spread for each in beliefs]
    steps = np.diff(kind[list(TAUS)]) / ALIKE
    return float(off @ off + steps @ steps) / 2


def _beyond(seen: Windows, predicted: Array) -> tuple[Array, Array]:
    """Return how far below and above its interval each reading is predicted, by softness."""
    return (seen.low - predicted) / SOFT, (predicted - seen.high) / SOFT


def _costs(seen: Windows, start: InitialGuess, sign: Sign, kinds: Array) -> Array:
    """Return how badly each kind explains the readings: nothing within its interval."""
    below, above = _beyond(seen, _predicted(seen, start, sign, kinds))
    readings = (np.logaddexp(0, below) + np.logaddexp(0, above)).sum(axis=(1, 2))
    costs: Array = readings + np.array([_penalty(start, kind) for kind in kinds])
    return costs


def _improved(seen: Windows, start: InitialGuess, sign: Sign, kind: Array,
              ) -> tuple[Array, float, Array]:
    """Return a better kind, its cost, and the inverse of the curvature (Gauss-Newton)."""
    beliefs = _beliefs(start)
    steps = np.array([each.step for each in beliefs])
    predicted = _predicted(seen, start, sign, np.vstack([kind, kind + np.diag(steps)]))
    here = predicted[0]
    slopes = (predicted[1:] - here) / steps[:, None, None]
    below, above = (1 / (1 + np.exp(-np.clip(far, -50, 50))) for far in _beyond(seen, here))
    force = (above - below) / SOFT
    off = np.abs(here - (seen.low + seen.high) / 2)
    stiffness = np.maximum((below * (1 - below) + above * (1 - above)) / SOFT ** 2,
                           np.abs(force) / np.maximum(off, SOFT))
    gradient, curvature = _prior(start, kind)
    gradient = gradient + np.einsum('kru,ru->k', slopes, force)
    curvature = curvature + np.einsum('kru,ru,lru->kl', slopes, stiffness, slopes)
    direction = np.linalg.solve(curvature, -gradient)
    low, high = np.array([(each.low, each.high) for each in beliefs]).T
    tried = np.clip(kind + LENGTHS[:, None] * direction, low, high)
    costs = _costs(seen, start, sign, tried)
    best = int(costs.argmin())
    return tried[best], float(costs[best]), np.linalg.inv(curvature)
