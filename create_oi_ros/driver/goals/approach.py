# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Speed along one way, so that the robot arrives and stops there.

The profile is a trapezoid, closed in every frame by the odometry.
A robot does not follow at once. What it still travels after its wheels were told to stand, its
coast, is its speed times a time that differs from robot to robot. So the profile brakes for the
place where a stop would leave the robot, the last centimetre is slow, and the coast is learned at
each stop. Where a stop left it short or too far, the robot creeps on, or back.
"""

from math import copysign, inf, sqrt
from typing import NamedTuple

COAST, SPREAD = 0.35, 0.12
"""Coast, s, that is assumed before it is learned, and its standard deviation. It is longer than
that of most robots, so that they stop short."""
LEAST_COAST, MOST_COAST = 0.03, 0.8
DRIFT, NOISE = 0.02, 0.002
"""Seconds by which the coast differs from stop to stop, and metres by which one is measured
wrongly."""
ACCELERATION, BRAKING = 0.5, 0.25
"""m/s² of a wheel."""
CREEP, CREEP_DISTANCE = 0.03, 0.01
"""m/s and m of a wheel at the end: slower, some robots do not move."""
DOUBT, MOST_DOUBT = 2.0, 0.08
"""Standard deviations by which the robot creeps earlier where the odometry is not sure of the way,
and metres at most."""
LAST = 0.05
"""Metres before the end in which the robot no longer speeds up."""
STUCK, FASTER = 0.7, 0.01
"""Seconds of creeping without motion after which a wheel creeps faster, and by how many m/s."""
FASTEST_CREEP = 0.08
"""m/s at most."""
UNMOVED = 0.25
"""A correction that makes less than this part of its way has moved nothing: the next is faster."""
STANDING = 0.004
"""m/s below which a wheel counts as standing."""
SETTLE, BLEND, LATEST = 0.15, 0.25, 1.4
"""Seconds of standing before a reading can confirm the place; seconds in which the odometry takes
that reading in; seconds of standing after which the robot waits no longer for one."""
NUDGE = 0.02
"""Metres up to which a correction is a push of a set length: its way is its speed times its
length, whatever the coast."""
PUSH_SPREAD, PUSH_DRIFT, PUSH_NOISE = 0.5, 0.1, 0.001
"""Standard deviations of the way of a push over its speed times its length, from robot to robot
and from push to push; and metres by which one is measured wrongly."""
LEAST_PUSH, MOST_PUSH = 0.3, 3.0
CORRECTIONS = 3
"""How often the robot creeps on or back at most."""


class Learned:
    """What one approach teaches the next, of one robot."""

    def __init__(self) -> None:
        self.coast = COAST
        """Seconds of its speed that the robot travels on after a stop."""
        self._variance = SPREAD ** 2
        self.push = 1.0
        """The way of a push over its speed times its length."""
        self._push_variance = PUSH_SPREAD ** 2

    def pushed(self, asked: float, way: float) -> None:
        """Learn from a push that was to lead a way `asked`, m, and led another."""
        gain = self._push_variance / (self._push_variance + (PUSH_NOISE / asked) ** 2)
        ratio = max(LEAST_PUSH, min(MOST_PUSH, way / asked * self.push))
        self.push += gain * (ratio - self.push)
        self._push_variance = self._push_variance * (1 - gain) + PUSH_DRIFT ** 2

    def stopped(self, pace: float, way: float) -> None:
        """Learn from a stop at a pace, m/s, after which the robot still travelled a way, m."""
        self._variance += DRIFT ** 2
        gain = self._variance / (self._variance + (NOISE / pace) ** 2)
        coast = max(LEAST_COAST, min(MOST_COAST, way / pace))
        self.coast += gain * (coast - self.coast)
        self._variance *= 1 - gain


class Remaining(NamedTuple):
    """What one frame says about the way; metres of a wheel, signed: behind is negative."""

    left: float
    """What is left of the way."""
    speed: float
    """m/s along it."""
    doubt: float
    """Standard deviation of what is left."""
    dt: float
    measured: bool
    """Whether the robot has just been asked how far it went."""


class Approach:
    """Speeds along one way; metres of a wheel for straight ways, arcs and turns alike."""

    def __init__(self, top: float, tolerance: float, learned: Learned, limit: float) -> None:
        """
        Approach at a top speed, m/s, and stop within a tolerance, m.

        `limit` is the highest acceleration, m/s²; 0: none is set.
        """
        self._top = top
        self._tolerance = tolerance
        self._learned = learned
        self._up = min(ACCELERATION, limit or ACCELERATION)
        self._down = min(BRAKING, limit or BRAKING)
        self._creep = min(CREEP, top)
        self._speed = 0.0
        self._sign = 0.0
        """Which way to go; 0 before the first step."""
        self._corrections = 0
        self._nudge: float | None = None
        """Seconds of a push that are left; None: the robot is not pushed."""
        self._corrected = 0.0
        """The way that the last correction was to lead, m; 0 before the first."""
        self._by_push = False
        """Whether that correction was a push."""
        self._standing = False
        """Whether the wheels were told to stand."""
        self._stood = self._crept = 0.0
        self._confirmed = inf
        """How long the wheels had stood when a reading came."""
        self._stopped: tuple[float, float] | None = None
        """Where and how fast the robot was when it was told to stand."""

    @property
    def correcting(self) -> bool:
        """Whether the robot creeps on or back, after a stop."""
        return self._corrected > 0

    @property
    def wants_reading(self) -> bool:
        """Whether the robot stands, and only a reading can tell where."""
        return self._standing and self._stood > SETTLE and self._confirmed == inf

    def seconds(self, way: float) -> float:
        """Return how long a way takes at most, about."""
        ramps = self._top / 2 * (1 / self._up + 1 / self._down)
        settling = (1 + CORRECTIONS) * (LATEST + NUDGE / self._creep)
        return abs(way) / self._top + ramps + settling

    def step(self, at: Remaining) -> float | None:
        """Return the speed for what is left of the way; None: the robot has arrived."""
        if not self._sign:
            if abs(at.left) <= self._tolerance:
                return None
            self._sign = copysign(1.0, at.left)
        if self._standing:
            return self._settle(at)
        if self._nudge is not None:
            return self._push(self._nudge, at.dt)
        ahead, pace = at.left * self._sign, max(0.0, at.speed * self._sign)
        coast = pace * self._learned.coast
        if ahead <= coast:
            self._stopped = (at.left, pace)
            return self._stand()
        return self._sign * self._run(ahead - coast, pace, at)

    def _run(self, ahead: float, pace: float, at: Remaining) -> float:
        doubt = min(DOUBT * at.doubt, MOST_DOUBT)
        room = max(ahead - CREEP_DISTANCE - doubt, 0.0)
        wanted = min(self._top, sqrt(self._creep ** 2 + 2 * self._down * room),
                     self._speed + self._up * at.dt)
        if self.correcting or room < LAST:
            wanted = min(wanted, self._speed)
        self._speed = max(wanted, self._creep)
        stuck = self._speed == self._creep and pace < STANDING
        self._crept = self._crept + at.dt if stuck else 0.0
        if self._crept > STUCK:
            self._crept, self._creep = 0.0, self._faster()
        return self._speed

    def _stand(self) -> float:
        self._standing, self._stood, self._speed = True, 0.0, 0.0
        self._confirmed, self._nudge = inf, None
        return 0.0

    def _push(self, left: float, dt: float) -> float:
        """Push for another frame, unless less than half of one is left."""
        if left <= dt / 2:
            return self._stand()
        self._nudge = left - dt
        return self._sign * self._creep

    def _settle(self, at: Remaining) -> float | None:
        """Wait until the robot stands and its place is known; then arrive, or go on."""
        self._stood = self._stood + at.dt if abs(at.speed) < STANDING else 0.0
        if at.measured and self._stood > SETTLE:
            self._confirmed = min(self._confirmed, self._stood)
        if self._stood < min(self._confirmed + BLEND, LATEST):
            return 0.0
        self._learn(at.left)
        if abs(at.left) <= self._tolerance or self._corrections >= CORRECTIONS:
            return None
        self._corrections += 1
        self._correct(at.left)
        return 0.0

    def _correct(self, left: float) -> None:
        """Begin to creep on, or back."""
        self._standing, self._sign, self._crept = False, copysign(1.0, left), 0.0
        self._corrected, self._by_push = abs(left), abs(left) < NUDGE
        if self._by_push:
            self._nudge = abs(left) / self._creep / self._learned.push

    def _learn(self, left: float) -> None:
        """Learn from the motion that has ended how far the robot coasts, and what moves it."""
        if self.correcting:
            self._learn_from_correction(self._corrected - left * self._sign)
        if self._stopped is not None:
            place, pace = self._stopped
            if pace > CREEP / 2:
                self._learned.stopped(pace, (place - left) * self._sign)
        self._stopped = None

    def _learn_from_correction(self, went: float) -> None:
        """Learn from a correction that led a way, m; creep faster where it has moved nothing."""
        if went < UNMOVED * self._corrected and self._creep < self._faster():
            self._creep = self._faster()
            self._corrections -= 1  # it was none
        elif self._by_push:
            self._learned.pushed(self._corrected, went)

    def _faster(self) -> float:
        """Return the next speed to creep at."""
        return min(self._creep + FASTER, FASTEST_CREEP, self._top)
