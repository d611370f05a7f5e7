# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How wheels follow their requests: one model with five numbers, and its derivatives.

A wheel is pulled to its request, a dead time d later, as by a spring that gives way: an error e
fades with the time constant T, but no faster than the acceleration a allows:

    de/dt = -a tanh(e / (a T))

T holds at 0.1 m/s and shrinks with the speed's power p; a wheel that slows down is b times as
fast. Both wheels are alike; gains come later (`filters`). SI units.
"""

from math import exp, hypot

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Speeds = tuple[float, float]
"""m/s of the right and the left wheel."""

STEP, COPIES = 0.05, 5
"""By how much T, p, a, b (or their logarithms) of a copy are larger, for derivatives (tried: 0.02
to 0.1 are alike); the wheels as believed, and a copy for each."""
REFERENCE, SLOWEST, FASTEST = 0.1, 0.05, 0.5
"""m/s for which T is given; m/s between which T goes with the speed (evidence: stops of C1)."""
LEAST_LAG = 0.008
"""Seconds: half a slot; a wheel cannot be seen to be faster."""
ARRIVED = 2e-5
"""m/s: in a minute 1 mm, or half a degree; a wheel so near to its request has reached it."""
NEAR = 0.02
"""m/s; a wheel so near to its request runs steadily (tried)."""
SIGNS = 3
"""Sources of an encoder's sign beside the motion itself: see `estimate.SignSource`."""


class Wheels:
    """Arrays begin with the copies and end with the right and the left wheel."""

    def __init__(self, numbers: Array) -> None:
        """Begin at rest with ln T, p, ln a, ln b and d."""
        self.speed = np.zeros((COPIES, 2))
        self.way, self.wrong = np.zeros((COPIES, 2)), np.zeros((SIGNS, COPIES, 2))
        """Metres rolled since the last reading, and those of them counted with a wrong sign."""
        self.path, self.varied = np.zeros(2), np.zeros(2)
        """Metres rolled and changes of speed, m/s, since the last reading, without their signs."""
        self.moving, self._settled = False, True
        """Whether a wheel turns, and whether all run as requested."""
        self.goal = np.zeros(2)
        """m/s that the wheels are pulled to."""
        self.request: Speeds = (0.0, 0.0)
        """What was asked for last."""
        self._delayed: list[tuple[float, Speeds]] = []
        """Requests that have no effect yet, with the seconds until they have."""
        self._begun_at = np.zeros(2)
        """m/s at the last reading."""
        self._fastest = np.full(2, SLOWEST)
        """m/s that T goes with."""
        self._sign = np.ones((SIGNS, 1, 2))
        self._against = np.zeros((SIGNS, 2))
        """m/s against the sign, at the last reading, and by requests that have turned it."""
        self.numbers = numbers
        self.set_numbers(numbers)

    def set_numbers(self, numbers: Array) -> None:
        """Go on with other numbers; the speeds go with them."""
        if self.moving:
            learned = (numbers - self.numbers)[:-1]
            self.speed += np.clip(learned @ (self.speed[1:] - self.speed[0]) / STEP, -0.3, 0.3)
            self._settled &= not learned.any()
        self.numbers = numbers
        n = np.repeat(numbers[None, :-1], COPIES, axis=0)
        n[range(1, COPIES), range(COPIES - 1)] += STEP
        self._t, self._p, self._a, self._b = (n[:, i:i + 1] for i in range(COPIES - 1))
        self._t, self._a, self._b = np.exp(self._t), np.exp(self._a), np.exp(self._b)
        self._work_out_lag()

    def _aim(self, request: Speeds) -> None:
        """Be pulled to other speeds from now on; the faster of both ends decides how late."""
        self.goal = np.array(request)
        self._fastest = np.clip(
            np.maximum(np.abs(self.goal), np.abs(self.speed[0])), SLOWEST, FASTEST)
        self._work_out_lag()

    def _work_out_lag(self) -> None:
        self._lag = np.maximum(self._t * (REFERENCE / self._fastest) ** self._p, LEAST_LAG)
        self._most = self._lag * self._a

    def roll(self, dt: float, request: Speeds, *, lifted: bool = False) -> Speeds:
        """Let a frame pass; return the metres by which the wheels, as believed, have rolled."""
        if request != self.request:
            self.request, self._settled = request, False
            self._delayed.append((float(self.numbers[-1]), request))
            self._against[1:] -= self._speed_against()[1:]
            sign = np.sign(request)
            self._sign[1] = np.where(sign == 0, self._sign[1], sign)
            self._sign[2] = np.where(sign < 0, -1.0, 1.0)
            self._against[1:] += self._speed_against()[1:]
        if self._settled:
            way = self.speed * dt
        else:
            before = self.speed[0]
            way = self._follow_all(dt)
            self.varied += np.abs(self.speed[0] - before)
            self._settled = not self._delayed and bool(
                np.abs(self.speed - self.goal).max() < ARRIVED)
            self.moving = bool(self.speed.any())
        right, left = way[0].tolist()
        if self.moving and not lifted:
            self.way += way
            backwards = self._sign * way < 0
            if backwards.any():
                self.wrong += np.where(backwards, way, 0.0)
            self.path += np.abs(way[0])
        return right, left

    def _follow_all(self, dt: float) -> Array:
        """Follow each request from the moment at which it takes effect; return the ways."""
        way, left = np.zeros((COPIES, 2)), dt
        while left > 1e-9:
            while self._delayed and self._delayed[0][0] <= 1e-9:
                _, request = self._delayed.pop(0)
                self._aim(request)
                sign = np.sign(request)
                self._sign[0] = np.where(sign == 0, self._sign[0], sign)
            step = min(left, self._delayed[0][0]) if self._delayed else left
            self._delayed = [(delay - step, request) for delay, request in self._delayed]
            way += self._follow(step)
            left -= step
        return way

    def _follow(self, dt: float) -> Array:
        """Be pulled to one goal: the closed form of the equation at the top."""
        error = self.speed - self.goal
        lag = self._lag / np.where(error * self.speed > 0, self._b, 1.0)
        inner = np.arcsinh(np.sinh(np.clip(error / self._most, -300.0, 300.0))
                           * np.exp(-dt / lag))
        after = inner * self._most
        faded = np.abs(after) * 20 < np.abs(error)  # then a mean of both ends is too much
        way: Array = self.goal * dt + np.where(
            faded, (error - after) * lag, (error + after) * dt / 2)
        self.speed = self.goal + after
        if not self.goal.any():
            self.speed[np.abs(self.speed) < ARRIVED] = 0.0
        return way

    @property
    def steady(self) -> bool:
        """Whether the wheels run as requested, nearly."""
        return not self._delayed and bool(np.abs(self.speed[0] - self.goal).max() < NEAR)

    def begin(self) -> None:
        """Measure ways from now on."""
        self.way[:] = self.wrong[:] = 0.0
        self.path[:] = self.varied[:] = 0.0
        self._begun_at, self._against = self.speed[0].copy(), self._speed_against()

    def _speed_against(self) -> Array:
        """Return the speeds of wheels that run against the sign of their encoders."""
        return np.where(self._sign[:, 0] * self.speed[0] < 0, self.speed[0], 0.0)

    def slopes(self) -> tuple[Array, Array]:
        """Return the derivatives of ways and wrong ways by the five numbers."""
        ways, wrong = np.empty((COPIES, 2)), np.zeros((SIGNS + 1, COPIES, 2))
        ways[:-1] = (self.way[1:] - self.way[0]) / STEP
        ways[-1] = self._begun_at - self.speed[0]  # all happens later
        wrong[:SIGNS, :-1] = (self.wrong[:, 1:] - self.wrong[:, :1]) / STEP
        wrong[:SIGNS, -1] = self._against - self._speed_against()
        return ways, wrong

    def speed_slopes(self) -> Array:
        """Return the derivatives of the speeds by the five numbers."""
        slopes = np.zeros((COPIES, 2))
        slopes[:-1] = (self.speed[1:] - self.speed[0]) / STEP
        return slopes


def late(numbers: Array, speed: float) -> float:
    """
    Return by how many seconds a wheel is late that starts to run at a speed, m/s.

    The error fades within T (v / (a T) is small), or by a ramp (it is large); within 2 % between.
    """
    lag, power, acceleration, _, dead = (float(each) for each in numbers)
    return dead + hypot(exp(lag) * (REFERENCE / speed) ** power, speed / (2 * exp(acceleration)))
