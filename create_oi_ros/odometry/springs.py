# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Wheels that swing beyond their goals, like a mass on a spring.

The way E to the goal obeys M E'' + T E' + E = 0, with M = (T / 2z)² and a damping z below 1. A
change of request dv costs dv T of travel in the end, as with a lag. Arrays are those of
`wheel_model`, but have only the tracks that are springs.
"""

import numpy as np
from numpy.typing import NDArray

from . import states as s
from .request_history import Array

DAMPING = s.SPRING[s.DAMPING]
STILL = 0.01
"""m/s² below which a wheel at its goal stays there."""
SLIGHT = 0.004
"""m/s by which a speed may change while nobody minds when a wheel began or ceased to brake."""

STAY, PUSH, PULL, KEEP, MASS, LAG = range(6)
"""What a step multiplies ways, rates and their changes by."""


class Springs:
    """The tracks whose wheels are springs."""

    def __init__(self, which: NDArray[np.bool_], rates: Array, copies: Array) -> None:
        """`rates`: of the speeds of all tracks' wheels, m/s², axes (track, wheel)."""
        self.some, self.only = bool(which.any()), bool(which.all())
        if not self.some:
            return
        self.which, = np.nonzero(which)
        self.rate = np.repeat(rates[self.which].T[:, :, None], copies.shape[2], axis=2)
        self._damping = np.clip(copies[s.DAMPING, self.which], DAMPING.low, DAMPING.high)
        self._swing = np.sqrt(1 - self._damping ** 2)
        self._braking = np.exp(copies[s.BRAKING, self.which])

    @property
    def swinging(self) -> bool:
        """Whether a speed changes."""
        return bool(np.abs(self.rate).max() >= STILL)

    def prepare(self, lag: Array, h: float | Array) -> None:
        """Get ready for steps of h seconds with the lag at the present speeds."""
        self._lag, self._h = lag, h
        self._easy: Array | None = None
        self._braked: Array | None = None

    def roll(self, goal: Array, way: Array, speed: Array) -> tuple[Array, Array]:
        """Let the time of a step pass; return the speeds and the travel."""
        braking = way * speed < 0
        if not np.count_nonzero(braking):
            if self._easy is None:
                self._easy = self._factors(self._lag)
            factors = self._easy
        else:
            if self._easy is None or self._braked is None:
                both = self._factors(np.array([self._lag, self._lag / self._braking]))
                self._easy, self._braked = both[:, 0], both[:, 1]
            factors = np.where(braking, self._braked, self._easy)
        rate = self.rate
        after, self.rate, travel = _step(factors, goal, way, rate, self._h)
        other = braking != ((goal - after) * after < 0)
        if np.count_nonzero(other):
            other &= np.abs(after - speed) > SLIGHT
        if np.count_nonzero(other):  # these begin or cease to brake within the step
            # Positions in the flat arrays: take is several times faster than an index of all axes.
            at = np.flatnonzero(other)
            copy = at % self._damping.size
            h = self._h if isinstance(self._h, float) else self._h.take(copy)
            parted = _in_two(
                goal.take(at), speed.take(at), rate.take(at), after.take(at), braking.take(at), h,
                self._lag.take(at), self._braking.take(copy), self._damping.take(copy),
                self._swing.take(copy))
            for whole, part in zip((after, self.rate, travel), parted):
                whole.ravel()[at] = part
        return after, travel

    def stop(self) -> Array:
        """Let the rates come to rest; return the travel that this costs."""
        omega = 2 * self._damping / self._lag
        travel: Array = self.rate / (omega * omega)
        self.rate = np.zeros_like(self.rate)
        return travel

    def _factors(self, lag: Array) -> Array:
        return _factors(lag, self._damping, self._swing, self._h)


def _factors(lag: Array, damping: Array, swing: Array, h: float | Array) -> Array:
    """Return how ways and rates become those h seconds later, and what that costs."""
    made = np.empty((6, *lag.shape))
    made[LAG] = lag
    omega = 2 * damping / lag
    passed = omega * h
    shrunk, angle = np.exp(passed * -damping), passed * swing
    cos, sin = shrunk * np.cos(angle), shrunk * np.sin(angle) / swing
    np.divide(sin, omega, out=made[PUSH])
    np.multiply(sin, omega, out=made[PULL])
    sin *= damping
    np.add(cos, sin, out=made[STAY])
    np.subtract(cos, sin, out=made[KEEP])
    np.divide(1.0, omega * omega, out=made[MASS])
    return made


def _step(factors: Array, goal: Array, way: Array, rate: Array, h: float | Array,
          ) -> tuple[Array, Array, Array]:
    """Let h seconds pass; return the speeds, their rates and the travel."""
    left = factors[STAY] * way - factors[PUSH] * rate
    after: Array = factors[PULL] * way + factors[KEEP] * rate
    travel: Array = goal * h - factors[MASS] * (after - rate) - factors[LAG] * (way - left)
    return goal - left, after, travel


def _in_two(goal: Array, speed: Array, rate: Array, after: Array, braking: NDArray[np.bool_],
            h: float | Array, lag: Array, harder: Array, damping: Array, swing: Array,
            ) -> tuple[Array, Array, Array]:
    """Do the same where wheels begin or cease to brake, about when they pass zero or the goal."""
    passed = np.where((goal - speed) * (goal - after) < 0, goal, 0.0)
    first = h * np.clip((passed - speed) / (after - speed), 0.0, 1.0)
    softer, seconds = lag / harder, np.array([first, h - first])
    lags = np.array([np.where(braking, softer, lag), np.where(braking, lag, softer)])
    both = _factors(lags, damping, swing, seconds)
    speed, rate, there = _step(both[:, 0], goal, goal - speed, rate, seconds[0])
    speed, rate, then = _step(both[:, 1], goal, goal - speed, rate, seconds[1])
    return speed, rate, there + then
