"""
A belief about where the robot is, under one assumption about its rounding.

An error-state Kalman filter: a nominal motion computed from the requested wheel speeds, and the
covariance of its errors (`errors`). docs/odometry.md derives all of it.
"""

from copy import copy
from math import cos, sin, sqrt

from . import assumptions as given
from .errors import (
    ANGLE,
    DISTANCE,
    Errors,
    LAG,
    LEFT,
    LEFT_SPEED,
    RAMP,
    RIGHT,
    RIGHT_SPEED,
    Segment,
    SEPARATION,
    X,
    Y,
    YAW,
)
from .estimate import Geometry
from .rounding import cut_normal, interval, Rounding
from .wheel import Wheel

UNITS = ((DISTANCE, given.MM), (ANGLE, given.DEGREE))


class Track:
    """Nominal motion, its covariance, and how plausible its assumption is."""

    def __init__(self, rounding: Rounding, acceleration: float, geometry: Geometry) -> None:
        self.rounding = rounding
        self.acceleration = acceleration
        self._geometry = geometry
        self._scales = geometry.linear_scale, geometry.angular_scale
        self.weight = 1.0
        self.x = self.y = self.yaw = 0.0
        self.separation = 0.258
        self.lag = 0.0
        """Seconds after the middle of its slot at which a request takes effect."""
        self.right, self.left = Wheel(), Wheel()
        self.free: list[float] | None = None
        """Wheel speeds taken from readings, while the wheels do not do what was requested."""
        self.surprises = 0
        self.distance = self.angle = 0.0
        """What the accumulators are believed to hold, m and rad."""
        self.errors = Errors()
        self.forget_parameters()
        self.went = self.turned = 0.0
        """Travel and turn of the newest step, before any correction."""
        self._open_window()
        self._open_segment()
        self._empty(rounding is Rounding.CARRY)

    def fork(self, rounding: Rounding, acceleration: float) -> 'Track':
        """Return a copy that assumes something else and has everything to learn."""
        other = copy(self)
        other.right, other.left = copy(self.right), copy(self.left)
        other.errors = self.errors.copy()
        other._expected, other._miscounted = list(self._expected), list(self._miscounted)
        other.rounding, other.acceleration = rounding, acceleration
        other.weight, other.surprises = 1.0, 0
        other.forget_parameters()
        return other

    def forget_parameters(self) -> None:
        """Doubt gains, acceleration and separation as at the start."""
        for index, spread in (
                (RIGHT, given.GAIN_SPREAD), (LEFT, given.GAIN_SPREAD), (RAMP, given.RAMP_SPREAD),
                (SEPARATION, given.SEPARATION_SPREAD), (LAG, given.LAG_SPREAD)):
            self.errors.clear(index)
            self.errors.rows[index][index] = spread * spread

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
        cruising = [wheel.goal if self.free is None and wheel.speed == wheel.goal else 0.0
                    for wheel in (self.right, self.left)]
        both = self.errors.speed_variance(*cruising)
        return both / 4 + 1e-6, both / self.separation ** 2 + 1e-6

    # Motion.

    def advance(self, dt: float, right: float, left: float) -> None:
        """Go on by dt seconds, somewhere within which the requests became right and left."""
        self.went = self.turned = 0.0
        if right == self.right.request and left == self.left.request:
            self._glide(dt)
            if self._seconds > given.LONGEST_SEGMENT:
                self.close_segment()
            return
        until = min(dt, max(0.0, dt / 2 + self.lag))
        self._glide(until)
        self.close_segment()
        self._request(right, left, dt)
        self._glide(dt - until)

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
            late = ((RIGHT_SPEED, pulled[0]), (LEFT_SPEED, pulled[1]),
                    (DISTANCE, (counted[0] + counted[1]) / 2),
                    (ANGLE, (counted[0] - counted[1]) / self.separation))
            self.errors.shift(LAG, late)
            self.errors.add(given.JITTER * span * span, late)

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
        went = (right + left) / 2 * self._scales[0]
        turn = (right - left) / self.separation * self._scales[1]
        self._miscounted[0] += (right + left - counted_right - counted_left) / 2 * self._scales[0]
        self._miscounted[1] += turn - counted_turn * self._scales[1]
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
                spread = given.WANDER * given.WANDER * self._seconds
                self.errors.add(spread, ((RIGHT_SPEED, 1.0),))
                self.errors.add(spread, ((LEFT_SPEED, 1.0),))
            segment = self._segment()
            self.errors.carry(segment)
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
        return Segment(
            self.x - x, self.y - y, cos(middle), sin(middle), self.yaw - yaw, self._counted_turn,
            self.separation, self._scales, counts, gain, seconds, ramp, speed_ramp, keep)

    def _disturb(self, s: Segment) -> None:
        """Add what no parameter explains: slip, uneven ramps, parameters that drift."""
        p, b = self.errors.rows, self.separation
        stray = self._geometry.slip
        if self.free is not None:
            stray = max(stray, given.ASTRAY)
        slip = stray * stray * self._path
        p[X][X] += slip / 4
        p[Y][Y] += slip / 4
        p[YAW][YAW] += slip / (b * b)
        drift = given.GAIN_DRIFT * given.GAIN_DRIFT * self._seconds
        p[RIGHT][RIGHT] += drift
        p[LEFT][LEFT] += drift
        for side, ramp, counts in zip((1.0, -1.0), s.ramp, s.counts):
            if ramp:
                self.errors.add((given.RAMP_NOISE * ramp) ** 2, (
                    (X, s.cos / 2), (Y, s.sin / 2), (YAW, side / b),
                    (DISTANCE, counts / 2), (ANGLE, counts * side / b)))

    # Readings.

    def read(self, distance: int, angle: int) -> float:
        """Take a reading in; return how likely it was."""
        self.close_segment()
        readings, likelihood = (distance, angle), 1.0
        surprise = None if self.free else self._surprise(readings)
        if surprise:
            likelihood = given.UNLIKELY
            self._run_free(surprise)
        for (index, unit), whole in zip(UNITS, readings):
            mass = self._cut(index, unit, whole)
            if not surprise:
                likelihood *= mass + given.UNLIKELY
        if self.free is not None and self._obeys(readings):
            self._run_bound()
        self._take_out(distance * given.MM, angle * given.DEGREE)
        return likelihood

    def discard(self) -> None:
        """Let a reading go by that spans an unknown time: only the reset counts."""
        self.close_segment()
        self._empty(self.rounding is Rounding.CARRY)
        self._open_window()

    def doubt(self, distance: int, angle: int) -> None:
        """Expect nothing of a reading that spans a time without frames."""
        self.close_segment()
        self._stray(abs(distance * given.MM - self.distance) + given.MM,
                    abs(angle * given.DEGREE - self.angle) + given.DEGREE)

    def resume(self, right: float, left: float) -> None:
        """Go on after a gap in which the wheels have reached these requests."""
        self.close_segment()
        if self.free is not None:
            self._run_bound()
        for wheel, request in ((self.right, right), (self.left, left)):
            wheel.ask(request)
            wheel.speed = wheel.goal
            wheel.settle_sign()
        self.errors.clear(RIGHT_SPEED)
        self.errors.clear(LEFT_SPEED)

    def lift(self, lifted: bool) -> None:
        """Take the robot off the floor, where wheels turn and nothing moves, or put it down."""
        self.close_segment()
        g = self._geometry
        self._scales = (0.0, 0.0) if lifted else (g.linear_scale, g.angular_scale)

    def reset(self) -> None:
        """Put the origin of the odometry frame where the robot is."""
        self.close_segment()
        self.x = self.y = self.yaw = 0.0
        self._window_start = 0.0, 0.0, 0.0
        for index in (X, Y, YAW):
            self.errors.clear(index)
        self._open_segment()

    def _surprise(self, readings: tuple[int, int]) -> tuple[float, float] | None:
        """Return how far the readings lie beyond belief; None when they do not."""
        gaps, failed = [], False
        for (index, unit), whole, held in zip(UNITS, readings, (self.distance, self.angle)):
            low, high = interval(self.rounding, whole)
            gap = max(low * unit - held, held - high * unit, 0.0)
            spread = sqrt(self.errors.rows[index][index])
            failed = failed or gap > given.SURPRISE * spread + given.SURPRISE_FLOOR * unit
            gaps.append(gap + unit)
        return (gaps[0], gaps[1]) if failed else None

    def _run_free(self, gaps: tuple[float, float]) -> None:
        """Give up the requested speeds: from here only the readings say how the robot moves."""
        self.surprises += 1
        self.free = list(self.speeds)
        self.errors.clear(RIGHT_SPEED)
        self.errors.clear(LEFT_SPEED)
        self._stray(*gaps)

    def _stray(self, distance: float, angle: float) -> None:
        """Doubt the window's travel and turn by these."""
        seconds = max(self._window_seconds, 0.015)
        x, y, yaw = self._window_start
        dx, dy, middle = self.x - x, self.y - y, (self.yaw + yaw) / 2
        rate, turn_rate = 1 / seconds, self.separation / 2 / seconds
        self.errors.add(distance ** 2, (
            (X, cos(middle)), (Y, sin(middle)), (DISTANCE, 1.0),
            (RIGHT_SPEED, rate), (LEFT_SPEED, rate)))
        self.errors.add(angle ** 2, (
            (X, -dy / 2), (Y, dx / 2), (YAW, 1.0), (ANGLE, 1.0),
            (RIGHT_SPEED, turn_rate), (LEFT_SPEED, -turn_rate)))
        # Whoever holds a wheel also ends its rolling on under the wrong sign.
        far, turn = self._miscounted
        self.errors.add(1.0, ((X, far * cos(middle)), (Y, far * sin(middle)), (YAW, turn)))
        self.x, self.y, self.yaw = (
            self.x - far * cos(middle), self.y - far * sin(middle), self.yaw - turn)
        shape = (distance * min(angle, 1.0) / 4) ** 2
        self.errors.add(shape, ((X, 1.0),))
        self.errors.add(shape, ((Y, 1.0),))

    def _obeys(self, readings: tuple[int, int]) -> bool:
        """Tell whether the wheels did what was requested since the reading before."""
        slack, part = given.BELIEVABLE
        return self._window_seconds > given.TELLING_TIME and all(
            abs(whole * unit - expected) <= slack * unit + part * abs(expected)
            for (_, unit), whole, expected in zip(UNITS, readings, self._expected))

    def _run_bound(self) -> None:
        """Trust the requested speeds again."""
        self.free = None
        self.errors.clear(RIGHT_SPEED)
        self.errors.clear(LEFT_SPEED)

    def _cut(self, index: int, unit: float, whole: int) -> float:
        """Cut a belief to the interval of a whole number; return the mass that was inside."""
        held = self.distance if index == DISTANCE else self.angle
        low, high = interval(self.rounding, whole)
        self.errors.add(given.CERTAIN, ((index, 1.0),))
        spread = sqrt(self.errors.variance(index))
        mean, left, mass = cut_normal((low * unit - held) / spread, (high * unit - held) / spread)
        self._correct([mean * spread * q for q in self.errors.shrink(index, left)])
        return mass

    def _correct(self, by: list[float]) -> None:
        """Move the nominal motion by an estimated error."""
        self.x += by[X]
        self.y += by[Y]
        self.yaw += by[YAW]
        self.distance += by[DISTANCE]
        self.angle += by[ANGLE]
        self.separation *= 1 + by[SEPARATION]
        self.lag = min(given.HALF_SLOT, max(-given.HALF_SLOT, self.lag + by[LAG]))
        self.acceleration = min(10.0, max(0.1, self.acceleration / max(0.2, 1 + by[RAMP])))
        if self.free is not None:
            self.free = [min(given.TOP_SPEED, max(-given.TOP_SPEED, speed + by[index]))
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
            self.errors.clear(index)
            self.errors.rows[index][index] = unit * unit / 3 if carried else 0.0

    def _open_window(self) -> None:
        self._window_start = self.x, self.y, self.yaw
        self._window_seconds = 0.0
        self._expected = [0.0, 0.0]
        self._miscounted = [0.0, 0.0]
        """True travel and turn of the window less what the encoders make of them."""

