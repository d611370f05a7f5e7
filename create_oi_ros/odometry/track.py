"""
A belief about where the robot is, under one assumption about its rounding.

An error-state Kalman filter: a nominal motion computed from the requested wheel speeds, and the
covariance of its errors. States, in this order:

    x, y, yaw           pose error, m and rad
    distance, angle     error of what the robot's accumulators hold, m and rad
    right, left gain    relative error of the speed that each wheel settles at
    ramp                relative error of 1 / acceleration
    right, left speed   error of a wheel's speed while it is not at its goal, m/s
    separation          relative error of the separation by which the robot works out its angle

Pose and accumulators are apart, because a wheel that rolls on after a reverse command is counted
with the wrong sign. docs/odometry.md derives all of it.
"""

from copy import copy, deepcopy
from math import cos, pi, sin, sqrt
from typing import NamedTuple

from .rounding import cut_normal, interval, Rounding
from .wheel import Wheel

MM = 1e-3
DEGREE = pi / 180
SIZE = 11
X, Y, YAW, DISTANCE, ANGLE, RIGHT, LEFT, RAMP, RIGHT_SPEED, LEFT_SPEED, SEPARATION = range(SIZE)
UNITS = ((DISTANCE, MM), (ANGLE, DEGREE))

GAIN_SPREAD = 0.02
"""Standard deviations at the start: gain of a wheel, ..."""
SEPARATION_SPREAD = 0.006
RAMP_SPREAD = 0.25
GAIN_DRIFT = 1e-4
"""Standard deviation of a gain's random walk, per root second of motion."""
SLIP = 1e-4
"""Metres that a wheel strays from what its encoder counts, per root metre."""
RAMP_NOISE = 0.004
"""Part of a ramp's travel by which it departs from a constant acceleration."""
WANDER = 0.5
"""Acceleration of a robot that moves on its own, m/s per root second."""
SURPRISE = 5.0
"""Standard deviations, and the units added to them, beyond which prediction has failed."""
SURPRISE_FLOOR = 0.1
UNLIKELY = 1e-3
TOP_SPEED = 0.5
"""m/s, of either wheel (manual)."""
LONGEST_SEGMENT = 0.25
"""Seconds between updates of the covariance."""
BELIEVABLE = 1.5, 0.05
"""Units, and part of the travel, by which a robot that obeys again may miss its prediction."""
TELLING_TIME = 0.2
"""Seconds that a window must last to tell whether the robot obeys."""

Matrix = list[list[float]]
Terms = tuple[tuple[int, float], ...]


class Segment(NamedTuple):
    """What a stretch of motion does to errors; both wheels, right first, where there are two."""

    dx: float
    dy: float
    cos: float
    sin: float
    turn: float
    counted_turn: float
    counts: tuple[float, float]
    gain: tuple[float, float]
    """Metres of travel per relative error of the gain."""
    seconds: tuple[float, float]
    """Metres of travel per m/s of speed error."""
    ramp: tuple[float, float]
    """Metres of travel per relative error of 1 / acceleration."""
    speed_ramp: tuple[float, float] | None
    """m/s of speed per the same; None for wheels that run free."""
    keep: tuple[bool, bool]
    """Whether the speed error lives on: not once a wheel is at its goal."""


class Track:
    """Nominal motion, its covariance, and how plausible its assumption is."""

    def __init__(self, rounding: Rounding, acceleration: float,
                 linear_scale: float = 1.0, angular_scale: float = 1.0) -> None:
        self.rounding = rounding
        self.acceleration = acceleration
        self.scales = linear_scale, angular_scale
        self.weight = 1.0
        self.x = self.y = self.yaw = 0.0
        self.separation = 0.258
        self.right, self.left = Wheel(), Wheel()
        self.free: list[float] | None = None
        """Wheel speeds taken from readings, while the wheels do not do what was requested."""
        self.surprises = 0
        self.distance = self.angle = 0.0
        """What the accumulators are believed to hold, m and rad."""
        self.covariance: Matrix = [[0.0] * SIZE for _ in range(SIZE)]
        self.forget_parameters()
        self.went = self.turned = 0.0
        """Travel and turn of the newest step, before any correction."""
        self._expected = [0.0, 0.0]
        self._open_window()
        self._open_segment()
        self._empty(rounding is Rounding.CARRY)

    def fork(self, rounding: Rounding, acceleration: float) -> 'Track':
        """Return a copy that assumes something else and has everything to learn."""
        other = copy(self)
        other.right, other.left = copy(self.right), copy(self.left)
        other.covariance = deepcopy(self.covariance)
        other._expected = list(self._expected)
        other.rounding, other.acceleration = rounding, acceleration
        other.weight, other.surprises = 1.0, 0
        other.forget_parameters()
        return other

    def forget_parameters(self) -> None:
        """Doubt gains, acceleration and separation as at the start."""
        for index, spread in ((RIGHT, GAIN_SPREAD), (LEFT, GAIN_SPREAD), (RAMP, RAMP_SPREAD),
                              (SEPARATION, SEPARATION_SPREAD)):
            self._clear(index)
            self.covariance[index][index] = spread * spread

    @property
    def settled(self) -> bool:
        """Whether both wheels run at their goals."""
        return self.right.speed == self.right.goal and self.left.speed == self.left.goal

    @property
    def speeds(self) -> tuple[float, float]:
        """Believed speed of the right and left wheel."""
        if self.free is not None:
            return self.free[0], self.free[1]
        return self.right.speed, self.left.speed

    @property
    def twist_variance(self) -> tuple[float, float]:
        """Variance of the forward speed, (m/s)², and of the turn rate, (rad/s)²."""
        p, both = self.covariance, 0.0
        for wheel, gain, speed in (
                (self.right, RIGHT, RIGHT_SPEED), (self.left, LEFT, LEFT_SPEED)):
            both += p[speed][speed]
            if self.free is None and wheel.speed == wheel.goal:
                both += p[gain][gain] * wheel.goal * wheel.goal
        return both / 4 + 1e-6, both / self.separation ** 2 + 1e-6

    # Motion.

    def advance(self, dt: float, right: float, left: float) -> None:
        """Go on by dt seconds, somewhere within which the requests became right and left."""
        self.went = self.turned = 0.0
        if right == self.right.request and left == self.left.request:
            self._glide(dt)
            if self._seconds > LONGEST_SEGMENT:
                self.close_segment()
            return
        self._glide(dt / 2)
        self.close_segment()
        self._request(right, left, dt)
        self._glide(dt / 2)

    def _request(self, right: float, left: float, span: float) -> None:
        """Take a request that came at an unknown moment within `span` seconds."""
        wheels, requests = (self.right, self.left), (right, left)
        counted, pulled = [0.0, 0.0], [0.0, 0.0]
        for i, (wheel, request) in enumerate(zip(wheels, requests)):
            counted[i] = wheel.counts * wheel.speed
            pulled[i] = wheel.acceleration(self.acceleration)
            wheel.ask(request)
            counted[i] -= wheel.counts * wheel.speed
            pulled[i] -= wheel.acceleration(self.acceleration)
        if self.free is None:
            self._add(span * span / 12, (
                (RIGHT_SPEED, pulled[0]), (LEFT_SPEED, pulled[1]),
                (DISTANCE, (counted[0] + counted[1]) / 2),
                (ANGLE, (counted[0] - counted[1]) / self.separation)))

    def _glide(self, seconds: float) -> None:
        """Go on under the same requests, in pieces within which the encoders' signs hold."""
        limit = self.acceleration
        while True:
            turns = [t for t in (self.right.time_to_turn(limit), self.left.time_to_turn(limit))
                     if 0 < t < seconds]
            if not turns:
                break
            self._piece(min(turns))
            seconds -= min(turns)
            for wheel in (self.right, self.left):
                if abs(wheel.speed) < 1e-9:
                    wheel.speed = 0.0
            self.close_segment()
            self.right.settle_sign()
            self.left.settle_sign()
        self._piece(seconds)

    def _piece(self, seconds: float) -> None:
        right = self.right.roll(seconds, self.acceleration)
        left = self.left.roll(seconds, self.acceleration)
        counted_right, counted_left = right * self.right.counts, left * self.left.counts
        if self.free is not None:
            self._expected[0] += (counted_right + counted_left) / 2
            self._expected[1] += (counted_right - counted_left) / self.separation
            right = counted_right = self.free[0] * seconds
            left = counted_left = self.free[1] * seconds
        self.distance += (counted_right + counted_left) / 2
        counted_turn = (counted_right - counted_left) / self.separation
        self.angle += counted_turn
        self._counted_turn += counted_turn
        went = (right + left) / 2 * self.scales[0]
        turn = (right - left) / self.separation * self.scales[1]
        middle = self.yaw + turn / 2
        chord = went * (1 - turn * turn / 24)
        self.x += chord * cos(middle)
        self.y += chord * sin(middle)
        self.yaw += turn
        self.went += went
        self.turned += turn
        self._path += abs(right) + abs(left)
        self._seconds += seconds

    # Covariance.

    def _open_segment(self) -> None:
        self._start = self.x, self.y, self.yaw
        self._seconds = self._path = self._counted_turn = 0.0
        self.right.open_segment()
        self.left.open_segment()

    def close_segment(self) -> None:
        """Bring the covariance up to the nominal motion."""
        if self._path or self.right.ramped or self.left.ramped or self.free is not None:
            if self.free is not None:
                spread = WANDER * WANDER * self._seconds
                self.covariance[RIGHT_SPEED][RIGHT_SPEED] += spread
                self.covariance[LEFT_SPEED][LEFT_SPEED] += spread
            segment = self._segment()
            matrix = self._carried(self.covariance, segment)
            matrix = [list(column) for column in zip(*matrix)]
            self.covariance = self._carried(matrix, segment)
            self._disturb(segment)
        self._window_seconds += self._seconds
        self._open_segment()

    def _segment(self) -> Segment:
        x, y, yaw = self._start
        middle = (self.yaw + yaw) / 2
        gain = ramp = 0.0, 0.0
        counts, seconds = (1.0, 1.0), (self._seconds, self._seconds)
        speed_ramp: tuple[float, float] | None = None
        keep = True, True
        if self.free is None:
            right, left, a = self.right, self.left, self.acceleration
            counts = right.counts, left.counts
            seconds = right.ramped, left.ramped
            gain = right.goal * right.cruised, left.goal * left.cruised
            speed_ramp = -a * right.pull * right.ramped, -a * left.pull * left.ramped
            ramp = speed_ramp[0] * right.ramped / 2, speed_ramp[1] * left.ramped / 2
            keep = right.speed != right.goal, left.speed != left.goal
        return Segment(self.x - x, self.y - y, cos(middle), sin(middle), self.yaw - yaw,
                       self._counted_turn, counts, gain, seconds, ramp, speed_ramp, keep)

    def _carried(self, m: Matrix, s: Segment) -> Matrix:
        """Return the matrix of the error's transition times m."""
        linear, angular = self.scales
        b, yaw, spread, slow = self.separation, m[YAW], m[SEPARATION], m[RAMP]
        travels = []
        for i, gain, speed in ((0, RIGHT, RIGHT_SPEED), (1, LEFT, LEFT_SPEED)):
            g, t, r = s.gain[i], s.seconds[i], s.ramp[i]
            travels.append([g * p + t * q + r * k for p, q, k in zip(m[gain], m[speed], slow)])
            if not s.keep[i]:
                m[speed] = [0.0] * SIZE
            elif s.speed_ramp is not None:
                r = s.speed_ramp[i]
                m[speed] = [q + r * k for q, k in zip(m[speed], slow)]
        right, left = travels
        turn = [(p - q) / b * angular - s.turn * k for p, q, k in zip(right, left, spread)]
        m[X] = [p - s.dy * (h + t / 2) + s.cos * linear * (u + v) / 2
                for p, h, t, u, v in zip(m[X], yaw, turn, right, left)]
        m[Y] = [p + s.dx * (h + t / 2) + s.sin * linear * (u + v) / 2
                for p, h, t, u, v in zip(m[Y], yaw, turn, right, left)]
        m[YAW] = [h + t for h, t in zip(yaw, turn)]
        f, g = s.counts
        m[DISTANCE] = [p + (f * u + g * v) / 2 for p, u, v in zip(m[DISTANCE], right, left)]
        m[ANGLE] = [p + (f * u - g * v) / b - s.counted_turn * k
                    for p, u, v, k in zip(m[ANGLE], right, left, spread)]
        return m

    def _disturb(self, s: Segment) -> None:
        """Add what no parameter explains: slip, uneven ramps, parameters that drift."""
        p, b = self.covariance, self.separation
        slip = SLIP * SLIP * self._path
        p[X][X] += slip / 4
        p[Y][Y] += slip / 4
        p[YAW][YAW] += slip / (b * b)
        drift = GAIN_DRIFT * GAIN_DRIFT * self._seconds
        p[RIGHT][RIGHT] += drift
        p[LEFT][LEFT] += drift
        for side, ramp, counts in zip((1.0, -1.0), s.ramp, s.counts):
            if ramp:
                self._add((RAMP_NOISE * ramp) ** 2, (
                    (X, s.cos / 2), (Y, s.sin / 2), (YAW, side / b),
                    (DISTANCE, counts / 2), (ANGLE, counts * side / b)))

    def _add(self, variance: float, terms: Terms) -> None:
        """Add a disturbance that moves several states at once."""
        for i, a in terms:
            row, scaled = self.covariance[i], variance * a
            for j, b in terms:
                row[j] += scaled * b

    def _clear(self, index: int) -> None:
        self.covariance[index] = [0.0] * SIZE
        for row in self.covariance:
            row[index] = 0.0

    # Readings.

    def read(self, distance: int, angle: int) -> float:
        """Take a reading in; return how likely it was, 1 for one that tells nothing of that."""
        self.close_segment()
        readings = (distance, angle)
        likelihood = 1.0
        surprise = None if self.free else self._surprise(readings)
        if surprise:
            likelihood = UNLIKELY
            self._run_free(surprise)
        for (index, unit), whole in zip(UNITS, readings):
            mass = self._cut(index, unit, whole)
            if not surprise:
                likelihood *= mass + UNLIKELY
        if self.free is not None and self._obeys(readings):
            self._run_bound()
        self._take_out(distance * MM, angle * DEGREE)
        return likelihood

    def discard(self) -> None:
        """Let a reading go by that spans an unknown time: only the reset counts."""
        self.close_segment()
        self._empty(self.rounding is Rounding.CARRY)
        self._open_window()

    def doubt(self, distance: int, angle: int) -> None:
        """Expect nothing of a reading that spans a time without frames."""
        self.close_segment()
        self._stray(abs(distance * MM - self.distance) + MM,
                    abs(angle * DEGREE - self.angle) + DEGREE)

    def resume(self, right: float, left: float) -> None:
        """Go on after a gap in which the wheels have reached these requests."""
        self.close_segment()
        if self.free is not None:
            self._run_bound()
        for wheel, request, index in ((self.right, right, RIGHT_SPEED),
                                      (self.left, left, LEFT_SPEED)):
            wheel.ask(request)
            wheel.speed = wheel.goal
            wheel.settle_sign()
            self._clear(index)

    def reset(self) -> None:
        """Put the origin of the odometry frame where the robot is."""
        self.close_segment()
        self.x = self.y = self.yaw = 0.0
        self._window_start = 0.0, 0.0, 0.0
        for index in (X, Y, YAW):
            self._clear(index)
        self._open_segment()

    def _surprise(self, readings: tuple[int, int]) -> tuple[float, float] | None:
        """Return how far the readings lie beyond belief; None when they do not."""
        gaps, failed = [], False
        for (index, unit), whole, held in zip(UNITS, readings, (self.distance, self.angle)):
            low, high = interval(self.rounding, whole)
            gap = max(low * unit - held, held - high * unit, 0.0)
            spread = sqrt(self.covariance[index][index])
            failed = failed or gap > SURPRISE * spread + SURPRISE_FLOOR * unit
            gaps.append(gap + unit)
        return (gaps[0], gaps[1]) if failed else None

    def _run_free(self, gaps: tuple[float, float]) -> None:
        """Give up the requested speeds: from here only the readings say how the robot moves."""
        self.surprises += 1
        self.free = list(self.speeds)
        self._clear(RIGHT_SPEED)
        self._clear(LEFT_SPEED)
        self._stray(*gaps)

    def _stray(self, distance: float, angle: float) -> None:
        """Doubt the window's travel and turn by these."""
        seconds = max(self._window_seconds, 0.015)
        x, y, yaw = self._window_start
        dx, dy, middle = self.x - x, self.y - y, (self.yaw + yaw) / 2
        rate, turn_rate = 1 / seconds, self.separation / 2 / seconds
        self._add(distance ** 2, (
            (X, cos(middle)), (Y, sin(middle)), (DISTANCE, 1.0),
            (RIGHT_SPEED, rate), (LEFT_SPEED, rate)))
        self._add(angle ** 2, (
            (X, -dy / 2), (Y, dx / 2), (YAW, 1.0), (ANGLE, 1.0),
            (RIGHT_SPEED, turn_rate), (LEFT_SPEED, -turn_rate)))
        shape = (distance * min(angle, 1.0) / 4) ** 2
        self._add(shape, ((X, 1.0),))
        self._add(shape, ((Y, 1.0),))

    def _obeys(self, readings: tuple[int, int]) -> bool:
        """Tell whether the wheels did what was requested since the reading before."""
        slack, part = BELIEVABLE
        return self._window_seconds > TELLING_TIME and all(
            abs(whole * unit - expected) <= slack * unit + part * abs(expected)
            for (_, unit), whole, expected in zip(UNITS, readings, self._expected))

    def _run_bound(self) -> None:
        """Trust the requested speeds again."""
        self.free = None
        self._clear(RIGHT_SPEED)
        self._clear(LEFT_SPEED)

    def _cut(self, index: int, unit: float, whole: int) -> float:
        """Cut a belief to the interval of a whole number; return the mass that was inside."""
        held = self.distance if index == DISTANCE else self.angle
        low, high = interval(self.rounding, whole)
        variance = max(self.covariance[index][index], 1e-14)
        spread = sqrt(variance)
        mean, left, mass = cut_normal((low * unit - held) / spread, (high * unit - held) / spread)
        column = [row[index] for row in self.covariance]
        shrink = (1 - left) / variance
        for i, factor in enumerate(column):
            scaled = shrink * factor
            self.covariance[i] = [p - scaled * q for p, q in zip(self.covariance[i], column)]
        self._correct([mean / spread * q for q in column])
        return mass

    def _correct(self, by: list[float]) -> None:
        """Move the nominal motion by an estimated error."""
        self.x += by[X]
        self.y += by[Y]
        self.yaw += by[YAW]
        self.distance += by[DISTANCE]
        self.angle += by[ANGLE]
        self.separation *= 1 + by[SEPARATION]
        self.acceleration = min(10.0, max(0.1, self.acceleration / max(0.2, 1 + by[RAMP])))
        if self.free is not None:
            self.free = [min(TOP_SPEED, max(-TOP_SPEED, speed + by[index]))
                         for speed, index in zip(self.free, (RIGHT_SPEED, LEFT_SPEED))]
        else:
            for wheel, index in ((self.right, RIGHT_SPEED), (self.left, LEFT_SPEED)):
                if wheel.speed != wheel.goal:
                    wheel.speed += by[index]
                    wheel.settle_sign()
        self.right.learn(self.right.gain * (1 + by[RIGHT]))
        self.left.learn(self.left.gain * (1 + by[LEFT]))
        self._open_segment()

    def _take_out(self, distance: float, angle: float) -> None:
        """Let the accumulators be reset by a reading."""
        if self.rounding is Rounding.CARRY:
            self.distance -= distance
            self.angle -= angle
        else:
            self._empty(False)
        self._open_window()

    def _empty(self, carried: bool) -> None:
        """Set the accumulators to zero, or to an unknown rest below one unit."""
        self.distance = self.angle = 0.0
        for index, unit in UNITS:
            self._clear(index)
            self.covariance[index][index] = unit * unit / 3 if carried else 0.0

    def _open_window(self) -> None:
        self._window_start = self.x, self.y, self.yaw
        self._window_seconds = 0.0
        self._expected = [0.0, 0.0]

