"""
How both wheels follow what is asked, for many tracks and copies of them at once.

A wheel runs to its goal (gain times request, and an offset) after a dead time, by an exponential
lag whose acceleration is bounded: with a time constant T and an acceleration a, the way E to the
goal shrinks at the rate min(E / T, a). T near zero is a constant acceleration, 1/a = 0 a first
order lag. A change of request dv then costs dv (dead time + T + |dv| / 2a) of travel.

Arrays have the axes (wheel, track, copy), right first; copy 0 is the track's own belief, the others
are off by one standard deviation in one unknown each.
"""

import numpy as np

from . import states as s
from .requests import Array, KEPT, Requests, SPEEDS, UP

SLOW = 0.066
"""m/s at which the speed-dependent part of the lag counts in full; it falls as 1 / speed."""
SLOWEST = 0.05
EDGE = 0.005
"""m/s below which an offset fades."""
ARRIVED = 1e-7
"""m/s from its goal at which a wheel is there."""


class Wheels:
    """The copies of all tracks' wheels, and what they have done since the last reading."""

    def __init__(self, signs: Array, late: Array) -> None:
        """`signs` of tracks: 0 of the motion, 1 kept, 2 up at zero; `late`: after dead time."""
        self.signs, self.late = signs, late
        self.requests = Requests()
        self.free = False
        """Whether wheels keep their speed, whatever is asked."""
        self.slowest = 0.0
        """Requests below this may not move a wheel, m/s (`dead_band`)."""
        self._reference = np.zeros(2)

    def spread(self, means: Array, steps: Array) -> None:
        """Make copies from the tracks' means (track, state), off by these steps each."""
        tracks = len(means)
        copies = np.repeat(means[:, None, :], s.UNKNOWNS + 1, axis=1)
        which = np.arange(s.UNKNOWNS)
        copies[:, which + 1, which] += steps
        self.steps = steps
        self.gain = np.stack([copies[..., s.GAIN_RIGHT], copies[..., s.GAIN_LEFT]])
        self.moves = np.stack([copies[..., s.MOVES_RIGHT], copies[..., s.MOVES_LEFT]])
        self.offset = np.stack([copies[..., s.OFFSET_RIGHT], copies[..., s.OFFSET_LEFT]])
        self.lag = np.maximum(copies[..., s.LAG], 0.004)
        self.slow_lag = copies[..., s.SLOW_LAG]
        self.dead_time = np.maximum(copies[..., s.DEAD_TIME], 0.0)
        self.ramp = np.maximum(copies[..., s.RAMP], 1e-6)
        self.braking = np.exp(copies[..., s.BRAKING])
        self.speed = np.stack([copies[..., s.SPEED_RIGHT], copies[..., s.SPEED_LEFT]])
        self.track_width = SEPARATION * (1 + copies[..., s.SEPARATION])
        self.x, self.y, self.yaw = (copies[..., i].copy() for i in s.POSE)
        self.distance = np.zeros((tracks, s.UNKNOWNS + 1))
        self.angle = np.zeros((tracks, s.UNKNOWNS + 1))
        self.path = np.zeros((2, tracks))
        self.miscounted = np.zeros((2, tracks))
        self.settled = False
        self._before = self._sums()

    def _sums(self) -> tuple[Array, Array, Array]:
        ask = self.requests.sums
        return ask(SPEEDS, self.dead_time), ask(KEPT, self.dead_time), ask(UP, self.dead_time)

    def ask(self, right: float, left: float) -> Array:
        """Take other requests; return by how much they changed."""
        self.settled = False
        change = self.requests.ask(right, left)
        self._before = self._sums()
        return change

    def roll(self, h: float, scales: tuple[float, float]) -> None:
        """Let h seconds pass; scales are of true over counted travel and turn."""
        requests = self.requests
        recent = requests.age <= RECENT
        requests.step(h)
        if recent:
            now = self._sums()
            asked, kept, up = ((b - a) / h for a, b in zip(self._before, now))
            self._before = now
        else:
            rates = requests.rates[:, None, None]
            asked, kept, up = rates[:2], rates[2:4], rates[4:]
        travel = self.speed * h if self.free else self._follow(asked, h)
        counted = travel
        if not self.free and self.signs.any():
            counted = self._counted(travel, kept, up)
        self._move(travel, counted, scales)

    def _follow(self, asked: Array, h: float) -> Array:
        """Let wheels run towards their goals; return their travel."""
        if self.settled:
            return self.speed * h
        goal = self.gain * asked + self.offset * np.clip(asked / EDGE, -1.0, 1.0)
        goal = np.where(np.abs(asked) < self.slowest, goal * self.moves, goal)
        fast = np.maximum(np.abs(self.requests.speeds), self._reference * np.exp(-h / 0.3))
        self._reference = fast
        slow = np.minimum(SLOW / np.maximum(fast, SLOWEST), 1.4)[:, None, None]
        way = goal - self.speed
        haste = np.where(way * self.speed < 0, self.braking, 1.0)
        lag = np.maximum(self.lag + self.slow_lag * slow, 0.004) / haste
        ramp = self.ramp / haste
        far = np.abs(way)
        first = np.clip(far * ramp - lag, 0.0, h)
        left = far - first / ramp
        kept = np.exp((first - h) / lag)
        short = np.copysign((far + left) / 2 * first + left * lag * (1 - kept), way)
        self.speed = goal - np.copysign(left * kept, way)
        if self.requests.age > RECENT and float(far.max()) < ARRIVED:
            self.settled = True
        return goal * h - short

    def _counted(self, travel: Array, kept: Array, up: Array) -> Array:
        """Return what the encoders make of the travel, by each track's idea of their signs."""
        now = self.requests.rates[:, None, None]
        late = self.late[:, None]
        kept = np.where(late, kept, now[2:4])
        up = np.where(late, up, now[4:])
        signs = self.signs[:, None]
        sign = np.where(signs == 1, kept, up)
        return np.where(signs == 0, travel, sign * np.abs(travel))

    def _move(self, travel: Array, counted: Array, scales: tuple[float, float]) -> None:
        turn = (travel[0] - travel[1]) / self.track_width
        went = (travel[0] + travel[1]) * (scales[0] / 2)
        turn = turn * scales[1]
        middle = self.yaw + turn / 2
        self.x += went * np.cos(middle)
        self.y += went * np.sin(middle)
        self.yaw += turn
        self.distance += (counted[0] + counted[1]) / 2
        self.angle += (counted[0] - counted[1]) / self.track_width
        rolled, seen = np.abs(travel[:, :, 0]), counted[:, :, 0]
        self.path += rolled
        self.miscounted += np.abs(travel[:, :, 0] - seen)


SEPARATION = 0.258
RECENT = 0.35
