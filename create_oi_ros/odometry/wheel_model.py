"""
How both wheels follow what is asked, for many tracks and copies of them at once.

A wheel runs to its goal (gain times request, and an offset) after a dead time, by an exponential
lag whose acceleration is bounded: with a time constant T and an acceleration a, the way E to the
goal shrinks at the rate min(E / T, a). T near zero is a constant acceleration, 1/a = 0 a first
order lag. A change of request dv then costs dv (dead time + T + |dv| / 2a) of travel.

Arrays have the axes (wheel, track, copy), right first; copy 0 is the track's own belief, the
others are off by one standard deviation in one unknown each.
"""

from typing import NamedTuple

import numpy as np

from ..robot import FIRMWARE_SEPARATION
from . import states as s
from .request_history import Array, RECENT, RequestHistory

SLOW, SLOWEST, SLOWER = 0.066, 0.05, 1.4
"""m/s at which the speed-dependent part of the lag counts once; it falls as 1 / speed, to that
speed, and counts so often at most."""
FADE = 0.3
"""Seconds in which a wheel that stops forgets how fast it was, as far as its lag goes."""
EDGE = 0.005
"""m/s below which an offset fades."""
ARRIVED = 3e-5
"""m/s from its goal at which a wheel is there."""
SHORTEST_LAG = 0.004
"""Seconds."""
NONE, LAST, UPWARD = range(3)
"""Where an encoder takes its sign from: the motion; the last speed asked that was not zero; the
speed asked, where zero counts as forwards."""


class Signs(NamedTuple):
    """How each track's encoders take their signs."""

    kinds: Array
    late: Array
    """Whether a request's sign waits for the dead time."""


class Wheels:
    """The copies of all tracks' wheels, and what they have done since the last reading."""

    def __init__(self, signs: Signs, slowest: float) -> None:
        self.signs = signs
        self.requests = RequestHistory()
        self.free = False
        """Whether wheels keep their speed, whatever is asked."""
        self._slowest = slowest
        """RequestHistory below this may not move a wheel, m/s (`dead_band`)."""
        self._fastest = np.zeros(2)

    def spread(self, means: Array, steps: Array, signs: Signs) -> None:
        """Make copies from the tracks' means (track, state), off by these steps each."""
        self.signs = signs
        copies = np.repeat(means[:, None, :], s.UNKNOWNS + 1, axis=1)
        which = np.arange(s.UNKNOWNS)
        copies[:, which + 1, which] += steps
        self.steps = steps
        copies = np.ascontiguousarray(copies.transpose(2, 0, 1))
        self._gain = copies[s.GAIN_RIGHT:s.GAIN_LEFT + 1]
        self._offset = copies[s.OFFSET_RIGHT:s.OFFSET_LEFT + 1]
        self._moves = copies[s.MOVES_RIGHT:s.MOVES_LEFT + 1]
        self._lag, self._slow_lag = copies[s.LAG], copies[s.SLOW_LAG]
        self._dead_time = np.maximum(copies[s.DEAD_TIME], 0.0)
        self._ramp = np.maximum(copies[s.RAMP], 1e-6)
        self._braking = np.exp(copies[s.BRAKING])
        self.speed = copies[s.SPEED_RIGHT:s.SPEED_LEFT + 1].copy()
        self.track_width = FIRMWARE_SEPARATION * (1 + copies[s.SEPARATION])
        self.poses = copies[s.X:s.YAW + 1].copy()
        self.counts = np.zeros((2,) + copies.shape[1:])
        """What the encoders made of it: metres forwards, and radians."""
        self.path = np.zeros((2, len(means)))
        """Metres that each wheel rolled, and that its encoder miscounted."""
        self.miscounted = np.zeros((2, len(means)))
        self.settled, self.farthest = False, np.inf
        """Whether all wheels run at their goals, and how far the farthest is from its own, m/s."""
        self._before = self._sums()
        self._goal: Array | None = None

    def ask(self, right: float, left: float) -> Array:
        """Take other requests; return by how much they changed."""
        self.settled = False
        self._goal = None
        change = self.requests.ask(right, left)
        self._before = self._sums()
        return change

    def roll(self, h: float, scales: tuple[float, float]) -> None:
        """Let h seconds pass; scales are of true over counted travel and turn."""
        requests = self.requests
        recent = requests.age <= RECENT
        requests.step(h)
        asked: Array = requests.speeds[:, None, None]
        if recent:
            now = self._sums()
            asked = (now[0] - self._before[0]) / h
        if self.free or self.settled:
            travel = self.speed * h
        else:
            travel = self._follow(asked, h, recent)
        counted = travel if self.free else self._counted(travel, h, now if recent else None)
        if recent:
            self._before = now
        self._move(travel, counted, scales)

    def _sums(self) -> Array:
        """Return sums over the requests as late as each copy's dead time."""
        return self.requests.sums(self._dead_time)

    def _follow(self, asked: Array, h: float, recent: bool) -> Array:
        """Let wheels run towards their goals; return their travel."""
        goal = self._goal
        if goal is None or recent:
            goal = self._gain * asked + self._offset * np.minimum(
                np.maximum(asked * (1 / EDGE), -1.0), 1.0)
            goal = np.where(np.abs(asked) < self._slowest, goal * self._moves, goal)
            self._goal = goal
        way = goal - self.speed
        haste = np.where(way * self.speed < 0, self._braking, 1.0)
        lag = np.maximum(self._lag + self._slow_lag * self._slowness(h), SHORTEST_LAG) / haste
        ramp = self._ramp / haste
        far = np.abs(way)
        first = np.minimum(np.maximum(far * ramp - lag, 0.0), h)
        left = far - first / ramp
        kept = left * np.exp((first - h) / lag)
        short = (far + left) * first / 2 + (left - kept) * lag
        self.speed = goal - np.copysign(kept, way)
        self.farthest = float(far.max())
        if not recent and self.farthest < ARRIVED:
            self.speed, self.settled = goal.copy(), True
        travel: Array = goal * h - np.copysign(short, way)
        return travel

    def _slowness(self, h: float) -> Array:
        """Return how often the speed-dependent part of the lag counts, for both wheels."""
        fastest = np.maximum(np.abs(self.requests.speeds), self._fastest * (1 - h / FADE))
        self._fastest = fastest
        slow: Array = np.minimum(SLOW / np.maximum(fastest, SLOWEST), SLOWER)
        return slow[:, None, None]

    def _counted(self, travel: Array, h: float, sums: Array | None) -> Array:
        """Return what the encoders make of the travel, by each track's idea of their signs."""
        kept, up = self.requests.signs
        if sums is None and (travel * kept).min() >= 0 and (travel * up).min() >= 0:
            return travel
        kinds, late = self.signs.kinds[:, None], self.signs.late[:, None]
        if sums is None:
            sign = np.where(kinds == LAST, kept, up)
        else:
            means = (sums[1:] - self._before[1:]) / h
            sign = np.where(kinds == LAST, np.where(late, means[0], kept),
                            np.where(late, means[1], up))
        return np.where(kinds == NONE, travel, sign * np.abs(travel))

    def _move(self, travel: Array, counted: Array, scales: tuple[float, float]) -> None:
        poses, counts = self.poses, self.counts
        turn = (travel[0] - travel[1]) / self.track_width
        counts[0] += (counted[0] + counted[1]) / 2
        if counted is travel:
            counts[1] += turn
        else:
            counts[1] += (counted[0] - counted[1]) / self.track_width
            self.miscounted += np.abs(travel[:, :, 0] - counted[:, :, 0])
        turn *= scales[1]
        went = (travel[0] + travel[1]) * (scales[0] / 2)
        middle = poses[2] + turn / 2
        poses[0] += went * np.cos(middle)
        poses[1] += went * np.sin(middle)
        poses[2] += turn
        self.path += np.abs(travel[:, :, 0])
