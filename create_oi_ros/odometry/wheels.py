# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The wheels of all hypotheses, simulated side by side with a gain of 1.

Each hypothesis is simulated six times: as it is believed, and with each of its five numbers a step
larger. The differences are the derivatives that its filters need. Arrays have the axes
hypothesis, copy, wheel (right and left).
"""

from collections.abc import Sequence

import numpy as np

from .hypotheses import Array, Hypothesis, NUMBERS, numbers_of, REFERENCE_SPEED, Response

HISTORY = 24
"""Changes of the request that are kept, for the dead time."""
STEP = np.array([0.05, 0.05, 0.05, 0.004, 0.02])
"""By how much the copies' numbers are larger."""
SLOWEST, FASTEST = 0.05, 0.5
"""m/s between which a time depends on the speed."""
WRONG_PART = 0.2
"""Part of a way counted with the wrong sign that is not sure."""
ARRIVED = 1e-5
"""m/s by which a wheel may miss its goal and counts as there."""
MOTION, DRIVE, LAST, REQUEST = range(4)
"""Sources of the encoders' signs, as in `SIGNS`."""


class Wheels:
    """Speeds of the wheels of all hypotheses, and what rolled since the last reading."""

    def __init__(self, rows: Sequence[Hypothesis]) -> None:
        """Begin at rest."""
        shape = (len(rows), NUMBERS + 1, 2)
        self.numbers = np.array([numbers_of(row) for row in rows])
        """What each hypothesis believes: ln(time), power, ln(braking), dead time, overshoot."""
        self._gains = np.ones((len(rows), 1, 2))
        """Speeds of the wheels over those that are simulated: a time may go with the speed."""
        self._response = np.array([row.response for row in rows])
        self._band = np.array([row.dead_band for row in rows])[:, None, None]
        self.speed = np.zeros(shape)
        self._rate = np.zeros(shape)
        """m/s² of springs."""
        self._goal = np.zeros(shape)
        self._brakes = np.zeros(shape, bool)
        self._top = np.zeros(shape)
        """The faster of the goal and the speed when the goal last changed."""
        self._asked_sum = np.zeros(shape)
        """Integral of the requests until a dead time ago, m."""
        self._sources = np.arange(4)
        self._sign = np.ones((4, *shape))
        """Sign of the counts by each source."""
        self._times = np.arange(-HISTORY, 0.0) + 1.0
        self._sums = np.zeros((2, HISTORY))
        """Integrals of both requests at the ends of the last requests, at `_times`."""
        self._request, self._unchanged, self._dt = (0.0, 0.0), 0.0, 0.0
        self._last_sign = np.ones(2)
        self._arrived, self._moving = True, False
        self._lifted = False
        self._steady = 0.0
        """Seconds of steady motion that are not in these sums yet."""
        self.true, self.path = np.zeros(shape), np.zeros(shape)
        """Metres that each wheel rolled since the last reading; the way, forth and back."""
        self.counted, self.unsure = np.zeros((4, *shape)), np.zeros((4, *shape))
        """What its encoder counted, by each source of signs; what of that is not sure."""
        self._derive()

    def _derive(self) -> None:
        """Work out the numbers of the copies."""
        copies = np.repeat(self.numbers[:, None], NUMBERS + 1, axis=1)
        copies[:, 1:] += np.diag(STEP)
        time, self._power, braking, dead, overshoot = np.moveaxis(copies[..., None], 2, 0)
        self._time, self._braking, self._dead = np.exp(time), np.exp(braking), dead[..., 0]
        log = np.log(np.clip(overshoot, 1e-3, 0.9))
        self._damping = -log / np.hypot(np.pi, log)
        self._springs, self._ramps = (
            np.flatnonzero(self._response == each) for each in (Response.SPRING, Response.RAMP))
        self._asked_sum = self._until(self._times[-1])
        self._longest = float(self._dead.max()) + 0.05
        self._dt = 0.0

    def keep(self, order: Array, sources: Array) -> None:
        """Go on with some of the hypotheses and sources of signs."""
        self.flush()
        self._sources = self._sources[sources]
        for name in ('numbers', '_gains', '_response', '_band', 'speed', '_rate', '_goal',
                     '_brakes', '_top', 'true', 'path'):
            setattr(self, name, getattr(self, name)[order])
        for name in ('_sign', 'counted', 'unsure'):
            setattr(self, name, getattr(self, name)[sources][:, order])
        self._derive()

    def move(self, numbers: Array, gains: Array) -> None:
        """Believe in other numbers and gains, when nothing has rolled since the last reading."""
        shift = (numbers - self.numbers)[:, None, :, None]
        for state in (self.speed, self._rate):
            slopes = (state[:, 1:] - state[:, :1]) / STEP[:, None]
            state += np.clip((slopes[:, None] * shift).sum(axis=2), -0.5, 0.5)
        self.numbers, self._gains = numbers, gains[:, None]
        self._derive()

    @property
    def steady(self) -> bool:
        """Whether all wheels run at their goals, which will not change before a request does."""
        return self._unchanged > self._longest and self._arrived

    @property
    def rests(self) -> bool:
        """Whether all wheels stand."""
        return self.steady and not self._moving

    def roll(self, dt: float, request: tuple[float, float], *, lifted: bool = False,
             ) -> Array | None:
        """
        Let time pass under requests, m/s; return the travel of each wheel, m.

        Wheels that are lifted count, but take the robot nowhere.

        None: all wheels run as they did in the frame before.
        """
        if lifted != self._lifted:
            self.flush()
            self._lifted = lifted
        if request != self._request:
            self.flush()
            self._request, self._unchanged = request, 0.0
            for array in (self._times, *self._sums):
                array[:-1] = array[1:]
        elif self.steady:
            self._steady += dt
            return None
        self.flush()
        self._times[-1] += dt
        self._sums[:, -1] += np.array(request) * dt
        before, self._asked_sum = self._asked_sum, self._until(self._times[-1])
        asked = (self._asked_sum - before) / dt
        asked[np.abs(asked) < ARRIVED] = 0.0
        below = np.abs(asked) < self._band
        goal = np.where(below, 0.0, asked)
        travel = self._follow(dt, goal)
        size = np.abs(travel)
        if not lifted:
            self.true += travel
        self.path += size
        self._count(travel, size, asked, below)
        self._arrived = bool((np.abs(self.speed - goal) < ARRIVED).all())
        self._moving = bool(self.speed.any())
        self._unchanged += dt
        return travel[:, 0]

    def flush(self) -> None:
        """Add up what rolled while the wheels ran steadily."""
        seconds, self._steady = self._steady, 0.0
        if not seconds:
            return
        way = np.array(self._request) * seconds
        self._times[-1] += seconds
        self._sums[:, -1] += way
        self._asked_sum += way
        if self._moving:
            travel = self.speed * seconds
            if not self._lifted:
                self.true += travel
            self.path += np.abs(travel)
            self.counted += np.abs(travel) * self._sign

    def begin_window(self) -> None:
        """Begin with no travel, after a reading."""
        self.flush()
        for array in (self.true, self.path, self.counted, self.unsure):
            array[:] = 0.0

    def _until(self, now: float) -> Array:
        """Return the integrals of both requests until a dead time ago, m."""
        return np.stack([np.interp(now - self._dead, self._times, each) for each in self._sums],
                        axis=-1)

    def _follow(self, dt: float, goal: Array) -> Array:
        """Let speeds follow their goals for a frame; return the travel."""
        speed = self.speed
        size, slower = np.abs(goal), np.abs(speed)
        brakes = (speed * goal < 0) | (size < slower - ARRIVED)
        changed = goal != self._goal
        if changed.any() or dt != self._dt or (brakes != self._brakes).any():
            self._top = np.where(changed, np.maximum(size, slower), self._top)
            self._prepare(dt, np.where(brakes, self._braking, 1.0))
            self._goal, self._brakes, self._dt = goal, brakes, dt
        off = speed - goal
        travel: Array = goal * dt + off * self._off_travels
        self.speed = goal + off * self._off_stays
        if len(r := self._springs):
            rate = self._rate[r]
            e, own = off[r], self._spring
            after = own[0] * e + own[1] * rate
            rate_after = own[2] * e + own[3] * rate
            travel[r] = goal[r] * dt - ((rate_after - rate) + own[4] * (after - e)) * own[5]
            self.speed[r], self._rate[r] = goal[r] + after, rate_after
        if len(r := self._ramps):
            change = np.clip(-off[r], -self._most_change, self._most_change)
            travel[r] = (speed[r] + change / 2) * dt
            self.speed[r] = speed[r] + change
        np.copyto(self.speed, 0.0, where=(np.abs(self.speed) < ARRIVED) & (size == 0))
        return travel

    def _prepare(self, dt: float, harder: Array) -> None:
        """Work out how speeds follow for frames of this length and the present braking."""
        top = np.clip(self._gains * self._top, SLOWEST, FASTEST)
        time = self._time * (REFERENCE_SPEED / top) ** self._power
        lag = time / harder
        self._off_stays = np.exp(-dt / lag)
        self._off_travels = lag * (1 - self._off_stays)
        if len(r := self._ramps):
            self._most_change = dt * harder[r] / self._time[r]
        if len(r := self._springs):
            omega, damping = harder[r] / time[r], self._damping[r]
            decay, swing = damping * omega, omega * np.sqrt(1 - damping ** 2)
            shrunk, cos, sin = np.exp(-decay * dt), np.cos(swing * dt), np.sin(swing * dt)
            self._spring = (
                shrunk * (cos + decay / swing * sin), shrunk / swing * sin,
                -shrunk * omega ** 2 / swing * sin, shrunk * (cos - decay / swing * sin),
                2 * decay, 1 / omega ** 2)

    def _count(self, travel: Array, size: Array, asked: Array, below: Array) -> None:
        """Add what the encoders make of this travel, by each source of their signs."""
        request = np.sign(self._request)
        self._last_sign = np.where(request == 0, self._last_sign, request)
        for source, sign in zip(self._sources, self._sign):
            if source == MOTION:
                sign[:] = np.sign(travel)
            elif source == DRIVE:
                sign[:] = np.where(asked == 0, sign, np.sign(asked))
            elif source == LAST:
                sign[:] = self._last_sign
            else:
                sign[:] = np.where(request < 0, -1.0, 1.0)
        self.counted += size * self._sign
        wrong = self._sign * travel < 0
        if wrong.any():
            self.unsure += np.where(wrong, WRONG_PART * size, 0.0)
        if below.any():  # a wheel coasts, and what drives it, who knows
            self.unsure[self._sources != MOTION] += np.where(below & (asked * travel < 0), size, 0)
