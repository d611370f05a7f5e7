# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The filters: what the robot's pose and its wheels may be, corrected by each reading.

One extended Kalman filter for each rounding, source of signs and level of trust in the wheels.
All have the same wheel model. The levels are weighed as an interacting multiple model: wheels that
stop to follow are noticed by the next reading, and trusted again some readings later. The letters
are those of docs/odometry.md.
"""

from dataclasses import dataclass, field
from math import cos, exp, log, sin
from typing import NamedTuple

import numpy as np

from ..robot import FIRMWARE_SEPARATION, MILLI, Rounding
from .estimate import Geometry, Knowledge, Known, KnownGyro, SignSource
from .gyro import Gyro
from .wheels import Array, SIGNS, Speeds, Wheels

DEGREE = np.pi / 180
(RIGHT, LEFT, COUNTS, LAG, POWER, ACCELERATION, BRAKING, DEAD, STRAY_RIGHT, STRAY_LEFT, ZERO,
 SCALE, BEFORE, X, Y, YAW, WAY, TURN, ANGLE, DISTANCE, SIZE) = range(21)
"""The state: gains g of both wheels; u, by which angles are counted too large; the model's five
numbers; e, the m/s by which each wheel strays; zero, V, and scale, a part, of a gyro; the yaw at
the last reading; the pose; the trip; what the accumulators of packets 20 and 19 hold, degrees and
mm."""
NUMBERS, STRAY = slice(LAG, STRAY_RIGHT), slice(STRAY_RIGHT, ZERO)
POSE, MOVED, HELD = slice(X, WAY), slice(X, ANGLE), slice(ANGLE, SIZE)
ROUNDINGS, SOURCES = tuple(Rounding), tuple(SignSource)

USUAL = np.array([log(0.13), 0.7, log(2.0), 0.0, 0.04])
USUAL_SPREAD = np.array([0.5, 0.3, 0.8, 0.35, 0.03])
LOWEST = np.array([log(0.01), 0.0, log(0.2), log(0.25), 0.0])
HIGHEST = np.array([log(0.6), 1.0, log(30.0), log(4.0), 0.2])
"""ln T, p, ln a, ln b, d of a robot that nobody knows, their deviations and limits (evidence: C1
coasts 15 mm from 0.1 m/s, ranges of docs/simulator.md)."""
GAIN, GAIN_TOGETHER, COUNTED = 0.02 ** 0.5, 0.012 ** 0.5, 0.0005 ** 0.5
"""Deviations of a gain, of what both have in common, of u (evidence: C1 0.95 to 1.05, C2 0.73 to
1.37; a track of 250 to 266 mm)."""
CHANCES, SIGN_CHANCES = np.array([2.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0, 2.0])
"""ln of how much likelier a rounding is (evidence: two reports that C1 truncates; tried: 3 is too
much for robots that carry), and a source of signs (evidence: C2's drive; tried: to believe in the
motion at first does least harm)."""
UNLEARNED = 1e-3
"""Least probability of what a file rules out, so that another robot is learned."""
STALE = 1.5
"""Factor of a file's deviations: a battery and a floor change (tried: 1 trusts too much)."""


class Level(NamedTuple):
    """How well wheels follow the model."""

    first: float
    """Probability at the start."""
    redrawn: float
    """e, as a part of the speed, after a change of the request."""
    walk: float
    """m/s by which e walks in a root second."""
    way: float
    """Part of the way within `EVEN_WAY` that is not sure."""
    change: float
    """Seconds by which a change of speed may be late or early."""
    fallen: float
    """m/s of e in a robot that has just come to this level."""
    wrong: float
    """Part of what is counted with a wrong sign that is not sure."""


LEVELS = (Level(0.6, 0.003, 0.0001, 0.006, 0.015, 0.001, 0.1),
          Level(0.3, 0.05, 0.002, 0.05, 0.05, 0.004, 0.2),
          Level(0.1, 1.0, 0.01, 0.1, 0.2, 0.3, 2.0))
"""Logs of C2 lie between the first two; the third believes only readings (tried: without the first
three times as far off where wheels follow; a fourth that runs at another speed: no better)."""
FREE = len(LEVELS) - 1
BECOMES = np.array([[0.97, 0.015, 0.015], [0.015, 0.97, 0.015], [0.05, 0.1, 0.85]])
"""Probabilities that a level becomes another in a second (tried)."""
KEEPS = np.array([[1, 1, 0], [1, 1, 0], [0, 0, 0]], bool)
"""Whether e stays; in the last level, and after it, it is drawn anew."""

EVEN_WAY = 0.1
"""Metres within which errors of a way add up (a turn of the wheel is 0.2 m)."""
SLOW, SLOW_PART = 0.026, 1.0
"""m/s below which a request may move nothing (evidence: dead bands to 25 mm/s), and the part of
its way that is not sure then."""
SAME = 0.015
"""m/s; a request that stays within it is the same: who steers along a line corrects always."""
TICK = (0.35 * MILLI) ** 2 / 6
"""m²: variance of a count (evidence: ticks of 0.27 to 0.44 mm)."""
WALK, NUMBERS_WALK = 1e-7, 1e-4
"""Variance by which gains walk with each reading, and part of that of the numbers (tried)."""
BENT = 0.01
"""Part of way times turn by which a way is off where it is taken for an arc."""
OF_ROUNDING, OF_SOURCE, IN_A_ROW = 0.2, 0.5, 0.8
"""Parts of a reading's evidence that count: errors of the model are alike at each reading. Of
readings in a row, which tell only of rounding, most does."""
NEXT = 0.15
"""Seconds: readings that are not farther apart are in a row."""
LEAST_LOG = 6.0
"""No reading counts as more evidence than that: it may be damaged."""
NOT_FOLLOWED = 1e-3
"""Probability of a reading from which on it contradicts the wheels."""
UNLIKELY = 0.02
"""Probability of an interval below which the sums of `cut` lose their digits."""
ZERO_WALK = 1e-9
"""V² by which a gyro's zero walks in a second (evidence: 0.02 degrees a second in a minute)."""


@dataclass
class Window:
    """What happened since the last reading, as the mean of all filters has it."""

    near: Speeds = (0.0, 0.0)
    """The request that e belongs to."""
    seconds: float = 0.0
    rolling: float = 0.0
    """Seconds in which the wheels turned."""
    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0
    way: float = 0.0
    """Motion in the frame of the window's start: m, rad, and the length of the way."""
    kept: bool = True
    """Whether the wheels still stray as at the start."""
    strayed: float = 0.0
    """Seconds for which they did."""
    fresh: list[list[list[float]]] = field(default_factory=lambda: [
        [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]] for _ in range(2)])
    """What new strays have made: variance of e, its covariance with the way, variance of the way,
    each of both wheels; for a level of 1, and of slow requests."""

    def step(self, dt: float, *, rolling: bool) -> None:
        """Let a frame pass."""
        self.seconds += dt
        self.rolling += dt * rolling
        self.strayed += dt * self.kept
        for e, both, way in self.fresh:
            for i in (0, 1):
                way[i] += (2 * both[i] + e[i] * dt) * dt
                both[i] += e[i] * dt

    def change(self, request: Speeds) -> None:
        """Draw e anew where a request is another than those near it."""
        near = self.near
        if all(request) == all(near) and max(
                abs(now - then) for now, then in zip(request, near)) < SAME:
            return
        self.near, self.kept = request, False
        fastest = max(map(abs, (*request, *near)))
        for i, asked in enumerate(request):
            slow = SLOW_PART * asked if abs(asked) < SLOW else 0.0
            for (e, both, _), stray in zip(self.fresh, (fastest if asked else 0.0, slow)):
                e[i], both[i] = stray ** 2, 0.0

    def advance(self, far: float, turn: float) -> None:
        """Let the mean go on along an arc."""
        middle = self.turn + turn / 2
        self.x += far * cos(middle)
        self.y += far * sin(middle)
        self.turn += turn
        self.way += far


class Filters:
    """All filters; arrays begin with them."""

    def __init__(self, geometry: Geometry, robot: Knowledge | None) -> None:
        self._geometry = geometry
        rounding, source = CHANCES, SIGN_CHANCES
        first = np.array([level.first for level in LEVELS])
        numbers, spread = USUAL, USUAL_SPREAD
        self.readings = 0
        if robot is not None:
            rounding = np.log([max(robot.rounding[each], UNLEARNED) for each in ROUNDINGS])
            source = np.log([max(robot.encoder_sign[each], UNLEARNED) for each in SOURCES])
            numbers, spread = robot.numbers
            spread, self.readings = STALE * spread, robot.readings
        self.weights = np.exp(rounding)[:, None, None] * np.exp(source)[:, None] * first
        self.weights /= self.weights.sum()
        shape = self.weights.shape
        self._rounding, self._source, self._level = (
            each.ravel() for each in np.indices(shape))
        self._squared = Level(*(np.square(each)[self._level][:, None] for each in zip(*LEVELS)))
        self._free = self._level == FREE
        n = self.weights.size
        self.mean, self.p = np.zeros((n, SIZE)), np.zeros((n, SIZE, SIZE))
        self.mean[:, :COUNTS], self.mean[:, NUMBERS] = 1.0, numbers
        self.p[:, :COUNTS, :COUNTS] = GAIN_TOGETHER ** 2
        known = [GAIN, GAIN, COUNTED, *spread]
        if robot is not None:
            gains = robot.right_gain, robot.left_gain, robot.angle_factor
            self.mean[:, :LAG] = [each.value for each in gains] - np.array([0.0, 0.0, 1.0])
            self.p[:, :COUNTS, :COUNTS] = 0.0
            known[:LAG] = [STALE * each.deviation for each in gains]
        self.p[:, range(STRAY_RIGHT), range(STRAY_RIGHT)] = np.array(known) ** 2
        self.wheels = Wheels(np.array(numbers))
        self.followed = True
        """Whether the last reading was one that wheels can have made that follow."""
        self._merge()

    def begin(self) -> None:
        """Begin a window with the mean of all filters."""
        self.mean[:, BEFORE] = self.mean[:, YAW]
        self.p[:, BEFORE] = self.p[:, YAW]
        self.p[:, :, BEFORE] = self.p[:, :, YAW]
        self.wheels.begin()
        self._merge()
        self.wheels.set_numbers(self._all[NUMBERS].copy())

    def _merge(self) -> None:
        """Work out mean and covariance of all filters, and what is believed of each level."""
        w = self.weights.ravel()
        self._all: Array = w @ self.mean
        off = self.mean - self._all
        self._covariance: Array = np.einsum('f,fij->ij', w, self.p) + (off * w[:, None]).T @ off
        self._levels: list[float] = self.weights.sum((0, 1)).tolist()
        self._mean_level = Level(*(
            float(np.dot(self._levels, np.square(each))) for each in zip(*LEVELS)))
        self.rounding: list[float] = self.weights.sum((1, 2)).tolist()
        self._believed: list[float] = self._all.tolist()
        x, y, self.yaw = self._believed[POSE]
        self.pose = x, y, self.yaw
        self.trip = self._believed[WAY], self._believed[TURN]

    def _known(self, state: int) -> Known:
        return Known(self._believed[state], float(self._covariance[state, state]) ** 0.5)

    @property
    def gyro(self) -> tuple[Known, Known]:
        """A gyro's zero, V, and the part by which its scale is wrong."""
        return self._known(ZERO), self._known(SCALE)

    def knowledge(self, gyro: KnownGyro | None) -> Knowledge:
        """Return what was learned of the robot."""
        t, a, b = (Known(exp(each.value), exp(each.value) * each.deviation)
                   for each in map(self._known, (LAG, ACCELERATION, BRAKING)))
        counts = self._known(COUNTS)
        return Knowledge(
            rounding=dict(zip(ROUNDINGS, self.rounding)),
            encoder_sign=dict(zip(SOURCES, self.weights.sum((0, 2)).tolist())),
            right_gain=self._known(RIGHT), left_gain=self._known(LEFT),
            angle_factor=Known(1 + counts.value, counts.deviation), lag=t,
            lag_power=self._known(POWER), acceleration=a, braking=b,
            dead_time=self._known(DEAD), readings=self.readings, gyro=gyro)

    # What is believed of the motion now.

    @property
    def _stands(self) -> bool:
        return not self.wheels.moving and self._levels[FREE] < 0.5

    def motion(self, ways: Speeds, dt: float, *, kept: bool) -> tuple[float, float]:
        """Return the distance and the turn in a frame in which wheels rolled as modelled."""
        m, free, g = self._believed, self._levels[FREE], self._geometry
        if self._stands:
            return 0.0, 0.0
        right, left = (m[RIGHT + i] * ways[i] + m[STRAY_RIGHT + i] * dt * (
            free + (1 - free) * kept) for i in (0, 1))
        return (g.linear_scale * (right + left) / 2,
                g.angular_scale * (1 + m[COUNTS]) * (right - left) / FIRMWARE_SEPARATION)

    def grown(self, window: Window, by_gyro: float | None = None,
              ) -> tuple[list[list[float]], Speeds, Speeds]:
        """
        Return covariances of what moved, variances of the twist, deviations of the window.

        `by_gyro` is the variance of a turn that a gyro feels.
        """
        w, s, b = self.wheels, window.seconds, FIRMWARE_SEPARATION
        c, sn = cos(self.yaw), sin(self.yaw)
        wx, wy = c * window.x - sn * window.y, sn * window.x + c * window.y
        gains, free = self._all[:COUNTS], self._levels[FREE]
        far_turn = np.array([[0.5, 0.5], [1 / b, -1 / b]])
        both = []
        for ways, slopes, strayed in (
                (w.way[0], w.slopes()[0], (1 - free) * window.strayed + free * s),
                (w.speed[0], w.speed_slopes(), float(not self._stands))):
            by = np.zeros((2, X))
            by[0, RIGHT], by[1, LEFT] = ways
            by[:, NUMBERS] = (slopes * gains).T
            by[0, STRAY_RIGHT] = by[1, STRAY_LEFT] = strayed
            both.append(far_turn @ by)
        way, twist = both
        way[1, COUNTS] += window.turn
        walked = window.rolling + free * (s - window.rolling)
        e, _, of_ways = self._noise(window, self._mean_level, walked)
        noise = (far_turn * of_ways) @ far_turn.T
        p = self._covariance
        if by_gyro is not None:
            way[1], noise[1], noise[:, 1] = 0.0, 0.0, 0.0
            noise[1, 1] = by_gyro
        middle = self.yaw + window.turn / 2
        g = np.array([[cos(middle), -wy / 2], [sin(middle), wx / 2],
                      [0.0, 1.0], [1.0, 0.0], [0.0, 1.0]])
        f = np.zeros((5, ANGLE))
        f[:, :X] = g @ way
        f[range(5), range(X, ANGLE)] = 1.0
        f[0, YAW], f[1, YAW] = -wy, wx
        moved = f @ p[:ANGLE, :ANGLE] @ f.T + g @ noise @ g.T
        window_p = np.diag(way @ p[:X, :X] @ way.T + noise)
        new = 0.0 if self._stands else e.sum()
        twists = np.diag(twist @ p[:X, :X] @ twist.T) + [new / 4, new / b ** 2]
        return (moved.tolist(), tuple((twists + 1e-8).tolist()),
                tuple(np.sqrt(window_p).tolist()))

    def _noise(self, window: Window, level: Level, walked: Array | float,
               strayed: Array | float = 0.0) -> tuple[Array, Array, Array]:
        """
        Return variances of new e, its covariances with the ways, variances of the ways.

        The level has squares; e has walked for so many seconds, and made so many metres.
        """
        path, t = self.wheels.path + strayed, walked
        unit, slow = np.array(window.fresh)
        e, both, way = (level.redrawn * unit[i] + slow[i] + level.walk * each
                        for i, each in enumerate((t, t * t / 2, t * t * t / 3)))
        way = (way + level.way * path * np.minimum(path, EVEN_WAY)
               + level.change * np.square(self.wheels.varied) + 1e-9)
        return e, both, way

    # Readings.

    def advance(self, window: Window, *, doubted: bool = False) -> None:
        """Go on to the end of a window. `doubted`: nobody requested the way."""
        self._mix(min(1.0, window.seconds))
        if doubted:
            self.weights[..., :FREE] *= NOT_FOLLOWED
            self.weights /= self.weights.sum()
        if not window.rolling:  # wheels that stand do not stray
            stands = ~self._free
            self.mean[stands, STRAY] = 0.0
            self.p[stands, STRAY, :] = self.p[stands, :, STRAY] = 0.0
        self._predict(window)

    def take(self, reading: tuple[int, int] | None, seconds: float, *, lost: bool = False) -> None:
        """
        Learn from a reading, degrees and mm, so long after the last; None: nothing can be learned.

        `lost`: a part of it may be lost.
        """
        emptied = self._rounding != ROUNDINGS.index(Rounding.CARRY)
        if reading is not None and self._take_reading(
                np.array(reading, float), quick=seconds < NEXT, lost=lost):
            self.mean[:, HELD] -= reading
        else:  # how much was lost is not known: nothing of it may be left
            emptied[:] = True
        self.mean[emptied, HELD] = 0.0
        self.p[emptied, HELD, :] = self.p[emptied, :, HELD] = 0.0
        self._keep_in_range()

    def start_trip(self) -> None:
        """Let nothing of before correct the trip from here on."""
        self.mean[:, WAY:ANGLE] = self.trip
        self.p[:, WAY:ANGLE, :] = self.p[:, :, WAY:ANGLE] = 0.0
        self._merge()

    def place(self, x: float, y: float, yaw: float) -> None:
        """Say for certain where the robot is at the start of the window."""
        self.mean[:, BEFORE:WAY] = yaw, x, y, yaw
        self.p[:, BEFORE:WAY, :] = self.p[:, :, BEFORE:WAY] = 0.0
        self._merge()

    @property
    def held(self) -> tuple[float, float]:
        """What the accumulators hold, degrees and mm."""
        angle, distance = (self.weights.ravel() @ self.mean[:, HELD]).tolist()
        return angle, distance

    def shift(self, change: Array, variance: Array) -> None:
        """Move all by X to TURN, whose variances are added: nobody saw how."""
        self.mean[:, MOVED] += change
        self.p[:, range(X, ANGLE), range(X, ANGLE)] += variance

    def _keep_in_range(self) -> None:
        m = self.mean
        m[:, :COUNTS] = np.clip(m[:, :COUNTS], 0.2, 2.0)
        m[:, COUNTS] = np.clip(m[:, COUNTS], -0.2, 0.2)
        m[:, NUMBERS] = np.clip(m[:, NUMBERS], LOWEST, HIGHEST)
        m[:, STRAY] = np.clip(m[:, STRAY], -0.6, 0.6)

    def _mix(self, seconds: float) -> None:
        """Let levels become others: each goes on with the mean of those that became it."""
        levels = len(LEVELS)
        w = self.weights.reshape(-1, levels)
        one = np.eye(levels)
        becomes = one + (BECOMES - one) * seconds
        after = w @ becomes
        share = becomes * w[:, :, None] / (after[:, None] + 1e-300)
        m = np.repeat(self.mean.reshape(-1, levels, 1, SIZE), levels, axis=2)
        p = np.repeat(self.p.reshape(-1, levels, 1, SIZE, SIZE), levels, axis=2)
        for was, now in zip(*np.nonzero(~KEEPS)):
            m[:, was, now, STRAY] = 0.0
            p[:, was, now, STRAY, :] = p[:, was, now, :, STRAY] = 0.0
            p[:, was, now, range(STRAY_RIGHT, ZERO), range(STRAY_RIGHT, ZERO)] = (
                LEVELS[now].fallen ** 2)
        mean = np.einsum('aij,aijn->ajn', share, m)
        off = m - mean[:, None]
        p += off[..., None] * off[..., None, :]
        self.mean = mean.reshape(-1, SIZE)
        self.p = np.einsum('aij,aijnm->ajnm', share, p).reshape(-1, SIZE, SIZE)
        self.weights = after.reshape(self.weights.shape)

    def _predict(self, window: Window) -> None:
        """Let all move to the end of a window."""
        g, w, s = self._geometry, self.wheels, window.seconds
        m, free = self.mean, self._free[:, None]
        strayed, kept = np.where(free, s, window.strayed), np.where(free, 1.0, window.kept)
        learned = m[:, NUMBERS] - w.numbers
        d_way, d_wrong = w.slopes()
        wrong = np.concatenate([w.wrong[:, 0], np.zeros((1, 2))])
        source = np.where(self._free, SIGNS, self._source)
        d_counted = d_way - 2 * d_wrong[source]
        rolled = w.way[0] + learned @ d_way
        counted = w.way[0] - 2 * wrong[source] + np.einsum('fk,fki->fi', learned, d_counted)
        gains, e, counts = m[:, :COUNTS], m[:, STRAY], 1 + m[:, COUNTS]
        way, counted_way = gains * rolled + strayed * e, gains * counted + strayed * e
        by_angle = counts[:, None] * np.array([1.0, -1.0]) / (FIRMWARE_SEPARATION * DEGREE)
        by_turn = by_angle * (DEGREE * g.angular_scale)
        turn, far = (by_turn * way).sum(-1), g.linear_scale * way.sum(-1) / 2
        off = turn - window.turn
        head, middle = m[:, YAW] + off / 2, m[:, YAW] + turn / 2
        c, sn, along, aside = np.cos(head), np.sin(head), np.cos(middle), np.sin(middle)
        dx = c * window.x - sn * window.y + (far - window.way) * along
        dy = sn * window.x + c * window.y + (far - window.way) * aside
        by = np.empty((len(m), SIZE - X, 2))  # derivatives of the moved and the held by the ways
        by[:, 0] = (along * g.linear_scale / 2)[:, None] - (dy / 2)[:, None] * by_turn
        by[:, 1] = (aside * g.linear_scale / 2)[:, None] + (dx / 2)[:, None] * by_turn
        by[:, 2] = by[:, 4] = by_turn
        by[:, 3] = g.linear_scale / 2
        by[:, 5], by[:, 6] = by_angle, 0.5 / MILLI
        f = np.zeros_like(self.p)
        f[:, range(SIZE), range(SIZE)] = 1.0
        true, held = by[:, :5], by[:, 5:]
        f[:, MOVED, :COUNTS] = true * rolled[:, None]
        f[:, HELD, :COUNTS] = held * counted[:, None]
        by_gain = by * gains[:, None]
        f[:, MOVED, NUMBERS] = by_gain[:, :5] @ d_way.T
        f[:, HELD, NUMBERS] = by_gain[:, 5:] @ d_counted.transpose(0, 2, 1)
        f[:, X:, STRAY] = by * strayed[:, None]
        f[:, [STRAY_RIGHT, STRAY_LEFT], [STRAY_RIGHT, STRAY_LEFT]] = kept
        f[:, X, YAW], f[:, Y, YAW] = -dy, dx
        angle = (by_angle * counted_way).sum(-1)
        of_turn = turn / counts
        f[:, X, COUNTS], f[:, Y, COUNTS] = -dy / 2 * of_turn, dx / 2 * of_turn
        f[:, YAW, COUNTS] = f[:, TURN, COUNTS] = of_turn
        f[:, ANGLE, COUNTS] = angle / counts
        self.p = f @ self.p @ f.transpose(0, 2, 1)
        self._add_noise(window, by, wrong, strayed * e)
        m[:, X] += dx
        m[:, Y] += dy
        m[:, YAW] += turn
        m[:, WAY] += far
        m[:, TURN] += turn
        m[:, ANGLE] += angle
        m[:, DISTANCE] += counted_way.sum(-1) / (2 * MILLI)
        m[:, STRAY] *= kept

    def _add_noise(self, window: Window, by: Array, wrong: Array, strayed: Array) -> None:
        """Add what the model does not tell."""
        p, path = self.p, self.wheels.path
        walked = np.where(self._free, window.seconds, window.rolling)[:, None]
        e, both, way = self._noise(window, self._squared, walked, np.abs(strayed))
        p[:, X:, X:] += (by * way[:, None]) @ by.transpose(0, 2, 1)
        cross = by * both[:, None]
        p[:, X:, STRAY] += cross
        p[:, STRAY, X:] += cross.transpose(0, 2, 1)
        p[:, [STRAY_RIGHT, STRAY_LEFT], [STRAY_RIGHT, STRAY_LEFT]] += e
        unsure = self._squared.wrong * np.square(wrong[self._source])
        slips = self._geometry.slip ** 2 * path
        for states, part, variance in (
                (MOVED, by[:, :5], unsure + slips), (HELD, by[:, 5:], unsure)):
            p[:, states, states] += (part * variance[:, None]) @ part.transpose(0, 2, 1)
        p[:, [X, Y], [X, Y]] += (BENT * window.way * window.turn) ** 2
        p[:, range(LAG), range(LAG)] += WALK
        p[:, range(LAG, STRAY_RIGHT), range(LAG, STRAY_RIGHT)] += (
            NUMBERS_WALK * np.square(USUAL_SPREAD))

    def take_turn(self, gyro: Gyro, window: Window) -> None:
        """Learn from a gyro's turn: a row of yaw now, yaw before, zero and scale."""
        felt, w = gyro.felt, self.weights.ravel()
        volts = felt.volts - self.mean[:, ZERO] * felt.seconds
        turned = gyro.scale * (1 + self.mean[:, SCALE]) * volts
        zero, scale = gyro.scale * felt.seconds, float(gyro.scale * (w @ volts))
        row = np.zeros(SIZE)
        row[[YAW, BEFORE, ZERO, SCALE]] = 1.0, -1.0, zero, -scale
        self.p[:, ZERO, ZERO] += ZERO_WALK * felt.seconds
        column = self.p @ row
        variance = column @ row + gyro.scale ** 2 * felt.variance
        wheels = self.mean[:, YAW] - self.mean[:, BEFORE]
        off = turned - wheels
        middle = float(w @ off)
        verdict = gyro.judge(float(w @ wheels), float(w @ turned),
                             float(w @ (variance + (off - middle) ** 2)))
        yaw = self.yaw
        c, sn = np.cos(yaw), np.sin(yaw)
        slip = np.zeros(SIZE)
        slip[[X, Y, YAW, TURN]] = (-(sn * window.x + c * window.y) / 2,
                                   (c * window.x - sn * window.y) / 2, 1.0, 1.0)
        variance = variance + verdict.slip
        if verdict.corrects:
            self.p += verdict.slip * np.outer(slip, slip)
            column = column + verdict.slip * slip
        gain = column / variance[:, None]
        if not verdict.teaches:
            gain[:, :X] = gain[:, ANGLE:] = 0.0
        if not gyro.tells_scale(float(w @ turned)):
            gain[:, SCALE] = 0.0
        if not verdict.corrects:
            gain[:, :ZERO] = gain[:, BEFORE:] = 0.0
        self.mean += gain * off[:, None]
        both = gain[:, :, None] * column[:, None]
        self.p += (gain[:, :, None] * gain[:, None] * variance[:, None, None]
                   - both - both.transpose(0, 2, 1))

    def begin_gyro(self, zero: Known, scale_error: Known) -> None:
        """Begin with a gyro's zero, V, and the part by which its scale is wrong."""
        self.p[:, ZERO:BEFORE, :] = self.p[:, :, ZERO:BEFORE] = 0.0
        for state, (value, deviation) in ((ZERO, zero), (SCALE, scale_error)):
            self.mean[:, state], self.p[:, state, state] = value, deviation ** 2

    def _take_reading(self, reading: Array, *, quick: bool, lost: bool) -> bool:
        """
        Cut the belief in what the accumulators held to what a reading says; weigh all by it.

        Return False, and believe as before, if it contradicts the wheels and a part may be lost.
        """
        before, p_before = self.mean.copy(), self.p
        rounds = self._rounding == ROUNDINGS.index(Rounding.ROUND)
        logs = np.zeros(len(self.mean))
        for n, state, tick in zip(reading, (ANGLE, DISTANCE), (
                2 * TICK / (FIRMWARE_SEPARATION * DEGREE) ** 2, TICK / 2 / MILLI ** 2)):
            low = np.where(rounds, n - 0.5, n - (n <= 0))
            high = np.where(rounds, n + 0.5, n + (n >= 0))
            column = self.p[:, :, state]
            variance = column[:, state] + tick
            deviation, mean = np.sqrt(variance), self.mean[:, state]
            shift, kept, likely = cut((low - mean) / deviation, (high - mean) / deviation)
            self.mean = self.mean + column * (shift / deviation)[:, None]
            part = ((1 - kept) / variance)[:, None] * column
            self.p = self.p - part[:, :, None] * column[:, None]
            logs += likely
        most = float(logs.max())
        joint = self.weights * np.exp(np.maximum(logs - most, -20.0)).reshape(self.weights.shape)
        follow = joint[..., :FREE].sum() / (self.weights[..., :FREE].sum() + 1e-300) * exp(most)
        if lost and follow < NOT_FOLLOWED:
            self.mean, self.p = before, p_before
            return False
        self.readings += not quick and bool(self.wheels.moving or reading.any())
        each = self.weights.sum(2, keepdims=True)
        whole = joint.sum(2, keepdims=True)
        within = joint / (whole + 1e-300)
        evidence = whole / (each + 1e-300)
        of_rounding = whole.sum(1, keepdims=True) / each.sum(1, keepdims=True)
        of_source = evidence / (of_rounding + 1e-300)
        if quick and not self.wheels.wrong.any():
            of_source[:] = 1.0
        share = IN_A_ROW if quick else OF_ROUNDING
        least = exp(-LEAST_LOG)
        each = each * np.maximum(of_rounding / of_rounding.max(), least) ** share
        each = each * np.maximum(of_source, least) ** OF_SOURCE
        each = each / each.sum() + 1e-7
        self.weights = within * each / each.sum()
        self.followed = self.weights[..., FREE].sum() < 0.5
        return True


def cut(low: Array, high: Array) -> tuple[Array, Array, Array]:
    """Cut standard normal distributions to intervals: means, variances, ln of probabilities."""
    probability = cumulative(high) - cumulative(low)
    beyond = np.maximum(np.maximum(low, -high), 0.0)
    at_low, at_high = (np.exp(-0.5 * np.minimum(x * x, 700.0)) * 0.3989423 for x in (low, high))
    z = np.maximum(probability, UNLIKELY)
    mean = (at_low - at_high) / z
    kept = np.clip(1 + (low * at_low - high * at_high) / z - mean * mean, 0.0, 1.0)
    # Far outside, a normal distribution of the interval's width stands for it.
    width, far = (high - low) ** 2 / 12, probability < UNLIKELY
    return (np.where(far, (low + high) / 2 / (1 + width), mean),
            np.where(far, width / (1 + width), kept),
            np.where(far & (beyond > 0), log(UNLIKELY) - 0.5 * (beyond ** 2 - 4.0),
                     np.log(np.maximum(probability, 1e-300))))


def cumulative(x: Array) -> Array:
    """Return the standard normal distribution function, to 3e-4."""
    x = np.clip(x, -10.0, 10.0)
    result: Array = 0.5 + 0.5 * np.tanh(0.7978846 * x * (1 + 0.044715 * x * x))
    return result
