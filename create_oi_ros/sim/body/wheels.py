# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How a wheel's speed follows the speed that is asked of it: the response models.

Each model has a `speed`, m/s, on its way to the goal that `aim` notes. `roll` lets time pass and
returns the metres travelled; it is exact for at most the seconds that `horizon` returns.
docs/simulator_guesses.md lists what was measured of real robots: Creates answered like a
first-order lag, and coasted about 15 mm from any speed. The other models are for robots that
answer otherwise.
"""

from enum import Enum
import math
from random import Random
from typing import NamedTuple


class Response(Enum):
    """The kind of a wheel's answer to a step of its goal."""

    FIRST_ORDER = 'first_order'
    """The rest of the way shrinks by 1/e in each time constant (measured of one Create)."""
    SECOND_ORDER = 'second_order'
    """As a spring and a damper: it overshoots (measured of Create 2 robots)."""
    RAMP = 'ramp'
    """A constant acceleration."""


class TimeConstant(NamedTuple):
    """A time constant that depends on the speed by a power, held constant outside a range."""

    seconds: float
    """At REFERENCE_SPEED."""
    exponent: float = 0.0
    """0: the same at all speeds; 1: inversely proportional to the speed."""
    slowest: float = 0.05
    fastest: float = 0.5
    """m/s: the range of speeds between which it changes."""

    def at(self, speed: float) -> float:
        """Return the seconds at a speed, m/s."""
        bounded = min(self.fastest, max(self.slowest, speed))
        part: float = (REFERENCE_SPEED / bounded) ** self.exponent
        return self.seconds * part


REFERENCE_SPEED = 0.0665
"""m/s: there the Create that was filmed had 0.2 s (0.265 s at 0.05, 0.175 s at 0.076)."""
SPEED_TOLERANCE = 1e-6
"""m/s by which a lag may miss its goal and count as there."""
LONGEST_STEP = 0.004
"""Seconds within which an oscillating wheel may change the sign of its speed unseen."""
JITTER_PERIOD, WANDER_TIME = 0.1, 20.0
"""Seconds of motion for which an unsteady wheel keeps its factor, and in which its drift forgets
where it was."""
MAX_UNSTEADINESS, MIN_FACTOR = 0.1, 0.1
"""The most that may be asked of such a wheel, and the least factor that it ever has."""
TIME_TOLERANCE = 1e-9
"""Seconds by which a sum of times may miss a moment at which something begins or ends."""


class Lag:
    """First order: the speed error decays exponentially; braking `braking` times as fast."""

    def __init__(self, constant: TimeConstant, braking: float) -> None:
        self.speed = self._goal = 0.0
        self._constant, self._braking = constant, braking
        self._tau_of_goal = constant.at(0.0)
        """Seconds while it does not brake."""

    def aim(self, goal: float) -> None:
        self._goal = goal
        self._tau_of_goal = self._constant.at(max(abs(goal), abs(self.speed)))

    def horizon(self, longest: float) -> float:
        if self.speed == self._goal:
            return longest
        if self.speed * self._goal >= 0:
            return min(longest, LONGEST_STEP * 2)
        crossing = self._tau() * math.log1p(abs(self.speed / self._goal))
        return max(min(longest, crossing, LONGEST_STEP * 2), 1e-6)

    def roll(self, h: float) -> float:
        if self.speed == self._goal:
            return self._goal * h
        tau, rest = self._tau(), self.speed - self._goal
        kept = math.exp(-h / tau)
        travel = self._goal * h + rest * tau * (1 - kept)
        self.speed = self._goal + rest * kept
        if abs(rest * kept) < SPEED_TOLERANCE:
            self.speed = self._goal
        elif self._goal and abs(self.speed) < SPEED_TOLERANCE:
            self.speed = math.copysign(1e-12, self._goal)
        return travel

    def _tau(self) -> float:
        tau = self._tau_of_goal
        return tau / self._braking if brakes(self.speed, self._goal) else tau


class Spring:
    """Second order, underdamped: overshoots its goal by a part of the step."""

    def __init__(self, constant: TimeConstant, overshoot: float, braking: float) -> None:
        self.speed = self._goal = self._rate = 0.0
        self._constant, self._braking = constant, braking
        self._omega_of_goal = 1 / constant.at(0.0)
        """Natural frequency while it does not brake, rad/s."""
        log = math.log(max(1e-4, overshoot))
        self._damping = -log / math.hypot(math.pi, log)

    def aim(self, goal: float) -> None:
        self._goal = goal
        self._omega_of_goal = 1 / self._constant.at(max(abs(goal), abs(self.speed)))

    def horizon(self, longest: float) -> float:
        still = self.speed == self._goal and not self._rate
        return longest if still else min(longest, LONGEST_STEP)

    def roll(self, h: float) -> float:
        omega = self._omega_of_goal
        if brakes(self.speed, self._goal):
            omega *= self._braking
        decay = self._damping * omega
        swing = omega * math.sqrt(1 - self._damping ** 2)
        x, rate = self.speed - self._goal, self._rate
        a, b = x, (rate + decay * x) / swing
        shrunk, cos, sin = math.exp(-decay * h), math.cos(swing * h), math.sin(swing * h)
        after = shrunk * (a * cos + b * sin)
        rate_after = -decay * after + shrunk * swing * (b * cos - a * sin)
        travel = -((rate_after - rate) + 2 * decay * (after - x)) / omega ** 2
        self.speed, self._rate = self._goal + after, rate_after
        if abs(after) < SPEED_TOLERANCE and abs(rate_after) < SPEED_TOLERANCE / LONGEST_STEP:
            self.speed, self._rate = self._goal, 0.0
        return travel + self._goal * h


class Ramp:
    """Constant acceleration, m/s²; braking `braking` times as hard."""

    def __init__(self, acceleration: float, braking: float) -> None:
        self.speed = self._goal = 0.0
        self._limit, self._braking = acceleration, braking

    def aim(self, goal: float) -> None:
        self._goal = goal

    def horizon(self, longest: float) -> float:
        way = abs(self._next() - self.speed)
        return min(longest, max(way / self._rate(), 1e-9)) if way else longest

    def roll(self, h: float) -> float:
        goal = self._next()
        way = goal - self.speed
        change = math.copysign(min(abs(way), self._rate() * h), way)
        travel = (self.speed + change / 2) * h
        self.speed += change
        if abs(goal - self.speed) < 1e-9:
            self.speed = goal
        return travel

    def _next(self) -> float:
        """Return where the present ramp ends: at rest first where the wheel has to reverse."""
        return 0.0 if self.speed * self._goal < 0 else self._goal

    def _rate(self) -> float:
        return self._limit * (self._braking if brakes(self.speed, self._goal) else 1.0)


class Unsteady:
    """Another wheel, whose speed jitters from beat to beat and drifts within half a minute."""

    def __init__(self, wheel: Lag | Spring | Ramp, jitter: float, wander: float,
                 random: Random) -> None:
        self._wheel, self._random = wheel, random
        self._jitter, self._wander = jitter / math.sqrt(JITTER_PERIOD), wander
        self._drift = random.gauss(0.0, wander)
        self._draw()

    def _draw(self) -> None:
        self._left = JITTER_PERIOD
        kept = math.exp(-JITTER_PERIOD / WANDER_TIME)
        self._drift = (kept * self._drift
                       + self._random.gauss(0.0, self._wander * math.sqrt(1 - kept ** 2)))
        self._factor = max(
            MIN_FACTOR, 1 + self._drift + self._random.gauss(0.0, self._jitter))

    @property
    def speed(self) -> float:
        return self._wheel.speed * self._factor

    @speed.setter
    def speed(self, speed: float) -> None:
        self._wheel.speed = speed / self._factor

    def aim(self, goal: float) -> None:
        self._wheel.aim(goal)

    def horizon(self, longest: float) -> float:
        return self._wheel.horizon(min(longest, self._left))

    def roll(self, h: float) -> float:
        travel = self._wheel.roll(h) * self._factor
        self._left -= h
        if self._left < TIME_TOLERANCE:
            self._draw()
        return travel


def brakes(speed: float, goal: float) -> bool:
    """Tell whether a wheel on its way from a speed to a goal slows down."""
    return (goal - speed) * speed < 0
