"""
The errors of a track: which there are, how motion carries them on, and their covariance.

States, in this order:

    x, y, yaw           pose error, m and rad
    distance, angle     error of what the robot's accumulators hold, m and rad
    right, left gain    relative error of the speed that each wheel settles at
    ramp                relative error of 1 / acceleration
    right, left speed   error of a wheel's speed while it is not at its goal, m/s
    separation          relative error of the separation by which the robot works out its angle
    lag                 error of the moment in its slot at which a request takes effect, s

Pose and accumulators are apart, because a wheel that rolls on after a reverse command is counted
with the wrong sign. docs/odometry.md derives all of it.
"""

from typing import NamedTuple

SIZE = 12
(X, Y, YAW, DISTANCE, ANGLE, RIGHT, LEFT, RAMP, RIGHT_SPEED, LEFT_SPEED, SEPARATION,
 LAG) = range(SIZE)

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
    separation: float
    scales: tuple[float, float]
    """Linear and angular."""
    counts: tuple[float, float]
    """What the encoder counts over what the wheel travels, 1 or -1."""
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


class Errors:
    """The covariance of a track's errors, symmetric, row by row."""

    __slots__ = ('rows',)

    def __init__(self) -> None:
        self.rows: Matrix = [[0.0] * SIZE for _ in range(SIZE)]

    def copy(self) -> 'Errors':
        """Return another with the same values."""
        other = Errors()
        other.rows = [list(row) for row in self.rows]
        return other

    def variance(self, index: int) -> float:
        """Return the variance of one error."""
        return self.rows[index][index]

    def speed_variance(self, right: float, left: float) -> float:
        """Return the sum of the wheels' speed variances; they cruise at these speeds, m/s."""
        return (self.rows[RIGHT_SPEED][RIGHT_SPEED] + self.rows[LEFT_SPEED][LEFT_SPEED]
                + self.rows[RIGHT][RIGHT] * right * right + self.rows[LEFT][LEFT] * left * left)

    def add(self, variance: float, terms: Terms) -> None:
        """Add a disturbance that moves several states at once."""
        for i, a in terms:
            row, scaled = self.rows[i], variance * a
            for j, b in terms:
                row[j] += scaled * b

    def shift(self, cause: int, terms: Terms) -> None:
        """Let the error of one state move several others."""
        p = self.rows
        for i, a in terms:
            p[i] = [q + a * c for q, c in zip(p[i], p[cause])]
        for row in p:
            for i, a in terms:
                row[i] += a * row[cause]

    def clear(self, index: int) -> None:
        self.rows[index] = [0.0] * SIZE
        for row in self.rows:
            row[index] = 0.0

    def carry(self, segment: Segment) -> None:
        """Go on by a segment of motion."""
        half = [list(column) for column in zip(*_carried(self.rows, segment))]
        self.rows = _carried(half, segment)

    def shrink(self, index: int, kept: float) -> list[float]:
        """
        Learn so much of one error that this part of its variance is left.

        Return what each error moves by for each unit that this one does.
        """
        column = [row[index] for row in self.rows]
        variance = column[index]
        part = (1 - kept) / variance
        for i, factor in enumerate(column):
            scaled = part * factor
            self.rows[i] = [p - scaled * q for p, q in zip(self.rows[i], column)]
        return [q / variance for q in column]


def _carried(m: Matrix, s: Segment) -> Matrix:
    """Return the matrix of the error's transition times m."""
    linear, angular = s.scales
    b, yaw, spread, slow = s.separation, m[YAW], m[SEPARATION], m[RAMP]
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
