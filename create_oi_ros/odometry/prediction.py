"""
How a track predicts: the wheels' nominal motion, and what becomes of its errors.

Wheels run to the requested speeds; while they do not obey they run free, at speeds that readings
told. docs/odometry.md derives all of it.
"""

from math import cos, sin
from typing import NamedTuple

from . import assumptions as given
from .errors import (
    ANGLE,
    DISTANCE,
    Errors,
    LAG,
    LEFT,
    LEFT_SPEED,
    RIGHT,
    RIGHT_SPEED,
    Segment,
    X,
    Y,
    YAW,
)
from .estimate import Geometry
from .wheel import Wheel
from .window import Window


class Unseen(NamedTuple):
    """How a wheel ran while nothing was heard of it."""

    speed: float
    """m/s, half way from what it was before to what it is after."""
    spread: float
    """m/s by which either of these differs from it."""
    counts: float
    """What its encoder counted over what it travelled."""

    @classmethod
    def between(cls, before: float, after: float, counts: float) -> 'Unseen':
        """Take it to have run at the mean of two speeds."""
        return cls((before + after) / 2, abs(before - after) / 2, counts)


class Prediction:
    """Pose, accumulators, wheels and parameters, and the covariance of their errors."""

    def __init__(self, acceleration: float, geometry: Geometry) -> None:
        self.acceleration = acceleration
        self.geometry = geometry
        self.scales = geometry.linear_scale, geometry.angular_scale
        """Of travel and turn, both zero off the floor."""
        self.x = self.y = self.yaw = 0.0
        self.separation = 0.258
        self.lag = 0.0
        """Seconds after the middle of its slot at which a request takes effect."""
        self.right, self.left = Wheel(), Wheel()
        self.free: list[float] | None = None
        """Wheel speeds taken from readings, while the wheels do not do what was requested."""
        self.distance = self.angle = 0.0
        """What the accumulators are believed to hold, m and rad."""
        self.errors = Errors()
        self.went = self.turned = 0.0
        """Travel and turn of the newest step, before any correction."""
        self.unseen: tuple[Unseen, Unseen] | None = None
        """How the wheels ran where frames may have been lost."""
        self.window = Window(0.0, 0.0, 0.0)
        self.open_segment()

    @property
    def settled(self) -> bool:
        """Whether both wheels run at their goals."""
        return self.right.speed == self.right.goal and self.left.speed == self.left.goal

    @property
    def stands(self) -> bool:
        """Whether nothing moves, and nothing will under the same requests."""
        right, left = self.right, self.left
        return self.free is None and not (right.speed or left.speed or right.goal or left.goal)

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

    def rest(self, seconds: float) -> None:
        """Let time pass in which it `stands`: nothing else comes of it."""
        self._seconds += seconds

    def note_gap(self, right: float, left: float) -> None:
        """Keep how wheels ran where frames may have been lost; the requests are those after."""
        before = self.speeds
        after = self.free or (right * self.right.gain, left * self.left.gain)
        counts = (self.right.counts, self.left.counts) if self.free is None else (1.0, 1.0)
        self.unseen = (Unseen.between(before[0], after[0], counts[0]),
                       Unseen.between(before[1], after[1], counts[1]))

    def make_up(self, seconds: float, doubt: float) -> None:
        """
        Travel for frames that are known only now to have been lost, in doubt by `doubt` seconds.

        The wheels may run otherwise by now, so they are taken as they ran then.
        """
        self.close_segment()
        if self.unseen is None:
            self.note_gap(self.right.request, self.left.request)
        assert self.unseen is not None
        (right, left), self.unseen = self.unseen, None
        self._doubt(doubt * doubt, right, left)
        self._doubt(seconds * seconds, right._replace(speed=right.spread), left._replace(speed=0))
        self._doubt(seconds * seconds, right._replace(speed=0), left._replace(speed=left.spread))
        self._travel(right.speed * seconds, left.speed * seconds, right.counts, left.counts)
        self._seconds += seconds
        self.close_segment()

    def _doubt(self, variance: float, right: Unseen, left: Unseen) -> None:
        """Doubt for how long wheels have run so."""
        linear, angular = self.scales
        forward = (right.speed + left.speed) / 2
        turn = (right.speed - left.speed) / self.separation
        i, j = right.counts, left.counts
        self.errors.add(variance, (
            (X, forward * linear * cos(self.yaw)), (Y, forward * linear * sin(self.yaw)),
            (YAW, turn * angular), (DISTANCE, (i * right.speed + j * left.speed) / 2),
            (ANGLE, (i * right.speed - j * left.speed) / self.separation)))

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
        window = self.window
        right = self.right.roll(seconds, self.acceleration)
        left = self.left.roll(seconds, self.acceleration)
        counts = self.right.counts, self.left.counts
        if self.free is not None:
            window.expected += (right * counts[0] + left * counts[1]) / 2
            window.expected_angle += (right * counts[0] - left * counts[1]) / self.separation
            right, left, counts = self.free[0] * seconds, self.free[1] * seconds, (1.0, 1.0)
        self._travel(right, left, *counts)
        self._seconds += seconds

    def _travel(
        self, right: float, left: float, right_counts: float, left_counts: float,
    ) -> None:
        """Let the wheels go so far, and their encoders count it."""
        window = self.window
        counted_right, counted_left = right * right_counts, left * left_counts
        self.distance += (counted_right + counted_left) / 2
        counted_turn = (counted_right - counted_left) / self.separation
        self.angle += counted_turn
        self._counted_turn += counted_turn
        went = (right + left) / 2 * self.scales[0]
        turn = (right - left) / self.separation * self.scales[1]
        window.miscounted += went - (counted_right + counted_left) / 2 * self.scales[0]
        window.miscounted_angle += turn - counted_turn * self.scales[1]
        middle = self.yaw + turn / 2
        chord = went * (1 - turn * turn / 24)
        self.x += chord * cos(middle)
        self.y += chord * sin(middle)
        self.yaw += turn
        self.went += went
        self.turned += turn
        self._path += abs(right) + abs(left)
        window.path += abs(right) + abs(left)

    # Covariance.

    def open_segment(self) -> None:
        """Begin to gather motion for the covariance."""
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
        self.window.seconds += self._seconds
        self.open_segment()

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
            self.separation, self.scales, counts, gain, seconds, ramp, speed_ramp, keep)

    def _disturb(self, s: Segment) -> None:
        """Add what no parameter explains: slip, uneven ramps, parameters that drift."""
        p, b = self.errors.rows, self.separation
        stray = self.geometry.slip if self.free is None else given.ASTRAY
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
