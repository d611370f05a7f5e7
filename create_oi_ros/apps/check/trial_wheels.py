# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Wheels of many kinds, simulated for all moves of a check at once.

Two families of response: a lag, whose acceleration may be bounded (a bound alone is a ramp), and a
spring, which overshoots. A kind is a row of numbers in the order of `Kind`. Arrays have the axes
(kind, wheel, move), right first; SI units.
"""

from enum import Enum, IntEnum
from math import pi

import numpy as np
from numpy.typing import NDArray

from ...odometry import Family

Array = NDArray[np.float64]
Index = NDArray[np.intp]
KNOTS = np.log([0.05, 0.076, 0.3])
"""Logarithms of the speeds, m/s, at which a time constant is a number of its own; between them
its logarithm is linear in that of the speed."""
EDGE = 0.005
"""m/s below which an offset fades."""


class Kind(IntEnum):
    """The numbers that describe a kind of wheels."""

    RIGHT_GAIN = 0
    LEFT_GAIN = 1
    RIGHT_OFFSET = 2
    LEFT_OFFSET = 3
    DEAD_TIME = 4
    SLOW = 5
    """Logarithm of the time constant, s, at the first of KNOTS."""
    MIDDLE = 6
    """The same at the second."""
    QUICK = 7
    """The same at the third."""
    BOUND = 8
    """Lag: 1 / acceleration, s²/m. Spring: logarithm of the overshoot."""
    BRAKING = 9
    """Logarithm of how many times as fast a wheel brakes."""
    SEPARATION = 10
    """By which part the firmware takes the wheels to be wider apart than FIRMWARE_SEPARATION."""


class Sign(Enum):
    """Where an encoder takes its sign from; the values are those of `SignSource`."""

    MOTION = 'motion'
    DRIVE = 'drive'
    LAST_REQUEST = 'last_request'
    LATE_REQUEST = 'late_request'
    REQUEST = 'request'


def simulate(family: Family, kinds: Array, signs: tuple[Sign, ...], asked: Array,
             period: float) -> Array:
    """
    Return what encoders count: metres since the start, axes (sign, kind, wheel, move, frame).

    `asked` has the requests of each frame, axes (wheel, move, frame).
    """
    wheels = _Wheels(family, kinds, signs, asked, period)
    counts = np.zeros((len(signs), len(kinds), *asked.shape[:2], asked.shape[2] + 1))
    for frame in range(asked.shape[2]):
        wheels.step(frame)
        counts[..., frame + 1] = wheels.counted
    return counts


class _Wheels:
    """Wheels of some kinds on their way through all moves, a frame at a time."""

    def __init__(self, family: Family, kinds: Array, signs: tuple[Sign, ...], asked: Array,
                 period: float) -> None:
        self._family, self._signs = family, signs
        self._asked, self._period = asked, period
        column = kinds[:, :, None, None]
        self._gain = kinds[:, Kind.RIGHT_GAIN:Kind.LEFT_GAIN + 1, None]
        self._offset = kinds[:, Kind.RIGHT_OFFSET:Kind.LEFT_OFFSET + 1, None]
        dead = np.maximum(kinds[:, Kind.DEAD_TIME], 0.0) / period
        self._part = dead % 1
        before = int(dead.max()) + 1
        self._first = before - dead.astype(int)
        self._knots = column[:, Kind.SLOW:Kind.QUICK + 1]
        self._bound = column[:, Kind.BOUND]
        self._braking = np.exp(column[:, Kind.BRAKING])
        none = np.zeros((before, *asked.shape[:2]))
        self._requests = np.concatenate([none, asked.transpose(2, 0, 1)])
        """Of all frames, after some of standing still."""
        shape = (len(kinds), *asked.shape[:2])
        self.counted = np.zeros((len(signs), *shape))
        self._speed, self._rate = np.zeros(shape), np.zeros(shape)
        self._heard, self._late = np.zeros(shape), np.ones(shape)
        self._early = np.ones(asked.shape[:2])
        self._goal = np.zeros(shape)
        self._fastest = np.zeros(shape)
        self._find_lag()

    def step(self, frame: int) -> None:
        """
        Let a frame pass, in two pieces: a request is heard of a dead time after it came.

        Requests change between frames, so every kind hears of changes at one moment of a frame.
        """
        asked = self._asked[:, :, frame]
        self._early = np.where(asked != 0, np.sign(asked), self._early)
        for late, seconds in ((1, self._part), (0, 1 - self._part)):
            self._hear(self._requests[self._first + frame - late])
            self._h = seconds[:, None, None] * self._period
            travel = self._lag() if self._family is Family.LAG else self._spring()
            for index, sign in enumerate(self._signs):
                self.counted[index] += self._count(sign, travel, asked)

    def _hear(self, heard: Array) -> None:
        """Take the requests that wheels run by from now on."""
        changed = heard != self._heard
        if not changed.any():
            return
        self._heard = heard
        edge = np.minimum(np.maximum(heard / EDGE, -1.0), 1.0)
        self._goal = self._gain * heard + self._offset * edge
        fastest = np.maximum(np.abs(self._goal), np.abs(self._speed))
        self._fastest = np.where(changed, fastest, self._fastest)
        self._find_lag()
        self._late = np.where(heard != 0, np.sign(heard), self._late)

    def _find_lag(self) -> None:
        """Work out the time constants: of the fastest speed since the last change."""
        at = np.log(np.clip(self._fastest, *np.exp(KNOTS[[0, -1]])))
        slow, middle, quick = np.moveaxis(self._knots, 1, 0)
        low = (at - KNOTS[0]) / (KNOTS[1] - KNOTS[0])
        high = (at - KNOTS[1]) / (KNOTS[2] - KNOTS[1])
        self._tau = np.exp(np.where(
            low < 1, slow + (middle - slow) * low, middle + (quick - middle) * high))

    def _lag(self) -> Array:
        """Let wheels of the first family turn for a step; return their travel."""
        h, way = self._h, self._goal - self._speed
        haste = np.where(way * self._speed < 0, self._braking, 1.0)
        lag, ramp = self._tau / haste, np.maximum(self._bound, 1e-6) / haste
        far = np.abs(way)
        first = np.minimum(np.maximum(far * ramp - lag, 0.0), h)
        left = far - first / ramp
        kept = left * np.exp((first - h) / lag)
        short = (far + left) * first / 2 + (left - kept) * lag
        self._speed = self._goal - np.copysign(kept, way)
        travel: Array = self._goal * h - np.copysign(short, way)
        return travel

    def _spring(self) -> Array:
        h, x = self._h, self._speed - self._goal
        haste = np.where(x * self._speed > 0, self._braking, 1.0)
        omega = haste / self._tau
        damping = -self._bound / np.hypot(pi, self._bound)
        decay, swing = damping * omega, omega * np.sqrt(1 - damping ** 2)
        b = (self._rate + decay * x) / swing
        shrunk, cos, sin = np.exp(-decay * h), np.cos(swing * h), np.sin(swing * h)
        after = shrunk * (x * cos + b * sin)
        rate = -decay * after + shrunk * swing * (b * cos - x * sin)
        travel: Array = self._goal * h - (
            (rate - self._rate) + 2 * decay * (after - x)) / omega ** 2
        self._speed, self._rate = self._goal + after, rate
        return travel

    def _count(self, sign: Sign, travel: Array, asked: Array) -> Array:
        match sign:
            case Sign.MOTION:
                return travel
            case Sign.DRIVE:
                up = self._late
            case Sign.LAST_REQUEST:
                up = np.broadcast_to(self._early, travel.shape)
            case Sign.LATE_REQUEST:
                up = np.where(self._heard >= 0, 1.0, -1.0)
            case Sign.REQUEST:
                up = np.broadcast_to(np.where(asked >= 0, 1.0, -1.0), travel.shape)
        counted: Array = up * np.abs(travel)
        return counted
