"""
What is believed of the robot, under each assumption about it that is still plausible.

A track assumes how readings are rounded, where encoders take their signs from, and a kind of
response to begin with. It is a Kalman filter over `states`: between readings its wheels are
simulated, with a copy for each unknown, and the differences between the copies are the columns of
the transition matrix. All tracks are rows of the same arrays. docs/odometry.md has the sums.
"""

from itertools import product
from math import log, radians
from typing import Any

import numpy as np

from . import states as s
from .dead_band import DeadBand, FASTEST, OPEN
from .estimate import Geometry
from .requests import Array
from .rounding import cut_normal, interval, Rounding
from .wheel_model import LAST, NONE, Signs, UPWARD, Wheels

MM, DEGREE = 1e-3, radians(1)
UNITS = ((s.DISTANCE, MM), (s.ANGLE, DEGREE))
SIGNS = ((NONE, False), (LAST, False), (LAST, True), (UPWARD, False), (UPWARD, True))
"""Signs of encoders, and whether they wait for the dead time (`wheel_model.Wheels`)."""
LIKELY_ROUNDING = {Rounding.TRUNCATE: 2.0}
LIKELY_SIGN = {(LAST, True): 4.0, (LAST, False): 2.0}
"""How much likelier than the rest these are before the first reading; reported of real robots."""
SLOT, LATE = 0.015, 0.024
"""Seconds of a step, and of a frame from which on one before it was lost."""
SMALLEST_STEP = 1e-5
MISTRUST, TEMPER = 1000.0, 0.5
"""Doubt of the best track up to which likelihoods count less, and by which power of it."""
TICKS = (0.15 * MM, 0.05 * DEGREE)
"""Standard deviations of what an encoder's tick hides."""
JITTER = 0.003
"""Seconds by which a request may take effect earlier or later than the dead time says."""
UNEVEN = 5e-4
"""Part of the path by which steady wheels depart from their goals."""
MISCOUNTED = 0.03
"""Part of what was counted with the wrong sign that the model may be wrong by."""
IMPLAUSIBLE = 1e-6
UNLIKELY, LEAST = 1e-2, 4.0
"""Likelihood that is left to a reading that ought not to be; logarithm of what any track keeps."""
SURPRISE, LEFT = 3.0, 2.0
"""Standard deviations from which on a reading is a surprise, and what is left of it."""
CURVED = 0.2
"""Part of what unknowns are believed to do that is not in proportion to them."""
LOST, ENOUGH, PAUSE = 30.0, 12, 40
"""Doubt, for how many readings, from which on other tracks are tried again; readings in between."""
YOUNG, OLD = 30, 120
"""Readings from which on only one track of each kind is kept, and none for the sake of variety."""
NEGLIGIBLE = 1e-4
"""Weight below which a track has no share in the estimate."""
REBORN = 1e-2
"""Weight of all the tracks that are tried again."""
CLEAR = 5.0
"""Doubt of the best track from which on no other is given up, ..."""
LEAST_WEIGHT = 2e-6
"""... and the weight that others keep then."""
STRAY = 0.09
"""Metres by which wheels that do not obey stray from their counts, per root metre."""
FREE_SPEED = 0.3
"""Doubt of the speed of wheels that do not obey, m/s."""


Held = tuple[float, float]
"""What the accumulators hold, m and rad."""


class Tracks:
    """All plausible tracks, the best first after each reading."""

    def __init__(self, geometry: Geometry) -> None:
        self.geometry = geometry
        self.scales = geometry.linear_scale, geometry.angular_scale
        self._begin()
        self.wheels.slowest = FASTEST
        self.band = DeadBand()
        self._changes = np.zeros(2)
        self._unsure = np.zeros(2)
        self._seconds = 0.0
        self._known = False
        self.empty()
        self._spread()

    def _begin(self) -> None:
        """Assume anything that is plausible of a robot that nobody knows."""
        kinds = list(product(Rounding, SIGNS, s.RESPONSES))
        count = len(kinds)
        self._astray = 0
        """Readings in a row that the best track did not explain."""
        self.roundings = [rounding for rounding, _, _ in kinds]
        self._readings = 0
        weights = np.array([LIKELY_ROUNDING.get(rounding, 1.0) * LIKELY_SIGN.get(sign, 1.0)
                            for rounding, sign, _ in kinds])
        self.weights = self.shares = weights / weights.sum()
        self.doubt = np.ones(count)
        """What process noise is multiplied by, as innovations have it."""
        self.means = np.zeros((count, s.SIZE))
        self.p = np.zeros((count, s.SIZE, s.SIZE))
        for row, (_, _, response) in enumerate(kinds):
            for index, prior in (s.COMMON | response).items():
                self.means[row, index] = prior.mean
                self.p[row, index, index] = prior.spread ** 2
        self.wheels = Wheels(Signs(np.array([sign for _, (sign, _), _ in kinds]),
                                   np.array([late for _, (_, late), _ in kinds])))
    def _rethink(self) -> None:
        """Try everything again beside the tracks that have explained little for long."""
        self._astray = self._astray + 1 if self.doubt[0] > LOST else min(self._astray, 0)
        if self._astray < ENOUGH or self.is_free:
            return
        old, requests, slowest = self._rows(), self.wheels.requests, self.wheels.slowest
        mean, p = self.means[0], self.p[0]
        self._begin()
        self.empty()
        self._astray = -PAUSE
        kept = [*range(s.UNKNOWNS - 4, s.SIZE - 2)]
        self.means[:, kept] = mean[kept]
        self.p[:, s.MOVES_RIGHT:s.ANGLE - 1, s.MOVES_RIGHT:s.ANGLE - 1] = p[
            s.MOVES_RIGHT:s.ANGLE - 1, s.MOVES_RIGHT:s.ANGLE - 1]
        self.wheels.requests, self.wheels.slowest = requests, slowest
        self.weights *= REBORN
        new = self._rows()
        self._take_rows([a + b if isinstance(a, list) else np.concatenate([a, b])
                         for a, b in zip(old, new)])
        self.weights /= self.weights.sum()
        self._share()

    def _rows(self) -> list[Any]:
        """Return what is kept of each track."""
        signs = self.wheels.signs
        return [self.roundings, self.weights, self.doubt, self.means, self.p, signs.kinds,
                signs.late]

    def _take_rows(self, rows: list[Any]) -> None:
        self.roundings, self.weights, self.doubt, self.means, self.p, kinds, late = rows
        self.wheels.signs = Signs(kinds, late)

    # Motion.

    def advance(self, dt: float, right: float, left: float) -> None:
        """
        Let time pass under these requests.

        Where frames were lost, nobody knows when within that time the requests came.
        """
        if (right, left) != tuple(self.wheels.requests.speeds):
            if dt > LATE:
                self._roll(dt / 2)
                dt /= 2
            change = self._ask(right, left)
            if dt > LATE / 2:
                self._unsure += (change * dt) ** 2 / 3
        self._roll(dt)

    def _roll(self, dt: float) -> None:
        self._seconds += dt
        while dt > LATE:
            self.wheels.roll(SLOT, self.scales)
            dt -= SLOT
        self.wheels.roll(dt, self.scales)

    def _ask(self, right: float, left: float) -> Array:
        """Take other requests; return by how much they changed."""
        band, before = self.band, list(self.band.open)
        answers = band.ask(np.array([right, left]))
        if band.open != before or any(before):
            self.close()
            self._decide(answers)
            self._spread()
        elif self.means[0, s.MOVES_RIGHT:s.MOVES_LEFT + 1].tolist() != answers:
            self.close()
            self._decide(answers)
            self._spread()
        change = self.wheels.ask(right, left)
        self._changes += change * change
        return change

    def _decide(self, answers: list[float | None]) -> None:
        """Set what the wheels move by at their requests; None is open."""
        for index, answer in zip((s.MOVES_RIGHT, s.MOVES_LEFT), answers):
            for track in range(len(self.means)):
                self._clear(track, index, OPEN ** 2 if answer is None else 0.0)
            self.means[:, index] = OPEN if answer is None else answer

    def _learn_band(self) -> None:
        """See whether the undecided wheels are decided by now."""
        if not any(self.band.open):
            return
        rows = slice(s.MOVES_RIGHT, s.MOVES_LEFT + 1)
        spreads = np.sqrt(np.diag(self.p[0])[rows])
        answers = self.band.learn(self.means[0, rows], spreads)
        for index, answer in zip((s.MOVES_RIGHT, s.MOVES_LEFT), answers):
            if answer is not None:
                for track in range(len(self.means)):
                    self._clear(track, index, 0.0)
                self.means[:, index] = answer

    def pose(self) -> Array:
        """Return the mean pose now: x, y, yaw."""
        return self.wheels.poses[:, :, 0] @ self.shares

    @property
    def requests(self) -> tuple[float, float]:
        """What the wheels are asked, right and left."""
        right, left = self.wheels.requests.speeds
        return float(right), float(left)

    @property
    def is_free(self) -> bool:
        """Whether the wheels do not do what is asked."""
        return self.wheels.free

    @property
    def rests(self) -> bool:
        """Whether nothing moves, and nothing will under the same requests."""
        return self.wheels.settled and not self.wheels.free and not self.wheels.speed.any()

    @property
    def gains(self) -> tuple[float, float]:
        """The best track's gains."""
        return float(self.means[0, s.GAIN_RIGHT]), float(self.means[0, s.GAIN_LEFT])

    @property
    def held(self) -> Held:
        """What the accumulators are believed to hold, m and rad."""
        w = self.wheels
        return (float(self.means[0, s.DISTANCE] + w.counts[0, 0, 0]),
                float(self.means[0, s.ANGLE] + w.counts[1, 0, 0]))

    @property
    def rounding_known(self) -> bool:
        """Whether one rounding is left."""
        return self._known

    @property
    def may_carry(self) -> bool:
        """Whether fractions may be carried."""
        return any(rounding is Rounding.CARRY and share > 0
                   for rounding, share in zip(self.roundings, self.shares))

    @property
    def settled(self) -> bool:
        """Whether all wheels run at their goals, whatever is assumed of them."""
        return self.wheels.settled

    def fractions(self, dt: float) -> tuple[float, float]:
        """Return the fractions of a unit by which distance and angle grow in a frame."""
        right, left = self.wheels.speed[:, 0, 0]
        steps = (right + left) / 2 / MM, (right - left) / self.wheels.track_width[0, 0] / DEGREE
        return float(abs(steps[0] * dt) % 1), float(abs(steps[1] * dt) % 1)

    def rest(self, dt: float) -> None:
        """Let time pass in which it `rests`."""
        self._seconds += dt
        self.wheels.requests.step(dt)

    def lift(self, lifted: bool) -> None:
        """Take the robot off the floor, where wheels turn and nothing moves, or put it down."""
        self.close()
        g = self.geometry
        self.scales = (0.0, 0.0) if lifted else (g.linear_scale, g.angular_scale)
        self._spread()

    def free(self, free: bool) -> None:
        """Give up the requested speeds, or trust them again."""
        self.close()
        speeds = np.zeros(2) if free else self.wheels.requests.speeds
        for index, speed in zip((s.SPEED_RIGHT, s.SPEED_LEFT), speeds):
            for track in range(len(self.means)):
                self._clear(track, index, 0.03 ** 2)
            self.means[:, index] = speed
        self.wheels.free = free
        self._spread()

    def resume(self, right: float, left: float) -> None:
        """Go on after a gap in which the wheels have reached these requests."""
        self._ask(right, left)
        self.wheels.requests.settle()
        self.free(self.wheels.free)

    def since(self, began: Held, ended: Held, distance: int, angle: int) -> bool:
        """
        Tell whether a surprising reading is only what came since a moment.

        A reading was lost on the line while the accumulators held something between these.
        """
        if self.is_free or self.explains(distance, angle):
            return False
        for (_, unit), whole, now, first, last in zip(
                UNITS, (distance, angle), self.held, began, ended):
            low, high = sorted((now - first, now - last))
            if not low - 2 * unit <= whole * unit <= high + 2 * unit:
                return False
        return True

    def explains(self, distance: int, angle: int) -> bool:
        """Tell whether a plausible track expected such a reading."""
        w = self.wheels
        p = self._carried(self._transition())
        fits = self.weights > 1e-3
        for (index, unit), whole, moved in zip(UNITS, (distance, angle), w.counts):
            gap = np.abs(self.means[:, index] + moved[:, 0] - whole * unit)
            fits &= gap < 4 * np.sqrt(p[:, index, index]) + 1.2 * unit
        return bool(fits.any())

    # Covariance.

    def _spread(self) -> None:
        variances = np.einsum('tii->ti', self.p)[:, :s.UNKNOWNS]
        self.wheels.spread(self.means, np.sqrt(np.maximum(variances, SMALLEST_STEP ** 2)))
        self._start = self.means[:, s.POSE].copy()

    def _transition(self) -> Array:
        """Return the transition of the states since the last reading, a matrix a track."""
        w = self.wheels
        f = np.zeros((len(self.means), s.SIZE, s.SIZE))
        diagonal = np.arange(s.SIZE)
        f[:, diagonal, diagonal] = 1.0
        ends = np.concatenate([w.speed, w.poses, w.counts]).transpose(1, 0, 2)
        f[:, s.SPEED_RIGHT:, :s.UNKNOWNS] = (ends[:, :, 1:] - ends[:, :, :1]) / w.steps[:, None]
        f[:, s.X, s.YAW] = self._start[:, 1] - w.poses[1, :, 0]
        f[:, s.Y, s.YAW] = w.poses[0, :, 0] - self._start[:, 0]
        return f

    def _noise(self) -> Array:
        """Return what no parameter explains, a matrix a track."""
        w, count = self.wheels, len(self.means)
        q = np.zeros((count, s.SIZE, s.SIZE))
        half = w.track_width[:, 0]
        middle = (w.poses[2, :, 0] + self._start[:, 2]) / 2
        path = w.path
        travel = self.doubt * (JITTER ** 2 * self._changes[:, None] + (UNEVEN * path) ** 2)
        travel = travel + self._unsure[:, None]
        if w.free:
            travel = travel + (FREE_SPEED * self._seconds) ** 2
        wrong = self.doubt * (MISCOUNTED * w.miscounted) ** 2
        slip = (STRAY if w.free else self.geometry.slip) ** 2 * path
        linear, angular = self.scales
        for wheel, side in ((0, 1.0), (1, -1.0)):
            g = np.zeros((count, s.SIZE))
            g[:, s.X], g[:, s.Y] = linear * np.cos(middle) / 2, linear * np.sin(middle) / 2
            g[:, s.YAW] = angular * side / half
            q += (slip[wheel])[:, None, None] * g[:, :, None] * g[:, None, :]
            g[:, s.DISTANCE], g[:, s.ANGLE] = 0.5, side / half
            if w.free:
                g[:, s.SPEED_RIGHT + wheel] = 1 / max(self._seconds, 0.015)
            q += travel[wheel][:, None, None] * g[:, :, None] * g[:, None, :]
            g[:, [s.X, s.Y, s.YAW, s.SPEED_RIGHT, s.SPEED_LEFT]] = 0.0
            q += wrong[wheel][:, None, None] * g[:, :, None] * g[:, None, :]
        moved = float(path[:, 0].sum()) > 0
        for index, prior in s.COMMON.items():
            q[:, index, index] += moved * self._seconds * prior.drift ** 2
        return q

    def _carried(self, f: Array) -> Array:
        """Return the covariances now; what is far from linear is noise in part."""
        g, unknown = f[:, s.X:, :s.UNKNOWNS], self.p[:, :s.UNKNOWNS, :s.UNKNOWNS]
        p = f @ self.p @ f.transpose(0, 2, 1) + self._noise()
        p[:, s.X:, s.X:] += CURVED ** 2 * (g @ unknown @ g.transpose(0, 2, 1))
        return p

    def close(self) -> None:
        """Bring means and covariances up to now; the copies begin afresh."""
        w = self.wheels
        f = self._transition()
        self.p = self._carried(f)
        self.means[:, s.POSE] = w.poses[:, :, 0].T
        self.means[:, s.DISTANCE:] += w.counts[:, :, 0].T
        self.means[:, s.SPEED_RIGHT:s.SPEED_LEFT + 1] = w.speed[:, :, 0].T
        self._changes = np.zeros(2)
        self._unsure = np.zeros(2)
        self._seconds = 0.0

    # Readings.

    def read(self, distance: int, angle: int, *, doubted: bool = False) -> None:
        """Take a reading in; `doubted`: expect nothing of it."""
        self.close()
        wholes = (distance, angle)
        if doubted:
            gaps, _ = self._innovation(wholes)
            self._stray(gaps[0] ** 2 + MM ** 2, gaps[1] ** 2 + DEGREE ** 2)
        self._calm(wholes)
        logs = -np.minimum(2 * self._surprises, 3.0)
        for (index, unit), whole, tick in zip(UNITS, wholes, TICKS):
            for track, rounding in enumerate(self.roundings):
                mass = self._cut(track, index, unit, whole, rounding, tick)
                logs[track] += log(mass + UNLIKELY)
        logs /= np.clip(self.doubt[self.weights.argmax()], 1.0, MISTRUST) ** TEMPER
        self._weigh(np.maximum(logs, logs.max() - LEAST))
        self._take_out(distance, angle)
        self._bound()
        self._learn_band()
        self._rethink()
        self._spread()

    def _innovation(self, wholes: tuple[int, int]) -> tuple[Array, Array]:
        """Return how far readings are from their predictions, and the standard deviations."""
        gaps, spreads = [], []
        for (index, unit), whole, tick in zip(UNITS, wholes, TICKS):
            ends = np.array([interval(rounding, whole) for rounding in self.roundings]) * unit
            width = ends[:, 1] - ends[:, 0]
            gaps.append(ends.mean(axis=1) - self.means[:, index])
            spreads.append(np.sqrt(self.p[:, index, index] + tick ** 2 + width ** 2 / 12))
        return np.stack(gaps), np.stack(spreads)

    def _calm(self, wholes: tuple[int, int]) -> None:
        """Learn from the innovations how much noise there is; meet surprises with more of it."""
        gaps, spreads = self._innovation(wholes)
        z = gaps / spreads
        self._surprises = np.maximum(np.abs(z).max(axis=0) - SURPRISE, 0.0)
        if self._surprises[0] > 0:
            self.band.doubt()
        nis = (z * z).mean(axis=0)
        rate = np.where(nis > 1, 0.15, 0.04)
        self.doubt = np.clip(self.doubt * np.exp(rate * np.clip(nis - 1, -1, 6)), 0.5, 1e4)
        more = np.where(np.abs(z) > SURPRISE, (gaps / LEFT) ** 2 - spreads ** 2, 0.0)
        if not more.any():
            return
        self._stray(more[0], more[1])

    def _stray(self, distance: Array, angle: Array) -> None:
        """Doubt the window's travel and turn by these variances, m² and rad²."""
        yaw, (linear, angular) = self.means[:, s.YAW], self.scales
        for noise, terms in (
                (distance, {s.X: linear * np.cos(yaw), s.Y: linear * np.sin(yaw),
                            s.DISTANCE: 1.0}),
                (angle, {s.YAW: angular, s.ANGLE: 1.0})):
            g = np.zeros((len(self.means), s.SIZE))
            for index, value in terms.items():
                g[:, index] = value
            self.p += noise[:, None, None] * g[:, :, None] * g[:, None, :]

    def _cut(self, track: int, index: int, unit: float, whole: int, rounding: Rounding,
             tick: float) -> float:
        """Cut a track's belief to the interval of a whole number; return the mass inside."""
        p, mean = self.p[track], self.means[track]
        variance = p[index, index] + tick * tick
        spread = variance ** 0.5
        low, high = interval(rounding, whole)
        shift, kept, mass = cut_normal((low * unit - mean[index]) / spread,
                                       (high * unit - mean[index]) / spread)
        column = p[:, index].copy()
        mean += column * (shift / spread)
        p -= np.outer(column, column) * ((1 - kept) / variance)
        return mass

    def _weigh(self, logs: Array) -> None:
        """Weigh the tracks by how likely the reading was; drop the implausible."""
        weights = self.weights * np.exp(logs - logs.max())
        weights /= weights.sum()
        if self.doubt[weights.argmax()] > CLEAR and self._readings < OLD:
            weights = np.maximum(weights, LEAST_WEIGHT)
        self._readings += 1
        keep = np.flatnonzero(weights > IMPLAUSIBLE)
        order = keep[np.argsort(-weights[keep])]
        if self._readings > YOUNG:
            order = self._first_of_each_kind(order)
        self.weights = weights
        self._take_rows([[row[i] for i in order] if isinstance(row, list) else row[order]
                         for row in self._rows()])
        self.weights /= self.weights.sum()
        self._share()

    def _first_of_each_kind(self, order: Array) -> list[int]:
        """Leave out tracks that assume the same as a better one, whatever they began with."""
        signs, seen = self.wheels.signs, {}
        for i in order:
            kind = self.roundings[i], int(signs.kinds[i]), bool(signs.late[i])
            seen.setdefault(kind, int(i))
        return list(seen.values())

    def _share(self) -> None:
        """Work out what each track contributes to the mean."""
        shares = np.where(self.weights < NEGLIGIBLE, 0.0, self.weights)
        self.shares = shares / shares.sum()
        self._known = len({rounding for rounding, share in zip(self.roundings, self.shares)
                           if share}) == 1

    def _take_out(self, distance: int, angle: int) -> None:
        for track, rounding in enumerate(self.roundings):
            if rounding is Rounding.CARRY:
                self.means[track, s.DISTANCE] -= distance * MM
                self.means[track, s.ANGLE] -= angle * DEGREE
            else:
                self._clear(track, s.DISTANCE, 0.0)
                self._clear(track, s.ANGLE, 0.0)

    def _clear(self, track: int, index: int, variance: float) -> None:
        self.means[track, index] = 0.0
        self.p[track, index, :] = 0.0
        self.p[track, :, index] = 0.0
        self.p[track, index, index] = variance

    def empty(self) -> None:
        """Set the accumulators to zero, or to an unknown rest below one unit."""
        for track, rounding in enumerate(self.roundings):
            for index, unit in UNITS:
                rest = unit * unit / 3 if rounding is Rounding.CARRY else 0.0
                self._clear(track, index, rest)

    def discard(self) -> None:
        """Let a reading go by that spans an unknown time: only the reset counts."""
        self.close()
        self.empty()
        self._spread()

    def _bound(self) -> None:
        for response in s.RESPONSES:
            for index, prior in (s.COMMON | response).items():
                np.clip(self.means[:, index], prior.low, prior.high, out=self.means[:, index])

    def reset(self) -> None:
        """Put the origin where the robot is."""
        self.close()
        for index in s.POSE:
            self.means[:, index] = 0.0
            self.p[:, index, :] = 0.0
            self.p[:, :, index] = 0.0
        self._spread()

    def pose_covariance(self) -> tuple[float, ...]:
        """Return the covariance of the mean pose, row by row."""
        w = self.wheels
        f = self._transition()[0, s.X:s.YAW + 1]
        p = f @ self.p[0] @ f.T + self._noise()[0, s.X:s.YAW + 1, s.X:s.YAW + 1]
        poses = w.poses[:, :, 0]
        off = poses - (poses @ self.shares)[:, None]
        p = p + (off * self.shares) @ off.T
        return tuple(((p + p.T) / 2).ravel().tolist())

    def twist_variance(self) -> tuple[float, float]:
        """Return the variance of the forward speed, (m/s)², and of the turn rate, (rad/s)²."""
        w, p = self.wheels, self.p[0]
        speeds = w.speed[:, 0, 0]
        both = float(p[s.SPEED_RIGHT, s.SPEED_RIGHT] + p[s.SPEED_LEFT, s.SPEED_LEFT]
                     + p[s.GAIN_RIGHT, s.GAIN_RIGHT] * speeds[0] ** 2
                     + p[s.GAIN_LEFT, s.GAIN_LEFT] * speeds[1] ** 2)
        return both / 4 + 1e-6, both / float(w.track_width[0, 0]) ** 2 + 1e-6
