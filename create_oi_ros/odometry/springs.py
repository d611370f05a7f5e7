# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Wheels that swing beyond their goals, like a mass on a spring.

The way E to the goal obeys M E'' + T E' + E = 0, with M = (T / 2z)² and a damping z below 1. A
change of request dv costs dv T of travel in the end, as with a lag. Arrays are those of
`wheel_model`, but have only the tracks that are springs.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import states as s
from .request_history import Array

DAMPING = s.SPRING[s.DAMPING]
STILL = 0.01
"""m/s² below which a wheel at its goal stays there."""


class Swing(NamedTuple):
    """How ways and rates become those some time later, and what that costs."""

    stay: Array
    push: Array
    pull: Array
    keep: Array
    mass: Array
    lag: Array


class Springs:
    """The tracks whose wheels are springs."""

    def __init__(self, which: NDArray[np.bool_], rates: Array, copies: Array) -> None:
        """`rates`: of the speeds of all tracks' wheels, m/s², axes (track, wheel)."""
        self.which, = np.nonzero(which)
        self.some, self.only = bool(which.any()), bool(which.all())
        self.rate = np.repeat(rates[self.which].T[:, :, None], copies.shape[2], axis=2)
        self._damping = np.clip(copies[s.DAMPING, self.which], DAMPING.low, DAMPING.high)
        self._braking = np.exp(copies[s.BRAKING, self.which])

    @property
    def swinging(self) -> bool:
        """Whether a speed changes."""
        return bool(np.abs(self.rate).max() >= STILL)

    def prepare(self, lag: Array, h: float) -> None:
        """Get ready for steps of h seconds: with the lag at the present speeds, and braking."""
        self._easy, self._braked = self._swing(lag, h), self._swing(lag / self._braking, h)

    def roll(self, goal: Array, way: Array, speed: Array, h: float) -> tuple[Array, Array]:
        """Let h seconds pass; return the speeds and the travel."""
        braking = way * speed < 0
        swing = Swing(*np.where(braking, self._braked, self._easy))
        left = swing.stay * way - swing.push * self.rate
        rate = swing.pull * way + swing.keep * self.rate
        travel: Array = goal * h - swing.mass * (rate - self.rate) - swing.lag * (way - left)
        self.rate = rate
        return goal - left, travel

    def stop(self) -> Array:
        """Let the rates come to rest; return the travel that this costs."""
        travel: Array = self._easy.mass * self.rate
        self.rate = np.zeros_like(self.rate)
        return travel

    def _swing(self, lag: Array, h: float) -> Swing:
        omega = 2 * self._damping / lag
        decay, swing = self._damping * omega, np.sqrt(1 - self._damping ** 2) * omega
        shrunk = np.exp(-decay * h)
        cos, sin = shrunk * np.cos(swing * h), shrunk * np.sin(swing * h) / swing
        return Swing(cos + decay * sin, sin, omega ** 2 * sin, cos - decay * sin, omega ** -2, lag)
