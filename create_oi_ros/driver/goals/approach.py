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
"""Seconds of coasting before it is learned, longer than most, so that robots stop short; and their
standard deviation."""
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
"""Seconds of creeping without motion after which a wheel creeps faster, and m/s by which."""
FASTEST_CREEP = 0.08
STANDING = 0.004
"""m/s below which a wheel counts as standing."""
SETTLE, BLEND, LATEST = 0.15, 0.25, 1.4
"""Seconds of standing after which a reading confirms the place; in which the odometry takes it in;
and after which none is waited for."""
NUDGE = 0.02
"""Metres up to which a correction is a push of a set length: its way is its speed times its
length, whatever the coast."""
CORRECTIONS = 3
"""How often the robot creeps on or back at most."""


class Learned:
    """What one approach teaches the next, of one robot."""

    def __init__(self) -> None:
        self.coast = COAST
        """Seconds of its speed that the robot travels on after a stop."""
        self._variance = SPREAD ** 2

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
        return self._corrections > 0

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
            self._crept, self._creep = 0.0, min(self._creep + FASTER, FASTEST_CREEP, self._top)
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
        self._standing, self._sign, self._crept = False, copysign(1.0, at.left), 0.0
        if abs(at.left) < NUDGE:
            self._nudge = abs(at.left) / self._creep
        return 0.0

    def _learn(self, left: float) -> None:
        """Learn how far the robot coasted."""
        if self._stopped is not None:
            place, pace = self._stopped
            if pace > CREEP / 2:
                self._learned.stopped(pace, (place - left) * self._sign)
        self._stopped = None
