# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What was learned of a robot, apart from where it is.

`learned` takes it from the tracks. `known` makes the tracks of an odometry that starts with it:
one of each kind with the known numbers, and all that an unknown robot may be with little weight,
so that knowledge of another robot is unlearned.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import product
from math import exp, log, pi
from typing import Any, NamedTuple

import numpy as np

from ..robot import Rounding, SLOT
from . import states as s
from .assumptions import Assumptions, LIKELY_SIGN, SIGNS
from .dead_band import DeadBand
from .encoder_signs import LAST, NONE, Signs, UPWARD
from .lags import lag_parts
from .request_history import Array


class SignSource(Enum):
    """Where an encoder takes its sign from."""

    MOTION = 'motion'
    """The wheel's own motion."""
    DRIVE = 'drive'
    """The last request that was not zero, once its dead time is over."""
    LAST_REQUEST = 'last_request'
    """The last request that was not zero, at once."""
    LATE_REQUEST = 'late_request'
    """The request once its dead time is over; zero counts as forwards."""
    REQUEST = 'request'
    """The request at once; zero counts as forwards."""


class Family(Enum):
    """How a wheel follows a step of its request."""

    LAG = 'lag'
    """The rest of the way shrinks by a part, or at a bounded rate."""
    SPRING = 'spring'
    """It overshoots."""


class Known(NamedTuple):
    """A number, and the standard deviation of what is believed of it."""

    value: float
    deviation: float


SOURCES = {(NONE, False): SignSource.MOTION, (LAST, True): SignSource.DRIVE,
           (LAST, False): SignSource.LAST_REQUEST, (UPWARD, True): SignSource.LATE_REQUEST,
           (UPWARD, False): SignSource.REQUEST}
"""What the tracks call these sources."""
PERIOD = Known(SLOT, 3e-4)
"""Length of a slot of a robot that nobody knows: 15 and 15.625 ms were seen."""
CERTAIN, FINE, PROMPT = 0.99, 0.01, 0.03
"""When a robot counts as known: least probability of its rounding and of its source of signs;
largest standard deviation of a gain, and of a wheel's delay, s."""
QUICK = 0.2
"""m/s of a quick drive, at which that delay is looked at."""
STALE, LEAST = 1.5, 1e-4
"""Factor by which what was known is less sure the next day, and its least deviation."""
UNLIKELY = 5e-5
"""Least weight of a kind of track that was not believed in: too little to be part of the
estimate."""
UNKNOWN = 2e-3
"""Weight of all tracks together that know nothing."""
LEAST_EIGENVALUE = 1e-6
"""Of a matrix of correlations that were rounded."""


@dataclass(frozen=True, kw_only=True)
class Knowledge:
    """A robot as the odometry knows it; SI units."""

    rounding: Mapping[Rounding, float]
    """Probability of each."""
    encoder_sign: Mapping[SignSource, float]
    """Probability of each."""
    response: Mapping[Family, float]
    """Probability of each."""
    right_gain: Known
    """Speed of the right wheel over the speed asked, at high speeds."""
    left_gain: Known
    right_offset: Known
    """m/s that the right wheel adds to any speed."""
    left_offset: Known
    time_constant: Known
    """Seconds by which a wheel comes late to a new speed, at 76 mm/s: a lag has done 63 % by then.
    """
    slow_part: Known
    """Part of the time constant that comes on top at 50 mm/s and below."""
    fast_part: Known
    """Part of the time constant that is missing at 500 mm/s."""
    dead_time: Known
    """Seconds until a wheel begins to follow a request."""
    inverse_acceleration: Known | None = None
    """s²/m; 0: nothing bounds a wheel's acceleration but its time constant. None: a spring."""
    damping: Known | None = None
    """Damping ratio of a spring, 1: it just does not overshoot. None: a lag."""
    braking: Known
    """How many times as fast a wheel brakes as it speeds up."""
    separation_factor: Known
    """Distance of the wheels by which the robot works out angles, over 258 mm."""
    correlations: tuple[tuple[float, ...], ...]
    """Of the numbers above, in their order: the lower triangle, without the diagonal."""
    dead_band: tuple[float, float]
    """Fastest request known not to move a wheel, slowest known to, m/s."""
    frame_period: Known = PERIOD
    """Seconds between two frames."""
    readings: int = 0
    """Readings of distance and angle since the start from which this was learned."""

    @property
    def likeliest(self) -> tuple[Rounding, SignSource]:
        """The rounding and the source of signs that are believed in most."""
        return (max(self.rounding, key=self.rounding.__getitem__),
                max(self.encoder_sign, key=self.encoder_sign.__getitem__))

    @property
    def family(self) -> Family:
        """The kind of response that is believed in most; all numbers belong to it."""
        return max(self.response, key=self.response.__getitem__)

    @property
    def numbers(self) -> 'dict[str, Number]':
        """The numbers that such wheels have."""
        return NUMBERS[self.family]

    @property
    def overshoot(self) -> float:
        """By which part of a step a wheel overshoots."""
        if self.damping is None:
            return 0.0
        return exp(-pi * self.damping.value / (1 - self.damping.value ** 2) ** 0.5)

    @property
    def certain(self) -> bool:
        """Whether the robot is known as well as a minute of mixed driving can teach."""
        rounding, sign = self.likeliest
        return (self.rounding[rounding] > CERTAIN and self.encoder_sign[sign] > CERTAIN
                and max(self.right_gain.deviation, self.left_gain.deviation) < FINE
                and self.delay(QUICK).deviation < PROMPT)

    def delay(self, speed: float) -> Known:
        """Return by how many seconds a wheel is late that starts to run at a speed, m/s."""
        slow, fast = lag_parts(speed)
        lag, part = self.time_constant.value, (
            1 + slow * self.slow_part.value - fast * self.fast_part.value)
        rates = {'time_constant': part, 'slow_part': lag * slow, 'fast_part': -lag * fast,
                 'dead_time': 1.0, 'inverse_acceleration': speed / 2}
        row = np.array([rates.get(name, 0.0) for name in self.numbers])
        value = lag * part + self.dead_time.value
        if self.inverse_acceleration is not None:
            value += self.inverse_acceleration.value * speed / 2
        return Known(value, float(row @ _covariance(self) @ row) ** 0.5)


class Number(NamedTuple):
    """A number of `Knowledge`: the state that holds it, and how one becomes the other."""

    state: int
    of_state: Callable[[float], float]
    to_state: Callable[[float], float]
    is_logarithm: bool = False
    of_spring: bool = False

    @property
    def range(self) -> tuple[float, float]:
        """The least and the greatest value."""
        prior = (s.SPRING if self.of_spring else ANY)[self.state]
        return self.of_state(prior.low), self.of_state(prior.high)


def _same(value: float) -> float:
    return value


ANY = s.COMMON | s.LAGS[0]
"""What a state may be."""
OF_LAG = {
    'right_gain': Number(s.GAIN_RIGHT, _same, _same),
    'left_gain': Number(s.GAIN_LEFT, _same, _same),
    'right_offset': Number(s.OFFSET_RIGHT, _same, _same),
    'left_offset': Number(s.OFFSET_LEFT, _same, _same),
    'time_constant': Number(s.LAG, _same, _same),
    'slow_part': Number(s.SLOW_LAG, _same, _same),
    'fast_part': Number(s.FAST_LAG, _same, _same),
    'dead_time': Number(s.DEAD_TIME, _same, _same),
    'inverse_acceleration': Number(s.RAMP, _same, _same),
    'braking': Number(s.BRAKING, exp, log, is_logarithm=True),
    'separation_factor': Number(s.SEPARATION, lambda x: 1 + x, lambda x: x - 1),
}
DAMPING = Number(s.DAMPING, _same, _same, of_spring=True)
OF_SPRING = {'damping' if number.state == DAMPING.state else name:
             DAMPING if number.state == DAMPING.state else number
             for name, number in OF_LAG.items()}
NUMBERS = {Family.LAG: OF_LAG, Family.SPRING: OF_SPRING}
"""The numbers that states hold, in one order; a damping takes the place of an acceleration."""
STATES = [number.state for number in OF_LAG.values()]


def learned(rows: Assumptions, band: DeadBand) -> Knowledge:
    """Return what the tracks know of the robot."""
    whole = rows.weights / rows.weights.sum()
    families = [Family.SPRING if spring else Family.LAG for spring in rows.springs]
    response = _summed(families, whole)
    likeliest = max(response, key=response.__getitem__)
    weights = whole * [family is likeliest for family in families]
    weights /= weights.sum()
    mean = weights @ rows.means[:, STATES]
    off = rows.means[:, STATES] - mean
    p = np.einsum('t,tij->ij', weights, rows.p[:, STATES][:, :, STATES])
    p = p + np.einsum('t,ti,tj->ij', weights, off, off)
    return numbers(mean, p, {
        'rounding': _summed(rows.roundings, whole),
        'encoder_sign': _sources(rows, whole),
        'response': response,
        'dead_band': (band.stands, band.moves), 'readings': rows.readings})


def numbers(mean: Array, p: Array, rest: Mapping[str, Any]) -> Knowledge:
    """Return knowledge of numbers with this mean and covariance, and the rest of it."""
    spread = np.sqrt(np.maximum(np.diag(p), 1e-16))
    r = np.clip(p / np.outer(spread, spread), -1.0, 1.0)
    found: dict[str, Any] = {}
    response: Mapping[Family, float] = rest['response']
    wanted = NUMBERS[max(response, key=response.__getitem__)]
    for (name, number), value, deviation in zip(wanted.items(), mean.tolist(), spread.tolist()):
        value = number.of_state(value)
        found[name] = Known(value, deviation * value if number.is_logarithm else deviation)
    return Knowledge(
        **found, **rest,
        correlations=tuple(tuple(r[i, :i].tolist()) for i in range(1, len(STATES))))


def _sources(rows: Assumptions, whole: Array) -> dict[SignSource, float]:
    """Return how likely each source of signs is; as likely as at first where none mattered yet."""
    if rows.open_signs:
        return {SOURCES[sign]: likely / sum(LIKELY_SIGN.values())
                for sign, likely in LIKELY_SIGN.items()}
    return _summed([SOURCES[int(kind), bool(late)] for kind, late in zip(*rows.signs)], whole)


def _summed(kinds: list[Any], weights: Array) -> dict[Any, float]:
    """Return the sum of the weights for each kind."""
    sums = dict.fromkeys(kinds, 0.0)
    for kind, weight in zip(kinds, weights.tolist()):
        sums[kind] += weight
    return sums


def known(knowledge: Knowledge) -> Assumptions:
    """Return tracks that know the robot, and others beside them."""
    kinds = list(product(Rounding, SIGNS))
    weights = np.array([
        max(knowledge.rounding.get(rounding, 0.0)
            * knowledge.encoder_sign.get(SOURCES[sign], 0.0), UNLIKELY)
        for rounding, sign in kinds])
    means, p = np.zeros(s.SIZE), np.zeros((s.SIZE, s.SIZE))
    for index, prior in ANY.items():
        means[index] = prior.mean
    for name, number in knowledge.numbers.items():
        means[number.state] = number.to_state(getattr(knowledge, name).value)
    p[np.ix_(STATES, STATES)] = STALE ** 2 * _covariance(knowledge)
    p[STATES, STATES] += LEAST ** 2
    signs = Signs(np.array([kind for _, (kind, _) in kinds]),
                  np.array([late for _, (_, late) in kinds]))
    springs = np.full(len(kinds), knowledge.family is Family.SPRING)
    rows = Assumptions([rounding for rounding, _ in kinds], signs, springs,
                       weights / weights.sum(), np.ones(len(kinds)),
                       np.tile(means, (len(kinds), 1)), np.tile(p, (len(kinds), 1, 1)),
                       np.zeros((len(kinds), 2)))
    rows.join(Assumptions.all(), UNKNOWN)
    rows.patient = True
    return rows


def _covariance(knowledge: Knowledge) -> Array:
    """Return the covariance of the states that hold the numbers."""
    r = np.eye(len(STATES))
    for i, row in enumerate(knowledge.correlations, 1):
        r[i, :i] = r[:i, i] = row
    values, vectors = np.linalg.eigh(r)
    r = (vectors * np.maximum(values, LEAST_EIGENVALUE)) @ vectors.T
    spread = np.array([
        deviation / value if number.is_logarithm else deviation
        for number, (value, deviation) in (
            (number, getattr(knowledge, name)) for name, number in knowledge.numbers.items())])
    covariance: Array = r * np.outer(spread, spread)
    return covariance
