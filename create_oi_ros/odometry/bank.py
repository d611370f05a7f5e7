# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A bank of extended Kalman filters: one for each hypothesis, source of signs, rounding, noise level.

The state of a filter: the gains of both wheels, how far the robot's angles are off (`TURN`), the
five numbers of how wheels follow, the pose, and what the accumulators hold. What has no derivative
is not estimated but weighed: the kind of response, the dead band, the source of the encoders'
signs, the rounding and the noise level. The innovations of a filter give its weight; the pose is
the mean by weight. Arrays begin with the axes hypothesis, source of signs, rounding, noise level.
"""

from typing import NamedTuple

import numpy as np

from ..robot import FIRMWARE_SEPARATION, Rounding
from .estimate import Geometry
from .hypotheses import (
    Array,
    DEGREE,
    HIGHEST,
    Hypothesis,
    LOWEST,
    MM,
    SIGNS,
    SPREAD,
    STARTS,
    with_numbers,
)
from .knowledge import Knowledge, Known
from .wheels import STEP, Wheels

RIGHT, LEFT, TURN, NUMBER, X, Y, YAW, ANGLE, DISTANCE, SIZE = 0, 1, 2, 3, 8, 9, 10, 11, 12, 13
"""The state of a filter: gains of the wheels; the part by which angles are counted too large; the
numbers of the hypothesis; the pose, m and rad; what the robot's accumulators hold, degrees and
mm."""
ROUNDINGS = tuple(Rounding)
TRUNCATE, ROUND, CARRY = (ROUNDINGS.index(each) for each in (
    Rounding.TRUNCATE, Rounding.ROUND, Rounding.CARRY))
NOISE = np.array([0.006, 0.025, 0.1])
"""Noise levels: part of its way by which a wheel strays within `STRAY_WAY`, and of its changes of
speed, in seconds."""
CURVED = 0.2
"""Part of what a way may be off for its numbers that their derivatives do not tell."""
SHAPE = 0.01
"""Part of a way, for each radian of turn, by which the mean shape of the way is off."""
TICK_VARIANCE = 0.35e-3 ** 2 / 6
"""m²; counts are off the way of a wheel by parts of a tick at both ends of a window: 0.27 to
0.44 mm were seen."""
STRAY_WAY = 0.1
"""m; over longer ways the deviation grows with the root."""
LIKELY_SIGN = np.array([0.0, 1.0, 0.0, 0.0])
LIKELY_ROUNDING, LIKELY_NOISE = np.zeros(3), np.array([0.0, 0.0, -1.0])
LIKELY_ROUNDING[TRUNCATE] = 3.0
"""Logarithms of prior probabilities: encoders take the sign of the drive and fractions are cut off
(reported), wheels run steadily."""
GAIN_VARIANCE, GAIN_COVARIANCE, TURN_VARIANCE = 0.02, 0.012, 0.0005
WALK, NUMBER_WALK = 0.5, 1e-4
"""Process noise at a reading: of the gains, as a part of the squared noise level, where requests
changed by 0.1 m/s; of the numbers, as a part of `SPREAD` squared."""
FORGET = 0.99
"""Part of the logarithms of the weights that the next reading leaves."""
GATE, SLACK = 36.0, 0.2 ** 2
"""Squared standard deviations from which on a reading contradicts a filter; the variance in
degrees² and mm² that a frame which comes early or late adds."""
FREE, STRAY = 0.3 ** 2, 0.002 ** 2
"""Variance of the way of a wheel that does not follow its requests, and of one that nothing
drives, m²."""
UNKNOWN_WAY, UNKNOWN_TURN = 0.06, 0.1
"""m/s and rad/s by which the pose is doubted then: nobody knows the sign of the counts."""
TRUST, STALE, KNOWN_SPREAD = 8.0, 1.5, 0.25
"""Logarithm of how much likelier the wheels of a known robot are; the factor by which its gains
are less sure the next day; the part of `SPREAD` by which its numbers are unsure."""
EVIDENCE = 0.8
"""Part of a log-likelihood that counts: errors of a hypothesis are alike at each reading."""
LEAST_LOG, UNLIKELY = 6.0, 0.02
"""The most by which one reading may tell filters apart, as a logarithm; the probability of an
interval below which it is taken for a normal distribution."""
APART, IN_A_ROW = 0.4, 0.05
"""Seconds between two readings from which on they tell how wheels follow, and below which they
weigh nothing but the roundings."""
NEGLIGIBLE, SAVED = 6e-6, 8
"""Probability below which a hypothesis is dropped; hypotheses that are saved."""


class Motion(NamedTuple):
    """The mean motion since the last reading, in the frame of its start; m and rad."""

    x: float
    y: float
    yaw: float
    length: float
    seconds: float = 0.0


class Bank:
    """All hypotheses, and what the readings make of them."""

    def __init__(self, geometry: Geometry, robot: Knowledge | None = None) -> None:
        """Begin at the origin, with a robot that is known or not."""
        self.geometry = geometry
        known = {} if robot is None else robot.hypotheses
        self.rows = [*known, *STARTS]
        self.signs = list(SIGNS)
        self.roundings = list(ROUNDINGS)
        self.wheels = Wheels(self.rows)
        shape = (len(self.rows), len(SIGNS), len(ROUNDINGS), len(NOISE))
        prior = np.tile(np.array([0.0] * len(known) + [each.log for each in STARTS.values()])[
            :, None], len(SIGNS))
        mean, covariance = np.zeros((*shape, SIZE)), np.zeros((*shape, SIZE, SIZE))
        mean[..., :TURN] = 1.0
        mean[..., NUMBER:X] = self.wheels.numbers[:, None, None, None]
        covariance[..., :TURN, :TURN] = GAIN_COVARIANCE
        covariance[..., RIGHT, RIGHT] = covariance[..., LEFT, LEFT] = GAIN_VARIANCE
        covariance[..., TURN, TURN] = TURN_VARIANCE
        numbers = range(NUMBER, X)
        unsure = np.array([KNOWN_SPREAD] * len(known) + [each.unsure for each in STARTS.values()])
        covariance[..., numbers, numbers] = (unsure[:, None] * SPREAD)[:, None, None, None] ** 2
        sign, rounding = LIKELY_SIGN, LIKELY_ROUNDING
        if robot is not None:
            sign = np.zeros(len(SIGNS))
            for k, (row, probability) in enumerate(known.items()):
                prior[k] = TRUST - 7.0
                prior[k, SIGNS.index(row.sign)] = TRUST + np.log(max(probability, 1e-3))
            rounding = np.log([max(robot.rounding.get(each, 0.0), 1e-3) for each in ROUNDINGS])
            for state, number in ((RIGHT, robot.right_gain), (LEFT, robot.left_gain),
                                  (TURN, robot.angle_factor)):
                mean[..., state] = number.value - (state == TURN)
                covariance[..., state, :] = covariance[..., state] = 0.0
                covariance[..., state, state] = (STALE * number.deviation) ** 2 + 1e-7
        self.mean, self.covariances = mean, covariance
        """State of each filter, and its covariance."""
        self.log_weight = (prior + sign)[:, :, None, None] + rounding[:, None] + LIKELY_NOISE
        self.readings = 0
        """Readings in motion."""
        self._changed = np.zeros(2)
        """Sum of the squares of changes of the requests, m²/s²."""
        self._request = (0.0, 0.0)
        scale = geometry.angular_scale
        self._yaw = scale / FIRMWARE_SEPARATION
        self._degrees = 1 / DEGREE / FIRMWARE_SEPARATION
        self._weigh()
        self.wheels.move(self.wheels.numbers, self.means[:, :TURN])

    # Weights and means.

    def _weigh(self) -> None:
        weights = np.exp(self.log_weight - self.log_weight.max())
        self.weights = weights = weights / weights.sum()
        self.of_rows = weights.sum(axis=(1, 2, 3))
        self.rounding = dict.fromkeys(ROUNDINGS, 0.0) | dict(
            zip(self.roundings, weights.sum(axis=(0, 1, 3)).tolist()))
        """Probability of each rounding."""
        count = len(self.rows)
        shares = (weights + 1e-12).reshape(count, -1)
        shares /= shares.sum(axis=1)[:, None]
        means = self.mean[..., :X].reshape(count, -1, X)
        self.means = np.einsum('kf,kfs->ks', shares, means)
        """Mean gains and numbers of each hypothesis."""
        off = means - self.means[:, None]
        self._spread = np.einsum('kf,kfst->kst', shares, self.covariances[..., :X, :X].reshape(
            count, -1, X, X)) + np.einsum('kf,kfs,kft->kst', shares, off, off)
        self._right_share, self._left_share = (
            self.of_rows * self.means[:, wheel] * self.geometry.linear_scale
            for wheel in (RIGHT, LEFT))
        turn = self.of_rows * (1 + self.means[:, TURN]) * self._yaw
        self._right_turn, self._left_turn = turn * self.means[:, RIGHT], turn * self.means[:, LEFT]

    @property
    def pose(self) -> tuple[float, float, float]:
        """Mean pose at the last reading."""
        poses = self.mean[..., X:ANGLE].reshape(-1, 3)
        x, y, yaw = (self.weights.reshape(-1) @ poses).tolist()
        return x, y, yaw

    def motion(self, travel: Array) -> tuple[float, float]:
        """Return the mean distance, m, and turn, rad, of travels of all wheels."""
        right, left = travel[:, 0], travel[:, 1]
        return (float(self._right_share @ right + self._left_share @ left) / 2,
                float(self._right_turn @ right - self._left_turn @ left))

    # Readings.

    def roll(self, dt: float, request: tuple[float, float], *, lifted: bool = False,
             ) -> Array | None:
        """Let the wheels follow requests, m/s; return their travel; None: as in the last frame."""
        if request != self._request:
            for wheel in (0, 1):
                self._changed[wheel] += (request[wheel] - self._request[wheel]) ** 2
            self._request = request
        return self.wheels.roll(dt, request, lifted=lifted)

    def skip(self, motion: Motion) -> None:
        """Begin a new window without a reading: all poses follow the mean motion."""
        self.wheels.flush()
        self._predict(motion, 0.0)
        self._empty(np.zeros(2))
        self.covariances[..., ANGLE:, :] = self.covariances[..., :, ANGLE:] = 0.0
        self.mean[..., ANGLE:] = 0.0

    def read(self, reported: Array, motion: Motion, *, driven: bool = True, trusted: bool = True,
             lost: bool = False) -> bool:
        """
        Predict, and correct and weigh all filters by a reading, degrees and mm.

        A filter that the reading contradicts takes it that the wheels did not follow their
        requests: its pose follows the reading, and its gains and numbers hardly change. Not
        `trusted`: all filters do so. `lost`: the reading may not be whole; such filters then do
        without it. Return whether the wheels followed, most likely.
        """
        wheels = self.wheels
        wheels.flush()
        by_ways = self._predict(motion, 0.0 if driven else STRAY)
        ends = [[np.array(each)[:, None] for each in zip(*(
            interval(value, rounding) for rounding in self.roundings))]
            for value in reported.tolist()]
        outside = np.stack([np.clip(0.0, low - state, high - state) for (low, high), state in zip(
            ends, (self.mean[..., ANGLE], self.mean[..., DISTANCE]))], axis=-1)
        free = np.full(self.weights.shape, not trusted)
        if trusted:
            spread = self.covariances[..., ANGLE:, ANGLE:] + SLACK * np.eye(2)
            free = (outside * np.linalg.solve(spread, outside[..., None])[..., 0]).sum(-1) > GATE
        if free.any() and not lost:
            g = by_ways[free]
            self.covariances[free, X:, X:] += FREE * g @ g.swapaxes(-1, -2)
            doubt = (motion.seconds * np.array([UNKNOWN_WAY, UNKNOWN_WAY, UNKNOWN_TURN])) ** 2
            self.covariances[free, X:ANGLE, X:ANGLE] += np.diag(doubt)
        logs = np.zeros(self.weights.shape)
        ticks = 2 * TICK_VARIANCE * self._degrees ** 2, TICK_VARIANCE / 2 / MM ** 2
        for state, (low, high), of_ticks in zip((ANGLE, DISTANCE), ends, ticks):
            column = self.covariances[..., state].copy()
            variance = column[..., state] + of_ticks
            deviation = np.sqrt(variance)
            off = self.mean[..., state]
            shift, kept, log = _cut((low - off) / deviation, (high - off) / deviation)
            if lost:
                shift, kept = np.where(free, 0.0, shift), np.where(free, 1.0, kept)
            self.mean[:] += column * (shift / deviation)[..., None]
            self.covariances[:] -= (((1 - kept) / variance)[..., None] * column)[
                ..., None] * column[..., None, :]
            logs += log
        if trusted and (wheels.path.max() > 2e-3 or reported.any()):
            self.readings += motion.seconds > APART
            logs = np.where(free, -LEAST_LOG, np.maximum(logs, -LEAST_LOG))
            if motion.seconds < IN_A_ROW:
                shares = self.weights + 1e-12
                before, after = (each.sum(axis=(0, 1, 3), keepdims=True)
                                 for each in (shares, shares * np.exp(logs)))
                self.log_weight += EVIDENCE * np.log(after / before)
            else:
                self.log_weight[:] = FORGET * self.log_weight + EVIDENCE * logs
        self._empty(reported)
        self._weigh()
        followed = float(self.weights[free].sum()) < 0.5
        if followed and motion.seconds >= APART:
            self._prune()
            self.wheels.move(self.means[:, NUMBER:], self.means[:, :TURN])
        return followed

    def _predict(self, motion: Motion, stray: float) -> Array:
        """
        Let poses and accumulators follow the wheels since the last reading.

        Return what a metre of each wheel does to them.
        """
        wheels, scale = self.wheels, self.geometry.linear_scale
        mean, p = self.mean, self.covariances
        off = (mean[..., NUMBER:X] - wheels.numbers[:, None, None, None])[..., None, :]
        by_number = []
        ways = []
        # Ways at the numbers that each filter believes in, and their derivatives.
        for each in (wheels.true[None], wheels.counted):
            slopes = ((each[:, :, 1:] - each[:, :, :1]) / STEP[:, None]).transpose(1, 0, 3, 2)[
                :, :, None, None]
            by_number.append(slopes)
            ways.append(each[:, :, 0].transpose(1, 0, 2)[:, :, None, None] + (
                slopes * off).sum(axis=-1))
        (true, counted), (d_true, d_counted) = ways, by_number
        way = wheels.path[:, 0][:, None, None, None]
        noise = NOISE[:, None] ** 2 * (
            way * np.minimum(way, STRAY_WAY) + self._changed) + stray + 1e-9
        variances = p[..., range(NUMBER, X), range(NUMBER, X)][..., None, :]
        noise = noise + CURVED ** 2 * (d_true ** 2 * variances).sum(axis=-1)
        # What a metre of each wheel does: turn, rad; distance, m; degrees; mm.
        angle = (1 + mean[..., TURN, None]) * [1.0, -1.0]
        d_turn, d_angle = angle * self._yaw, angle * self._degrees
        yaw, gains = mean[..., YAW], mean[..., :TURN]
        turn, far = (d_turn * gains * true).sum(-1), (gains * true).sum(-1) * (scale / 2)
        heading, middle = yaw + (turn - motion.yaw) / 2, yaw + turn / 2
        cos, sin = np.cos(heading), np.sin(heading)
        ahead_x, ahead_y = np.cos(middle), np.sin(middle)
        dx = cos * motion.x - sin * motion.y + (far - motion.length) * ahead_x
        dy = sin * motion.x + cos * motion.y + (far - motion.length) * ahead_y
        # The same for x, y, yaw, degrees and mm: by noise of the ways, rows; columns both wheels.
        g = np.empty((*mean.shape[:-1], 5, 2))
        g[..., 0, :] = (ahead_x * scale / 2)[..., None] - (dy / 2)[..., None] * d_turn
        g[..., 1, :] = (ahead_y * scale / 2)[..., None] + (dx / 2)[..., None] * d_turn
        g[..., 2, :], g[..., 3, :], g[..., 4, :] = d_turn, d_angle, 1 / (2 * MM)
        f_ = np.zeros((*mean.shape[:-1], 5, SIZE))
        f_[..., range(5), range(X, SIZE)] = 1.0
        f_[..., :3, :TURN] = g[..., :3, :] * true[..., None, :]
        f_[..., 3:, :TURN] = g[..., 3:, :] * counted[..., None, :]
        of_ways = g * gains[..., None, :]
        f_[..., :3, NUMBER:X] = of_ways[..., :3, :] @ d_true
        f_[..., 3:, NUMBER:X] = of_ways[..., 3:, :] @ d_counted
        f_[..., 0, YAW], f_[..., 1, YAW] = -dy, dx
        of_turn = turn / (1 + mean[..., TURN])
        f_[..., 0, TURN], f_[..., 1, TURN], f_[..., 2, TURN] = (
            -dy / 2 * of_turn, dx / 2 * of_turn, of_turn)
        degrees = (d_angle * gains * counted).sum(-1)
        f_[..., 3, TURN] = degrees / (1 + mean[..., TURN])
        rows = f_ @ p
        p[..., X:, :] = rows
        p[..., :, X:] = rows.swapaxes(-1, -2)
        p[..., X:, X:] = rows @ f_.swapaxes(-1, -2) + (
            g * noise[..., None, :]) @ g.swapaxes(-1, -2)
        # What only the pose or only the counts have: slip; counts of a sign that is not sure.
        unsure = (wheels.unsure[:, :, 0] ** 2).transpose(1, 0, 2)[:, :, None, None, None]
        slip = self.geometry.slip ** 2 * way[..., None, :]
        for part, states, variance in ((g[..., :3, :], slice(X, ANGLE), unsure + slip),
                                       (g[..., 3:, :], slice(ANGLE, SIZE), unsure)):
            p[..., states, states] += (part * variance) @ part.swapaxes(-1, -2)
        p[..., [X, Y], [X, Y]] += (SHAPE * motion.length * motion.yaw) ** 2
        mean[..., X] += dx
        mean[..., Y] += dy
        mean[..., YAW] += turn
        mean[..., ANGLE] += degrees
        mean[..., DISTANCE] += (gains * counted).sum(-1) / (2 * MM)
        return g

    def _empty(self, reported: Array) -> None:
        """Empty the accumulators of filters whose robots lose fractions; let the gains walk."""
        mean, p = self.mean, self.covariances
        for i, each in enumerate(self.roundings):
            if each is Rounding.CARRY:
                mean[:, :, i, :, ANGLE:] -= reported
            else:
                mean[:, :, i, :, ANGLE:] = 0.0
                p[:, :, i, :, ANGLE:, :] = 0.0
                p[:, :, i, :, :, ANGLE:] = 0.0
        walk = np.zeros((len(NOISE), X))
        walk[:, :TURN] = (WALK * NOISE ** 2 * min(1.0, float(self._changed.max()) / 0.01))[:, None]
        walk[:, NUMBER:] = NUMBER_WALK * SPREAD ** 2
        p[..., range(X), range(X)] += walk + 1e-9
        np.clip(mean[..., :TURN], 0.3, 2.0, out=mean[..., :TURN])
        np.clip(mean[..., TURN], -0.2, 0.2, out=mean[..., TURN])
        np.clip(mean[..., NUMBER:X], LOWEST, HIGHEST, out=mean[..., NUMBER:X])
        self._changed[:] = 0.0
        self.wheels.begin_window()

    def _prune(self) -> None:
        """Drop hypotheses, sources of signs and roundings that readings rule out."""
        rows, signs, roundings = (
            np.flatnonzero(self.weights.sum(axis=others) > NEGLIGIBLE)
            for others in ((1, 2, 3), (0, 2, 3), (0, 1, 3)))
        if self.weights.shape[:3] == (len(rows), len(signs), len(roundings)):
            return
        self.rows = [self.rows[i] for i in rows]
        self.signs = [self.signs[i] for i in signs]
        self.roundings = [self.roundings[i] for i in roundings]
        self.wheels.keep(rows, signs)
        kept = np.ix_(rows, signs, roundings)
        self.mean, self.covariances = self.mean[kept], self.covariances[kept]
        self.log_weight = self.log_weight[kept]
        self._weigh()

    # What is known.

    @property
    def knowledge(self) -> Knowledge:
        """What was learned of the robot."""
        of_signs = self.weights.sum(axis=(2, 3))
        order = np.argsort(-of_signs, axis=None)[:SAVED]
        share = float(of_signs.reshape(-1)[order].sum())
        hypotheses: dict[Hypothesis, float] = {}
        for k, s in zip(*np.unravel_index(order, of_signs.shape)):
            row = with_numbers(self.rows[k], self.means[k, NUMBER:].tolist(), self.signs[s])
            hypotheses[row] = hypotheses.get(row, 0.0) + float(of_signs[k, s]) / share
        w = self.of_rows
        mean = w @ self.means
        variance = w @ ((self.means - mean) ** 2 + self._spread.diagonal(axis1=1, axis2=2))
        right, left, turn = (Known(*each) for each in zip(
            mean.tolist()[:NUMBER], np.sqrt(variance).tolist()))
        return Knowledge(
            hypotheses=hypotheses,
            rounding=self.rounding, right_gain=right,
            left_gain=left, angle_factor=Known(1 + turn.value, turn.deviation),
            readings=self.readings)

    def reset(self, pose: tuple[float, float, float]) -> None:
        """Begin again at a pose; what was learned of the robot stays."""
        mean, p = self.mean, self.covariances
        mean[..., X:ANGLE] = pose
        p[..., X:ANGLE, :] = 0.0
        p[..., :, X:ANGLE] = 0.0

    # How sure it is.

    def shift(self, x: float, y: float, yaw: float) -> None:
        """Move the poses of all filters."""
        self.mean[..., X:ANGLE] += x, y, yaw

    @property
    def covariance(self) -> Array:
        """Covariance of x, y, yaw at the last reading."""
        w = self.weights.reshape(-1)
        poses = self.mean[..., X:ANGLE].reshape(-1, 3)
        off = poses - w @ poses
        within = (w @ self.covariances[..., X:ANGLE, X:ANGLE].reshape(-1, 9)).reshape(3, 3)
        covariance: Array = (off * w[:, None]).T @ off + within
        return covariance

    def growth(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """
        Return how unsure the motion is: since the last reading, and at present.

        Variances of distance, m², and turn, rad²; of speed, m²/s², and turn rate, rad²/s².
        """
        wheels, w = self.wheels, self.of_rows
        wheels.flush()
        ways = np.stack([wheels.true[:, 0], wheels.speed[:, 0]])
        path = float(w @ wheels.path[:, 0].sum(axis=1))
        noise = self.weights.sum(axis=(0, 1, 2)) @ NOISE ** 2 * np.array([
            path * min(path, STRAY_WAY) + float(self._changed.sum()), 0.1 * float(
                w @ (ways[1] ** 2).sum(axis=1))])
        each = ways * self.means[:, :TURN]
        far, turn = each.sum(axis=-1) / 2, (each[..., 0] - each[..., 1]) * self._yaw
        slopes = (wheels.true[:, 1:] - wheels.true[:, :1]) / STEP[:, None]
        row = np.concatenate([ways[0] * [1.0, -1.0], ways[0, :, :1] - ways[0, :, 1:],
                              slopes[..., 0] - slopes[..., 1]], axis=1)
        learned = float(w @ np.einsum('ks,kst,kt->k', row, self._spread, row)) * self._yaw ** 2
        far, turn = ((each - (each @ w)[:, None]) ** 2 @ w for each in (far, turn))
        far, turn = far + noise / 2 + 1e-8, turn + noise * self._yaw ** 2 + 1e-8
        return ((float(far[0]), float(turn[0]) + learned), (float(far[1]), float(turn[1])))


def interval(value: float, rounding: Rounding) -> tuple[float, float]:
    """Return between what an accumulator was when it was read as a whole number."""
    if rounding is Rounding.ROUND:
        return value - 0.5, value + 0.5
    return value - (value <= 0), value + (value >= 0)


def _cut(low: Array, high: Array) -> tuple[Array, Array, Array]:
    """
    Cut standard normal distributions to intervals.

    Return the means, the variances, and the logarithms of the probabilities.
    """
    probability = _cumulative(high) - _cumulative(low)
    beyond = np.maximum(np.maximum(low, -high), 0.0)
    density_low, density_high = (np.exp(-0.5 * np.minimum(x * x, 700.0)) * 0.3989423
                                 for x in (low, high))
    z = np.maximum(probability, UNLIKELY)
    mean = (density_low - density_high) / z
    kept = 1 + (low * density_low - high * density_high) / z - mean * mean
    # Far outside the interval a normal distribution of its width stands for it.
    width, far = (high - low) ** 2 / 12, probability < UNLIKELY
    centre = (low + high) / 2
    mean = np.where(far, centre / (1 + width), mean)
    kept = np.where(far, width / (1 + width), np.clip(kept, 0.0, 1.0))
    log = np.where(far, np.log(UNLIKELY) - 0.5 * (beyond ** 2 - 4.0), np.log(z))
    return mean, kept, log


def _cumulative(x: Array) -> Array:
    """Return the standard normal distribution function, to 3e-4."""
    x = np.clip(x, -10.0, 10.0)
    y: Array = 0.5 + 0.5 * np.tanh(0.7978846 * x * (1 + 0.044715 * x * x))
    return y
