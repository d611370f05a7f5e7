# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""From all that was written down to what is known of the robot."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import exp, hypot, pi

import numpy as np

from ...odometry import Family, Knowledge, Known, Rounding, SignSource
from ...odometry import states as s
from ...odometry.knowledge import ANY, numbers, STATES
from ...odometry.lags import lag_parts
from .fit import Fit, fit, search
from .fractions import roundings
from .moves import Reads
from .notebook import Page
from .trial_wheels import Array, Kind, KNOTS

ROUGH = {s.LAG: 0.005, s.SLOW_LAG: 0.05, s.FAST_LAG: 0.05, s.DEAD_TIME: 0.004, s.RAMP: 0.02,
         s.BRAKING: 0.03, s.GAIN_RIGHT: 0.001, s.GAIN_LEFT: 0.001, s.SEPARATION: 0.001}
"""What no fit knows of wheels: least standard deviations."""
SMALL_STEP = 1e-4
"""Step for derivatives."""
FAST_MOVE = 0.3
"""m/s, the speed of the fastest moves."""
UNLIKELY = 0.01
"""Probability of a rounding below which it is not tried."""


@dataclass(frozen=True)
class Conclusion:
    """What is known of the wheels and their counts."""

    fits: Sequence[Fit]
    """Best first."""
    knowledge: Knowledge

    @property
    def wheels(self) -> Fit:
        """The wheels that explain the readings best."""
        return self.fits[0]

    @property
    def is_ramp(self) -> bool:
        """Whether a bound of the acceleration matters more than a time constant."""
        wheels = self.wheels
        return (wheels.start.family is Family.LAG
                and wheels.kind[Kind.BOUND] * FAST_MOVE / 2
                > time_constant(wheels.kind, FAST_MOVE))

    @property
    def family_probability(self) -> float:
        """How likely the family of the response is the right one."""
        return self.knowledge.response[self.wheels.start.family]


def conclude(pages: Sequence[Page], band: tuple[float, float], period: Known) -> Conclusion:
    """Work out what the moves say; this takes seconds, and a minute where wheels are unusual."""
    before = roundings(pages, period.value)
    telling = [page for page in pages if page.move.reads is not Reads.EVERY]
    tried = {each: fit(telling, each, period.value)
             for each, probability in before.items() if probability > UNLIKELY}
    rounding = _weighed(before, tried)
    likeliest = max(rounding, key=rounding.__getitem__)
    fits = tried[likeliest]
    if fits[0].is_bad:
        fits = sorted([*fits, *search(telling, likeliest, period.value)],
                      key=lambda each: each.cost)
    signs = {source: _probability(fits, partial(_has_sign, source)) for source in SignSource}
    response = {family: _probability(fits, partial(_is_of, family)) for family in Family}
    return Conclusion(fits, _knowledge(fits[0], {
        'rounding': rounding, 'encoder_sign': signs, 'response': response, 'dead_band': band,
        'frame_period': period, 'readings': len(telling)}))


def _weighed(rounding: Mapping[Rounding, float], tried: Mapping[Rounding, Sequence[Fit]],
             ) -> Mapping[Rounding, float]:
    """Return the probabilities of roundings, by how well wheels explain readings under each."""
    least = min(fits[0].cost_of_reading for fits in tried.values())
    readings = min(fits[0].readings for fits in tried.values())
    weights = {each: rounding[each] * exp(-min(
        readings * (fits[0].cost_of_reading - least) / fits[0].excess, 700))
        for each, fits in tried.items()}
    return {each: weights.get(each, 0.0) / sum(weights.values()) for each in rounding}


def time_constant(kind: Array, speed: float) -> float:
    """Return the time constant at a speed, s."""
    taus = kind[Kind.SLOW:Kind.QUICK + 1]
    return float(np.exp(np.interp(np.log(speed), KNOTS, taus)))


def _has_sign(source: SignSource, found: Fit) -> bool:
    return found.sign.value == source.value


def _is_of(family: Family, found: Fit) -> bool:
    return found.start.family is family


def _probability(fits: Sequence[Fit], wanted: Callable[[Fit], bool]) -> float:
    """Return the part of all likelihood that the best of the wanted fits has."""
    best = {True: np.inf, False: np.inf}
    for each in fits:
        best[wanted(each)] = min(best[wanted(each)], each.cost)
    if not np.isfinite(best[True]):
        return 0.0
    excess = fits[0].excess
    return 1 / (1 + exp(min((best[True] - best[False]) / excess, 700)))


def _states(kind: Array, family: Family) -> Array:
    """Return the numbers of a kind as the odometry's states have them."""
    found = np.zeros(s.SIZE)
    found[[s.GAIN_RIGHT, s.GAIN_LEFT]] = kind[[Kind.RIGHT_GAIN, Kind.LEFT_GAIN]]
    found[[s.OFFSET_RIGHT, s.OFFSET_LEFT]] = kind[[Kind.RIGHT_OFFSET, Kind.LEFT_OFFSET]]
    found[s.DEAD_TIME], found[s.RAMP] = kind[Kind.DEAD_TIME], kind[Kind.BOUND]
    late = 1.0
    if family is Family.SPRING:
        found[s.DAMPING] = -kind[Kind.BOUND] / hypot(pi, kind[Kind.BOUND])
        late = 2 * found[s.DAMPING]  # in units of one over the natural frequency
    found[s.BRAKING], found[s.SEPARATION] = kind[Kind.BRAKING], kind[Kind.SEPARATION]
    slow, middle, quick = (time_constant(kind, speed) for speed in np.exp(KNOTS))
    _, missing = lag_parts(float(np.exp(KNOTS[-1])))
    found[s.LAG], found[s.SLOW_LAG] = late * middle, slow / middle - 1
    found[s.FAST_LAG] = (1 - quick / middle) / missing
    return found


def _knowledge(wheels: Fit, rest: Mapping[str, object]) -> Knowledge:
    """Return what the odometry can start with."""
    kind, family = wheels.kind, wheels.start.family
    mean = _states(kind, family)
    slopes = np.column_stack([(_states(kind + step, family) - mean) / SMALL_STEP
                              for step in SMALL_STEP * np.eye(len(Kind))])
    p = wheels.excess * slopes @ wheels.covariance @ slopes.T
    for state, spread in ROUGH.items():
        p[state, state] += spread ** 2
    priors = ANY | (s.SPRING if family is Family.SPRING else {})
    for state in STATES:
        mean[state] = min(max(mean[state], priors[state].low), priors[state].high)
    return numbers(mean[STATES], p[np.ix_(STATES, STATES)], rest)
