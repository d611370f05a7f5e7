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
    LAG,
    LEFT,
    LEFT_SPEED,
    RAMP,
    RIGHT,
    RIGHT_SPEED,
    SEPARATION,
    X,
    Y,
    YAW,
)
from .estimate import Geometry
from .prediction import Prediction
from .rounding import cut_normal, interval, Rounding
from .window import Window

UNITS = ((DISTANCE, given.MM), (ANGLE, given.DEGREE))


class Track(Prediction):
    """A prediction that readings correct, and how plausible its assumption is."""

    def __init__(self, rounding: Rounding, acceleration: float, geometry: Geometry) -> None:
        super().__init__(acceleration, geometry)
        self.rounding = rounding
        self.weight = 1.0
        self.surprises = 0
        """Readings that lay beyond belief."""
        self.forget_parameters()
        self._empty(rounding is Rounding.CARRY)

    def fork(self, rounding: Rounding, acceleration: float) -> 'Track':
        """Return a copy that assumes something else and has everything to learn."""
        other = copy(self)
        other.right, other.left = copy(self.right), copy(self.left)
        other.errors = self.errors.copy()
        other.window = copy(self.window)
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
            self.errors.add(spread * spread, ((index, 1.0),))

    def read(self, distance: int, angle: int) -> float:
        """Take a reading in; return how likely it was."""
        self.close_segment()
        readings, likelihood = (distance, angle), 1.0
        was_free = self.free is not None
        surprise = None if was_free else self._surprise(readings)
        if surprise:
            self.surprises += 1
            likelihood = given.UNLIKELY
            self._stray(*surprise)
            if self._roughly_obeys(readings):
                self._learn_more()
            else:
                self._run_free()
        for (index, unit), whole in zip(UNITS, readings):
            mass = self._cut(index, unit, whole)
            if not surprise:
                likelihood *= mass + given.UNLIKELY
        if (was_free or surprise) and any(readings):
            self._roam()
        if (was_free and self.window.seconds > given.TELLING_TIME
                and self._obeys(readings, (self.window.expected, self.window.expected_angle))):
            self._run_bound()
        self._take_out(distance * given.MM, angle * given.DEGREE)
        return likelihood

    def since(self, held: tuple[float, float], distance: int, angle: int, late: float) -> bool:
        """
        Tell whether a surprising reading is what came since the accumulators held this.

        Or since up to `late` seconds before: a reading in between was lost on the line.
        """
        self.close_segment()
        if self.free is not None or self._surprise((distance, angle)) is None:
            return False
        right, left = self.speeds
        rates = (right + left) / 2, (right - left) / self.separation
        now = self.distance, self.angle
        return all(
            abs(whole * unit - (b - a) - rate * late / 2) <= abs(rate) * late / 2 + 2 * unit
            for (_, unit), whole, a, b, rate in zip(UNITS, (distance, angle), held, now, rates))

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
        for wheel, request in ((self.right, right), (self.left, left)):
            wheel.ask(request)
            wheel.speed = wheel.goal
            wheel.settle_sign()
        self._run_bound()

    def lift(self, lifted: bool) -> None:
        """Take the robot off the floor, where wheels turn and nothing moves, or put it down."""
        self.close_segment()
        g = self.geometry
        self.scales = (0.0, 0.0) if lifted else (g.linear_scale, g.angular_scale)

    def reset(self) -> None:
        """Put the origin of the odometry frame where the robot is."""
        self.close_segment()
        self.x = self.y = self.yaw = 0.0
        self.window.x = self.window.y = self.window.yaw = 0.0
        for index in (X, Y, YAW):
            self.errors.clear(index)
        self.open_segment()

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

    def _learn_more(self) -> None:
        """Doubt the parameters somewhat: the wheels obey, but not quite as they should."""
        for index, spread in ((RIGHT, given.GAIN_SPREAD), (LEFT, given.GAIN_SPREAD),
                              (RAMP, given.RAMP_SPREAD)):
            self.errors.add((spread / 5) ** 2, ((index, 1.0),))

    def _run_free(self) -> None:
        """Give up the requested speeds: from here only the readings say how the robot moves."""
        self.free = list(self.speeds)
        # Whoever holds a wheel also ends its rolling on under the wrong sign.
        far, turn = self.window.miscounted, self.window.miscounted_angle
        middle = (self.yaw + self.window.yaw) / 2
        self.errors.add(1.0, ((X, far * cos(middle)), (Y, far * sin(middle)), (YAW, turn)))
        self.x -= far * cos(middle)
        self.y -= far * sin(middle)
        self.yaw -= turn

    def _stray(self, distance: float, angle: float) -> None:
        """Doubt the window's travel and turn by these."""
        window = self.window
        seconds = max(window.seconds, 2 * given.HALF_SLOT)
        dx, dy, middle = self.x - window.x, self.y - window.y, (self.yaw + window.yaw) / 2
        rate, turn_rate = 1 / seconds, self.separation / 2 / seconds
        grip = 1.0 if any(self.scales) else 0.0
        self.errors.add(distance ** 2, (
            (X, grip * cos(middle)), (Y, grip * sin(middle)), (DISTANCE, 1.0),
            (RIGHT_SPEED, rate), (LEFT_SPEED, rate)))
        self.errors.add(angle ** 2, (
            (X, -dy / 2), (Y, dx / 2), (YAW, grip), (ANGLE, 1.0),
            (RIGHT_SPEED, turn_rate), (LEFT_SPEED, -turn_rate)))
        shape = (grip * distance * min(angle, 1.0) / 4) ** 2
        self.errors.add(shape, ((X, 1.0),))
        self.errors.add(shape, ((Y, 1.0),))

    def _roam(self) -> None:
        """Doubt the place of a robot whose way was too long to be told by its two ends."""
        seconds = self.window.seconds
        if seconds > given.UNWATCHED and any(self.scales):
            for index in (X, Y):
                self.errors.add((given.ROAMING * seconds) ** 2, ((index, 1.0),))

    def _obeys(self, readings: tuple[int, int], expected: tuple[float, float]) -> bool:
        """Tell whether the wheels may have done what was requested in this window."""
        slack, part = given.BELIEVABLE
        return all(abs(whole * unit - much) <= slack * unit + part * abs(much)
                   for (_, unit), whole, much in zip(UNITS, readings, expected))

    def _roughly_obeys(self, readings: tuple[int, int]) -> bool:
        """Tell whether wrong parameters would explain what prediction missed."""
        slack, part = given.EXPLICABLE
        paths = part * self.window.path / 2, part * self.window.path / self.separation
        return all(abs(whole * unit - held) <= slack * unit + path for (_, unit), whole, held, path
                   in zip(UNITS, readings, (self.distance, self.angle), paths))

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
        self.separation = _within(given.SEPARATIONS, self.separation * (1 + by[SEPARATION]))
        self.lag = _within((-given.HALF_SLOT, given.HALF_SLOT), self.lag + by[LAG])
        self.acceleration = _within(
            given.ACCELERATIONS, self.acceleration / max(0.2, 1 + by[RAMP]))
        if self.free is not None:
            self.free = [_within((-given.TOP_SPEED, given.TOP_SPEED), speed + by[index])
                         for speed, index in zip(self.free, (RIGHT_SPEED, LEFT_SPEED))]
        else:
            for wheel, index in ((self.right, RIGHT_SPEED), (self.left, LEFT_SPEED)):
                if wheel.speed != wheel.goal:
                    wheel.speed += by[index]
                    wheel.settle_sign()
        self.right.learn(_within(given.GAINS, self.right.gain * (1 + by[RIGHT])))
        self.left.learn(_within(given.GAINS, self.left.gain * (1 + by[LEFT])))
        self.open_segment()

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
        self.window = Window(self.x, self.y, self.yaw)


def _within(bounds: tuple[float, float], value: float) -> float:
    return min(bounds[1], max(bounds[0], value))
