# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What is believed of the robot, under each assumption about it that is still plausible.

A track is a Kalman filter over `states`: between readings its wheels are simulated, with a copy
for each unknown, and the differences between the copies are the columns of the transition matrix.
All tracks are rows of the same arrays. docs/odometry.md has the sums.
"""

from math import inf

import numpy as np

from ..robot import Rounding, SLOT
from . import accumulators, noise
from . import states as s
from .accumulators import UNITS
from .assumptions import Assumptions, YOUNG
from .dead_band import DeadBand, FASTEST
from .doubt import Doubt
from .estimate import Geometry
from .mark import MarkedPose
from .mean_pose import MeanPose
from .noise import MOVED, PLACE
from .request_history import Array, RECENT
from .rounding import telling_in
from .states import DEGREE, MM
from .wheel_model import ARRIVED, WheelModel

STRIDE = 1.9 * SLOT
"""Seconds that wheels roll at once while their speeds change."""
LATE = 1.6 * SLOT
"""Seconds of a frame from which on one before it was lost."""
CURVED, CURVED_SPRING = 0.2, 0.3
"""Part of what unknowns are believed to do that is not in proportion to them, for lags and for
springs."""
SPRUNG = 0.5
"""How much larger the variance of a pose is than a filter of wheels that overshoot believes, once
these are not new."""
FAMILIAR, PUZZLED, APART = 64, 5.0, 1.0
"""Readings after which a robot is known, unless the best track has this doubt; seconds from one to
the next that count as one. Those of a probe teach how it rounds, not how its wheels run."""
VAGUE, OPEN = 0.1, 0.5
"""Least standard deviation of an angle, degrees, of which a reading may tell something, and how
many of them it may be from where another whole number begins."""
NEAR = 0.002
"""m/s from its goal at which a wheel's speed is known well enough to tell roundings apart."""
SWIFT = 0.3
"""Seconds in which most wheels have followed a request."""
SLIGHT = 0.1
"""Part of a unit: less in a window that is read as zero is no motion, where nothing drives."""
RESTLESS = 0.03
"""Doubt of the speed of wheels that begin or cease to obey, m/s."""
ALL, BEST = slice(None), slice(1)
"""Tracks."""
Held = tuple[float, float]
"""What the accumulators hold, m and rad."""


class Tracks:
    """All plausible tracks, the best first after each reading."""

    def __init__(self, geometry: Geometry, rows: Assumptions | None = None,
                 band: DeadBand | None = None) -> None:
        self.geometry = geometry
        self.scales = self._true_scales = geometry.linear_scale, geometry.angular_scale
        self.rows = rows or Assumptions.new()
        self.wheels = WheelModel(FASTEST)
        self.band = band or DeadBand()
        self.doubt = Doubt()
        self._mean = MeanPose(self.wheels)
        self._rates_of: Array | None = None
        self._rates = 0.0, 0.0
        """What was last asked for by `rates`, and of which speeds."""
        self.blur = self._vague = 0.0
        """Standard deviation of what the accumulators hold, 2 mm or degrees, when last looked; the
        same of the angle alone, degrees."""
        accumulators.empty(self.rows)
        self._noisy: Array = np.zeros((2, 0))
        """Variances of the accumulators since the last reading that are process noise."""
        self._path: Array = np.zeros((2, 0))
        """Metres that each wheel rolled since then."""
        self._forget()
        self._open_window()

    # What is believed.

    @property
    def roundings(self) -> set[Rounding]:
        """The roundings that the robot may have."""
        return self._roundings

    @property
    def requests(self) -> tuple[float, float]:
        """What the wheels are asked, right and left."""
        return self.wheels.requests.asked

    @property
    def is_free(self) -> bool:
        """Whether the wheels do not do what is asked."""
        return self.wheels.free

    @property
    def settled(self) -> bool:
        """Whether all wheels run near their goals, whatever is assumed of them."""
        return self.wheels.settled or self.wheels.farthest < NEAR

    @property
    def rests(self) -> bool:
        """Whether nothing moves, and nothing will under the same requests."""
        return self.wheels.standing and not self.wheels.free

    @property
    def rates(self) -> tuple[float, float]:
        """Metres and radians that the accumulators gain in a second."""
        if self.wheels.speed is not self._rates_of:
            self._rates_of = self.wheels.speed
            right, left = self._rates_of[:, 0, 0].tolist()
            self._rates = (right + left) / 2, (right - left) / float(self.wheels.track_width[0, 0])
        return self._rates

    @property
    def held(self) -> Held:
        """What the accumulators are believed to hold."""
        self._catch_up()
        distance, angle = self.wheels.best_counts
        return (float(self.rows.means[0, s.DISTANCE]) + distance,
                float(self.rows.means[0, s.ANGLE]) + angle)

    def tells_in(self, ahead: float) -> float:
        """
        Return in how many seconds a question would tell much of a robot that loses fractions.

        Nobody knows then which whole angle it will report, so many seconds later. A degree that is
        certain would tell nothing. At the present rates; infinity: in no time.
        """
        if self._vague < VAGUE:
            return inf
        rate = self.rates[1] / DEGREE
        angle = float(self.rows.means[0, s.ANGLE]) + self.wheels.best_counts[1]
        angle = angle / DEGREE + rate * (self.wheels.behind + ahead)
        return telling_in(self.rows.roundings[0], angle, rate, OPEN * self._vague)

    def goals(self, right: float, left: float) -> tuple[float, float]:
        """Return the speeds at which the wheels settle when they are asked for these, m/s."""
        gain_right, gain_left, offset_right, offset_left = self.rows.means[0, s.GOALS].tolist()
        return (gain_right * right + offset_right * ((right > 0) - (right < 0)),
                gain_left * left + offset_left * ((left > 0) - (left < 0)))

    def pose(self) -> tuple[float, float, float]:
        """Return the mean pose now: x, y, yaw."""
        return self._mean.now()

    def pose_covariance(self, *, glance: bool = False) -> tuple[float, ...]:
        """Return the covariance of the mean pose, row by row; a glance has no other effect."""
        if not glance:
            self._catch_up()
        poses = self.wheels.poses[:, :, 0]
        off = poses - (poses @ self._shares)[:, None]
        p = self.rows.p[0, s.X:, s.X:]
        if self._seconds:
            f = self.wheels.transition(self._start[BEST])[0, PLACE]
            p = f @ self.rows.p[0] @ f.T + self._noise(BEST)[0, PLACE, PLACE]
        if not glance:
            far, turn = np.sqrt(p.diagonal()[3:]).tolist()
            self._vague, self.blur = turn / DEGREE, max(far / MM / 2, turn / DEGREE)
        p = p[:3, :3] + (off * self._shares) @ off.T
        if self.rows.readings > YOUNG:
            p *= 1 + SPRUNG * float(self._shares @ self.rows.springs)
        return tuple(((p + p.T) / 2).ravel().tolist())

    def twist_variance(self) -> tuple[float, float]:
        """Return the variance of the forward speed, (m/s)², and of the turn rate, (rad/s)²."""
        variances = self.rows.p[0].diagonal()
        gains = variances[noise.GAINS] * self.wheels.speed[:, 0, 0] ** 2
        both = float(variances[s.SPEED_RIGHT:s.SPEED_LEFT + 1].sum() + gains.sum())
        return both / 4 + 1e-6, both / float(self.wheels.track_width[0, 0]) ** 2 + 1e-6

    # Motion.

    def advance(self, dt: float, right: float, left: float, *, to_read: bool = False) -> None:
        """
        Let time pass under these requests; `to_read`: a reading follows at once.

        Where frames were lost, nobody knows when within that time the requests came.
        """
        if (right, left) != self.requests:
            if dt > LATE:
                dt /= 2
                self._roll(dt)
            change = self._ask(right, left, to_read)
            if dt > LATE / 2:
                self._unsure += (change * dt) ** 2 / 3
        self._roll(dt)

    def lift(self, lifted: bool) -> None:
        """Take the robot off the floor, where wheels turn and nothing moves, or put it down."""
        self._close()
        self.scales = (0.0, 0.0) if lifted else self._true_scales
        self._spread()

    def free(self, free: bool) -> None:
        """Give up the requested speeds, or trust them again."""
        self._close()
        for index, speed in zip(s.SPEEDS, (0.0, 0.0) if free else self.requests):
            self.rows.clear(index, speed, RESTLESS ** 2)
        self.rows.rates[:] = 0.0
        self.wheels.free = free
        self._wild |= free
        self._spread()

    def resume(self, right: float, left: float) -> None:
        """Go on after a gap in which the wheels have reached these requests."""
        self._catch_up()
        self._ask(right, left)
        self.wheels.requests.settle()
        self.free(self.wheels.free)

    def mark(self) -> None:
        """Remember where the robot is now."""
        self._close()
        self.rows.mark = MarkedPose(self.rows.means, self.rows.p)
        self._spread()

    def reset(self) -> None:
        """Put the origin where the robot is."""
        self._close()
        for index in s.POSE:
            self.rows.clear(index)
        self._spread()

    def _roll(self, dt: float) -> None:
        self._seconds += dt
        self._window += dt
        self.wheels.wait(dt)
        if (not self.wheels.settled or self.wheels.free) and self.wheels.behind > STRIDE:
            self._catch_up()

    def _catch_up(self) -> None:
        """Let the copies of the wheels roll until now."""
        if self.wheels.behind:
            self._mean.roll()
            self.wheels.catch_up(STRIDE, self.scales)

    def _ask(self, right: float, left: float, to_read: bool = False) -> Array:
        """Take other requests; return by how much they changed."""
        turning = self.wheels.requests.turning(right, left)
        if self.wheels.requests.age > RECENT or any(turning):
            self._catch_up()
        if self.rows.open_signs and (abs(self.wheels.speed[turning, :, 0]) > ARRIVED).any():
            self._tell_signs_apart()
        were_open = any(self.band.open)
        answers = self.band.ask(right, left, self.wheels.requests.age)
        if not self.band.goes_on and (
                were_open or [self.rows.means.item(0, index) for index in s.MOVES] != answers):
            self._decide(answers, anew=were_open or not to_read)
        change = self.wheels.ask(right, left, [answer == 0 for answer in answers])
        self._changes += change * change
        return change

    def _decide(self, answers: list[float | None], *, anew: bool) -> None:
        """Take other answers to whether wheels move; their copies are made `anew`, or go on."""
        if anew:
            self._close()
            self.band.decide(self.rows, answers)
            self._spread()
        else:  # a reading will make them, and nothing has depended on the answers up to now
            self._catch_up()
            self.band.decide(self.rows, answers)
            self.wheels.decide(self.rows.means, self.rows.steps())

    def _tell_signs_apart(self) -> None:
        """Follow each sign of the encoders from now on."""
        self._close()
        each = len(self.rows.weights)
        self.rows.tell_signs_apart()
        times = len(self.rows.weights) // each
        self._noisy, self._path = self._noisy.repeat(times, -1), self._path.repeat(times, -1)
        self._spread()

    # Covariance.

    def _spread(self, *, arrived: bool = False) -> None:
        """Make the copies of the wheels anew."""
        self.wheels.spread(self.rows, self.rows.steps(), arrived=arrived)
        self._shares = self.rows.shares()
        self._mean.begin(self._shares, self.scales)
        roundings, shares = self.rows.roundings, self._shares.tolist()
        self._roundings = {each for each, share in zip(roundings, shares) if share}
        carries = self._roundings == {Rounding.CARRY} or self.rows.doubt[0] > PUZZLED
        self.known = 0.0 if carries else min(1.0, self.rows.taught / FAMILIAR)
        """How well a robot is known that loses fractions by being asked, 0 to 1."""
        self._start = self.rows.means[:, s.X:s.YAW + 1].copy()

    def _forget(self) -> None:
        """Begin to gather noise afresh."""
        self._seconds, self._changes, self._unsure = 0.0, np.zeros(2), np.zeros(2)

    def _noise(self, tracks: slice) -> Array:
        w = self.wheels
        did = noise.Stretch(self._seconds, self._changes, self._unsure, w.path[:, tracks],
                            w.turned[:, tracks], w.miscounted[:, tracks], w.free)
        heading = (w.poses[2, tracks, 0] + self._start[tracks, 2]) / 2
        return noise.of_motion(did, self.rows.doubt[tracks], heading, w.track_width[tracks, 0],
                               self.scales, self.geometry.slip, self.rows.unsteady[tracks])

    def _carried(self, p: Array) -> Array:
        """Make covariances of the start those of now; what is far from linear is noise in part."""
        w, rows = self.wheels, self.rows
        f, q = w.transition(self._start), self._noise(ALL)
        g, unknown = f[:, PLACE, :s.UNKNOWNS], p[:, :s.UNKNOWNS, :s.UNKNOWNS]
        curved = np.where(rows.springs, CURVED_SPRING, CURVED)[:, None, None] ** 2
        moved, curved = f @ p, curved * (g @ unknown @ g.transpose(0, 2, 1))
        aged = np.einsum('tii->ti', p)
        aged += noise.of_age(self._seconds, w.path, rows.doubt, rows.unsteady)
        p[:, MOVED], p[:, :, MOVED] = moved, moved.transpose(0, 2, 1)
        p[:, MOVED, MOVED] = moved @ f.transpose(0, 2, 1) + q
        p[:, s.X:, s.X:] += curved
        self._q = q.diagonal(axis1=1, axis2=2)[:, s.DISTANCE - MOVED.start:].T
        return p

    def _close(self) -> None:
        """Bring means and covariances up to now; the copies are to be made anew."""
        self._catch_up()
        w, means = self.wheels, self.rows.means
        if self.rows.mark is not None:
            self.rows.mark.advance(w.transition(self._start))
        self._carried(self.rows.p)
        self._noisy += self._q
        self._path += w.path
        means[:, s.X:s.YAW + 1] = w.poses[:, :, 0].T
        means[:, s.DISTANCE:] += w.counts[:, :, 0].T
        means[:, s.SPEED_RIGHT:s.SPEED_LEFT + 1] = w.speed[:, :, 0].T
        self.rows.rates = w.rates
        self._forget()

    # Readings.

    def read(self, distance: int, angle: int, *, doubted: bool = False, driven: bool = True,
             ) -> None:
        """Take a reading in; `doubted`: expect nothing of it; `driven`: else only pushes move."""
        wholes, rows = (distance, angle), self.rows
        if wholes == (0, 0) and self.rests and not self.wheels.path.any():
            self._window = 0.0
            return  # it stood all the time, and nothing is learned
        self._catch_up()
        moved = zip(self.wheels.best_counts, UNITS)
        if wholes == (0, 0) and not driven and all(
                abs(count) < SLIGHT * unit for count, (_, unit) in moved):
            self._forget()
            for index in s.SPEEDS:
                rows.clear(index, 0.0, RESTLESS ** 2)
            self._open_window()
            return  # nobody pushes it
        self._close()
        if self._wild and any(wholes):
            width = float(self.wheels.track_width[0, 0])
            rows.p += noise.of_roaming(
                distance * MM, angle * DEGREE, width, self._window, self.scales)
        if doubted:
            (far, turn), _ = accumulators.innovation(rows, wholes)
            rows.p += noise.of_surprise(
                far ** 2 + MM ** 2, turn ** 2 + DEGREE ** 2, rows.means[:, s.YAW], self.scales)
        steady = self.wheels.requests.age > self._window + SWIFT
        logs = self.doubt.meet(rows, wholes, self._noisy, self.scales)
        if steady and not self._wild:
            self.doubt.watch(rows, self._path, self.wheels.track_width[:, 0])
        if self.doubt.is_surprised and steady:
            self.band.doubt()
        logs += accumulators.learn(rows, wholes)
        rows.taught += min(1.0, self._window / APART)
        rows.weigh(logs / max(1.0, float(rows.doubt[0])))  # a model that fails tells little
        accumulators.take_out(rows, wholes)
        rows.bound()
        for wheel in self.band.learn(self.rows, self.wheels.requests.age):
            self.wheels.requests.stand(wheel)
        self.doubt.rethink(rows, free=self.is_free)
        self._open_window(arrived=self.wheels.settled)

    def discard(self) -> None:
        """Let a reading go by that spans an unknown time: only the reset counts."""
        self._close()
        accumulators.empty(self.rows)
        self._open_window(arrived=self.wheels.settled)

    def explains(self, distance: int, angle: int) -> bool:
        """Tell whether a plausible track expected such a reading."""
        self._catch_up()
        p, fits = self._carried(self.rows.p.copy()), self.rows.weights > 1e-3
        for (index, unit), whole, moved in zip(UNITS, (distance, angle), self.wheels.counts):
            gap = np.abs(self.rows.means[:, index] + moved[:, 0] - whole * unit)
            fits &= gap < 4 * np.sqrt(p[:, index, index]) + 1.2 * unit
        return bool(fits.any())

    def _open_window(self, *, arrived: bool = False) -> None:
        self._wild, self._window = self.is_free, 0.0
        """Whether wheels were free since the last reading, and its age, seconds."""
        self._spread(arrived=arrived)
        self._noisy, self._path = np.zeros((2, *self.wheels.path.shape))
