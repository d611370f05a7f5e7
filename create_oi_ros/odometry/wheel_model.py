# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How both wheels follow what is asked, for many tracks and copies of them at once.

A wheel runs to its goal (gain times request, and an offset) after a dead time, by an exponential
lag whose acceleration is bounded: with a time constant T and an acceleration a, the way E to the
goal shrinks at the rate min(E / T, a). T near zero is a constant acceleration, 1/a = 0 a first
order lag. A change of request dv then costs dv (dead time + T + |dv| / 2a) of travel. The wheels
of some tracks are springs instead (`springs`).

Arrays have the axes (wheel, track, copy), right first; copy 0 is the track's own belief, the
others are off by one standard deviation in one unknown each.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..robot import FIRMWARE_SEPARATION
from . import lags
from . import states as s
from .encoder_signs import Encoders, Signs
from .noise import MOVED
from .request_history import Array, RECENT, RequestHistory
from .springs import Springs

EDGE = 0.005
"""m/s below which an offset fades."""
ARRIVED = 3e-4
"""m/s from its goal at which a wheel is there."""
ALIKE = 0.015
"""By so much these parts may change before the lag is worked out again."""
LEAST_PART = 0.05
"""What is left of a lag at any speed."""
SHORTEST_LAG, LEAST_RAMP = 0.004, 1e-6
"""Seconds, and s²/m."""
SAME_SPEED = 1e-6
"""m/s by which a mean of the same requests may change."""
MOMENT = 1e-9
"""Seconds in which nothing is asked."""
OF_COPY = np.array([int(copy == s.DEAD_TIME + 1) for copy in range(s.UNKNOWNS + 1)])
"""Which of a track's two dead times a copy has."""
SAME = np.eye(s.SIZE)[None, MOVED]
"""How states that wheels move follow from all, where they did not."""


class Rows(Protocol):
    """What a wheel model takes from the tracks."""

    signs: Signs
    springs: NDArray[np.bool_]
    means: Array
    rates: Array


class WheelModel:
    """The copies of all tracks' wheels, and what they have done since the last reading."""

    def __init__(self, slowest: float) -> None:
        self.requests = RequestHistory()
        self.free = False
        """Whether wheels keep their speed, whatever is asked."""
        self.behind = 0.0
        """Seconds that have passed and that the copies have still to roll."""
        self._slowest = slowest
        """Requests below this may not move a wheel, m/s (`dead_band`)."""
        self._heard, self._fastest = [0.0, 0.0], (0.0, 0.0)
        """What the best track's wheels last heard; the faster of that and of their speeds then."""

    def spread(self, rows: Rows, steps: Array, *, arrived: bool = False) -> None:
        """
        Make copies from the tracks' means, off by these steps each.

        `arrived`: the wheels run at their goals, so each copy does, too, whatever it takes these
        for. A reading that corrects a gain corrects the speed with it, not what follows.
        """
        self._encoders, means = Encoders(rows.signs), rows.means
        copies = np.repeat(means.T[:s.DISTANCE, :, None], s.UNKNOWNS + 1, axis=2)
        np.einsum('utu->ut', copies[:s.UNKNOWNS, :, 1:])[:] += steps.T
        self.steps = steps
        self._take_unknowns(copies)
        self._note_moves(means)
        self.speed = copies[s.SPEED_RIGHT:s.SPEED_LEFT + 1]
        self.poses = copies[s.X:s.YAW + 1]
        self._rolled = np.zeros((2,) + copies.shape[1:])
        """Metres that the encoders counted, forwards."""
        self.path = np.zeros((2, len(means)))
        """Metres that each wheel rolled, and that its encoder miscounted."""
        self.miscounted, self.turned = np.zeros((2, len(means))), np.zeros((2, len(means)))
        self.settled, self.standing, self.farthest = False, False, np.inf
        """Whether all wheels run at their goals, whether these are zero, and how far the farthest
        is from its own, m/s."""
        self._springs = Springs(rows.springs, rows.rates, copies)
        if self._springs.some:
            self._ramp[rows.springs] = LEAST_RAMP
        self._ramps = [np.broadcast_to(ramp, self._gain.shape)
                       for ramp in (self._ramp, self._ramp / self._braking)]
        self._before = self._sums()
        self._goal: Array | None = None
        if arrived:
            self._arrive()

    def decide(self, means: Array, steps: Array) -> None:
        """
        Go on with other means and steps of whether slow requests move the wheels.

        Where these were known before, all copies agree up to now.
        """
        for moves, index in zip(self._moves, s.MOVES):
            moves[:] = means[:, index, None]
            moves[:, 1 + index] += steps[:, index]
            self.steps[:, index] = steps[:, index]
        self._note_moves(means)

    def _note_moves(self, means: Array) -> None:
        self._all_move = bool((means[:, s.MOVES_RIGHT:s.MOVES_LEFT + 1] == 1).all())

    def _arrive(self) -> None:
        """Put the wheels at their goals, where they have been for a while."""
        self.speed = self._goals(self.requests.speeds[:, None, None])
        if self._springs.some:
            self._springs.rate[:] = 0.0
        self.settled, self.standing = True, not self.speed.any()

    @property
    def rates(self) -> Array:
        """How fast the speeds of springs change, m/s²; axes (track, wheel)."""
        rates = np.zeros((self.speed.shape[1], 2))
        if self._springs.some:
            rates[self._springs.which] = self._springs.rate[:, :, 0].T
        return rates

    def _take_unknowns(self, copies: Array) -> None:
        self._gain = copies[s.GAIN_RIGHT:s.GAIN_LEFT + 1]
        self._offset = copies[s.OFFSET_RIGHT:s.OFFSET_LEFT + 1]
        self._moves = copies[s.MOVES_RIGHT:s.MOVES_LEFT + 1]
        self._base_lag = copies[s.LAG]
        self._slow_lag, self._fast_lag = copies[s.SLOW_LAG], copies[s.FAST_LAG]
        dead_times = copies[s.DEAD_TIME]
        self._dead_times = np.maximum(dead_times[:, :s.DEAD_TIME + 2:s.DEAD_TIME + 1], 0.0)
        self._ramp = np.maximum(copies[s.RAMP], LEAST_RAMP)
        self._braking = np.exp(copies[s.BRAKING])
        self.track_width = FIRMWARE_SEPARATION * (1 + copies[s.SEPARATION])
        self._width_of: tuple[float, float] | None = None
        self._lag_of: tuple[float, float] | None = None
        self._parts: tuple[float, ...] = (np.inf,) * 4
        self._decay_of = 0.0

    @property
    def counts(self) -> Array:
        """What the encoders made of the motion: metres forwards, and radians."""
        right, left = self._rolled
        return np.array([(right + left) / 2, (right - left) / self.track_width])

    @property
    def best_counts(self) -> tuple[float, float]:
        """The same of the first track alone."""
        right, left = self._rolled[:, 0, 0].tolist()
        return (right + left) / 2, (right - left) / float(self.track_width[0, 0])

    def transition(self, start: Array) -> Array:
        """
        Return how the states `MOVED` follow from all states since the copies were made.

        A matrix for each of the first tracks, which began at these poses.
        """
        f = np.repeat(SAME, len(start), axis=0)
        ends = np.concatenate([self.speed, self.poses, self.counts])[:, :len(start)]
        ends = ends.transpose(1, 0, 2)
        f[:, :, :s.UNKNOWNS] = (ends[:, :, 1:] - ends[:, :, :1]) / self.steps[:len(start), None]
        f[:, 2, s.YAW] = start[:, 1] - ends[:, 3, 0]
        f[:, 3, s.YAW] = ends[:, 2, 0] - start[:, 0]
        return f

    def ask(self, right: float, left: float, stands: Sequence[bool]) -> Array:
        """Take other requests, of which some may not move; return by how much they changed."""
        self.settled = self.standing = False
        self._goal, self.farthest = None, np.inf
        signs, was_recent = self.requests.signs, self.is_recent
        change = self.requests.ask(right, left, stands)
        if self.requests.signs is not signs:
            turned = self._encoders.turned(signs, self.requests.signs)
            self.turned += turned * self.speed[:, :, 0] ** 2
        if not was_recent:  # else they are those of the last step
            self._before = self._sums()
        return change

    @property
    def is_recent(self) -> bool:
        """Whether wheels may still follow a request that was changed."""
        return self.requests.age - self.behind <= RECENT

    def wait(self, dt: float) -> None:
        """Let time pass in which the copies will roll later."""
        self.requests.step(dt)
        self.behind += dt

    def catch_up(self, stride: float, scales: tuple[float, float]) -> None:
        """
        Let the copies roll until now, in steps of about `stride` seconds while speeds change.

        `scales`: true over counted travel and turn.
        """
        while self.behind > 1.5 * stride and not self.settled:
            self._roll(stride, scales)
        self._roll(self.behind, scales)

    def _roll(self, h: float, scales: tuple[float, float]) -> None:
        """Let h seconds pass, in parts where a step of the requests reaches a wheel meanwhile."""
        recent = self.is_recent
        self.behind -= h
        if not recent:
            self._step(h, None, scales)
            return
        end = self._dead_times + self.behind
        begin = end + h
        left: float | Array = h
        for broken in self.requests.broken(begin, end):
            self._step(begin - broken, self.requests.sums(broken), scales)
            begin, left = broken, broken - end
        self._step(left, self.requests.sums(end), scales)

    def _step(self, h: float | Array, sums: Array | None, scales: tuple[float, float]) -> None:
        """
        Let h seconds pass, in which changes of the requests count as their mean.

        `sums`: over the requests at the end, as late as each dead time; None: nothing changes.
        Both have an entry for each track's dead time, and its copy's; h may be one number for all.
        """
        asked: Array = self.requests.speeds[:, None, None]
        means = None
        if sums is not None:
            means = (sums - self._before) / _at_least(h)
            self._before = sums
            asked = means[0].take(OF_COPY, axis=2)
            self._hear(asked)
        h = _of_copies(h)
        before = self.speed
        if self.free or self.settled:
            travel = self.speed * h
        else:
            travel = self._follow(asked, h, recent=sums is not None)
        counted = travel
        if not self.free:
            counted = self._counted(travel, before, h, means)
        self._move(travel, counted, scales)

    def _hear(self, asked: Array) -> None:
        """Note how fast each wheel is that hears of another request: its lag depends on it."""
        now, before = asked[:, 0, 0].tolist(), self._heard
        if now != before:
            speeds = self.speed[:, 0, 0].tolist()
            self._heard, (right, left) = now, (
                max(abs(each), abs(speed)) if abs(each - was) > SAME_SPEED else fastest
                for each, was, speed, fastest in zip(now, before, speeds, self._fastest))
            self._fastest = right, left

    def _sums(self) -> Array:
        """Return sums over the requests as late as each track's dead time, and its copy's."""
        return self.requests.sums(self._dead_times + self.behind)

    def _follow(self, asked: Array, h: float | Array, *, recent: bool) -> Array:
        """Let wheels run towards their goals; return their travel."""
        goal = self._goal
        if goal is None or recent:
            goal = self._goal = self._goals(asked)
        self._find_lag(h)
        springs, before = self._springs, self.speed
        way = goal - before
        if not recent:
            self.farthest = float(np.abs(way).max())
        if springs.only:
            self.speed, travel = springs.roll(goal, way, before)
        else:
            braking = way * before < 0
            if np.count_nonzero(braking):
                self.speed, travel = lags.braked(
                    goal, before, braking, h, self._usual, self._softer)
            elif (np.abs(way) * self._ramp > self._lag).any():
                self.speed, travel = lags.bounded(goal, way, h, self._usual)
            else:
                travel = self._follow_freely(goal, way, h)
        if springs.some and not springs.only:
            which = springs.which
            self.speed[:, which], travel[:, which] = springs.roll(
                *(each.take(which, axis=1) for each in (goal, way, before)))
        if not recent and self.farthest < ARRIVED and not (springs.some and springs.swinging):
            self._settle(goal, travel)
        return travel

    def _settle(self, goal: Array, travel: Array) -> None:
        """Put wheels at their goals; add the travel that this costs."""
        travel += (goal - self.speed) * -self._lag
        if self._springs.some:
            travel[:, self._springs.which] += self._springs.stop()
        self.speed, self.settled = goal.copy(), True
        self.standing = not self.speed.any()

    def _goals(self, asked: Array) -> Array:
        """Return the speeds at which wheels settle that are asked for these."""
        goal: Array = self._gain * asked + self._offset * np.minimum(
            np.maximum(asked * (1 / EDGE), -1.0), 1.0)
        if self._all_move:
            return goal
        moved: Array = np.where(np.abs(asked) < self._slowest, goal * self._moves, goal)
        return moved

    def _follow_freely(self, goal: Array, way: Array, h: float | Array) -> Array:
        """Let wheels follow that do not brake, and whose acceleration is not bounded."""
        if not isinstance(h, float) or h != self._decay_of:
            self._decay_of = h if isinstance(h, float) else 0.0
            self._decay = np.exp(-h / self._lag)
            self._gone = (1 - self._decay) * self._lag
        self.speed = goal - way * self._decay
        travel: Array = goal * h - way * self._gone
        return travel

    def _find_lag(self, h: float | Array) -> None:
        """Work out the lag at the present speeds, and for springs what it does in h seconds."""
        if self._lag_of != self._fastest:
            self._lag_of = self._fastest
            right, left = map(lags.lag_parts, self._fastest)
            parts = *right, *left
            if any(abs(part - was) > ALIKE for part, was in zip(parts, self._parts)):
                self._take_lag(parts)
        springs = self._springs
        if not springs.some:
            return
        if not isinstance(h, float):
            self._springs_of = 0.0
            springs.prepare(self._lag.take(springs.which, axis=1), h[springs.which])
        elif h != self._springs_of:
            self._springs_of = h
            springs.prepare(self._lag.take(springs.which, axis=1), h)

    def _take_lag(self, parts: tuple[float, ...]) -> None:
        """Work out the lag anew: its slow and fast part count so much, right then left."""
        self._parts, self._decay_of, self._springs_of = parts, 0.0, 0.0
        slow, fast = np.array(parts).reshape(2, 2).T[:, :, None, None]
        part = np.maximum(1 + self._slow_lag * slow - self._fast_lag * fast, LEAST_PART)
        self._lag = lag = np.maximum(self._base_lag * part, SHORTEST_LAG)
        self._usual, self._softer = zip((lag, lag / self._braking), self._ramps)

    def _counted(
        self, travel: Array, before: Array, h: float | Array, means: Array | None,
    ) -> Array:
        """Return what the encoders make of the travel, by each track's idea of their signs."""
        requests, encoders = self.requests, self._encoders
        if encoders.see_motion(travel, requests.one_sign):
            return travel
        late = None
        if means is not None:
            kept, up = means[1:].take(OF_COPY, axis=3)
            late = kept, up
        rolled = _rolled(travel, before, self.speed, h)
        return encoders.counted(travel, rolled, requests.signs, late)

    def _move(self, travel: Array, counted: Array, scales: tuple[float, float]) -> None:
        x, y, yaw = self.poses[0], self.poses[1], self.poses[2]
        right, left = travel[0], travel[1]
        if self._width_of != scales:
            self._width_of, self._turn = scales, scales[1] / self.track_width
        turn = (right - left) * self._turn
        went = (right + left) * (scales[0] / 2)
        half = turn / 2
        middle = yaw + half
        if self.settled:  # an arc, maybe a long one
            went *= np.sinc(half / np.pi)
        x += went * np.cos(middle)
        y += went * np.sin(middle)
        yaw += turn
        self._rolled += counted
        best = travel[:, :, 0]
        self.path += np.abs(best)
        if counted is not travel:
            self.miscounted += np.abs(best - counted[:, :, 0])


def _at_least(h: float | Array) -> float | Array:
    """Return these seconds, or a moment."""
    return max(h, MOMENT) if isinstance(h, float) else np.maximum(h, MOMENT)


def _of_copies(each: float | Array) -> float | Array:
    """Return what each copy has, from what each track's two dead times have."""
    return each if isinstance(each, float) else each.take(OF_COPY, axis=1)


def _rolled(travel: Array, before: Array, after: Array, h: float | Array) -> Array:
    """Return the metres that wheels rolled, forth and back, while their speeds changed."""
    rolled: Array = np.abs(travel)
    back = before * after < 0
    if np.count_nonzero(back):
        change = np.maximum(np.abs(after - before), 1e-9)
        both = (before * before + after * after) * (h / 2) / change
        rolled = np.where(back, both, rolled)
    return rolled
