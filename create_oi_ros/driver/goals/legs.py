# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The ways that motions are made of: a straight line, and a part of a circle or a turn in place.

A leg measures what is left of it and steers along it, by the odometry. All its lengths are metres
of the faster wheel, so that one profile of speeds fits all. The profile is a trapezoid, closed in
every frame by the odometry.

A robot does not follow at once. What it still travels after its wheels were told to stand, its
coast, is its speed times a time that differs from robot to robot. So the profile brakes for the
place where a stop would leave the robot, the last centimetre is slow, and the coast is learned at
each stop. Where a stop left it short or too far, the robot creeps on, or back.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from math import copysign, cos, degrees, inf, radians, remainder, sin, sqrt, tau

from ...odometry import Estimate
from ..motion import Velocity
from .goal import Instruction, Phase, Progress, StoppingModel, View

STRAIGHT_TOLERANCE, TURN_TOLERANCE = 0.002, radians(0.5)
"""m and rad."""
HEADING_GAIN, ASIDE_GAIN = 2.0, 4.0
"""rad/s per radian, and radians per metre, by which a robot is steered back to its line."""
MAX_RETURN_ANGLE = 0.5
"""Radians at most at which a robot drives back to its line."""
MAX_STEERING, MAX_CURVATURE = 0.8, 4.0
"""rad/s of steering at most, and rad/s per m/s."""

ACCELERATION, BRAKING = 0.5, 0.25
"""m/s² of a wheel."""
CREEP, CREEP_DISTANCE = 0.03, 0.01
"""m/s and m of a wheel at the end: slower, some robots do not move."""
UNCERTAINTY_GAIN, MAX_UNCERTAINTY = 2.0, 0.08
"""Standard deviations by which the robot creeps earlier where the odometry is not sure of the way,
and metres at most."""
FINAL_DISTANCE = 0.05
"""Metres before the end in which the robot no longer speeds up."""
STUCK, STUCK_TIME, CREEP_STEP = 0.3, 0.7, 0.01
"""Part of its speed below which a wheel that creeps does not move; seconds after which it creeps
faster then, and by how many m/s."""
MAX_CREEP = 0.08
"""m/s at most."""
MIN_CORRECTED = 0.25
"""A correction that makes less than this part of its way has moved nothing: the next is faster."""
STANDSTILL = 0.004
"""m/s below which a wheel counts as standing."""
SETTLE_TIME, MAX_SETTLE_TIME = 0.15, 1.4
"""Seconds of standing before a reading can confirm the place, and after which the robot waits no
longer for one."""
PUSH_DISTANCE = 0.02
"""Metres up to which a correction is a push of a set length: its way is its speed times its
length, whatever the coast."""
MAX_CORRECTIONS = 3
"""How often the robot creeps on or back at most."""


class Leg(ABC):
    """One way, from where the robot is when the leg is made."""

    forward = False
    """Whether it leads forward."""
    in_place = False
    """Whether it is a turn in place."""

    def __init__(self, view: View, way: float, top: float, tolerance: float, limit: float,
                 learned: StoppingModel) -> None:
        """
        Drive a way, m of the faster wheel, at a top speed, m/s, and stop within a tolerance, m.

        `limit` is the highest acceleration of that wheel, m/s²; 0: none is set.
        """
        self._view = view
        self._whole = self._left = way
        self._pace = 0.0
        """m/s of the faster wheel, now."""
        self._aside = self._off = 0.0
        """Metres left of the line, and radians left of the line's direction."""
        self._top = min(top, view.limits.max_wheel_speed)
        self.allowed = self._top / top
        """Part of the top speed that `max_wheel_speed` allows."""
        self._tolerance = tolerance
        self._learned = learned
        self._up = min(ACCELERATION, limit or ACCELERATION)
        self._down = min(BRAKING, limit or BRAKING)
        self._creep = min(CREEP, self._top)
        self.correcting = False
        """Whether the robot creeps on or back, after a stop."""
        self._least = inf
        """The least variance of the odometry since the start, m²."""
        self._deviation = 0.0
        """Standard deviation of what is left, m."""
        self._speeds = self._arrive()

    def step(self, view: View) -> Velocity | Instruction | None:
        """Return the velocity until the next frame, or MEASURE; None: the robot is there."""
        self._locate(view.estimate)
        self._view = view
        speed = next(self._speeds, None)
        if not isinstance(speed, float):
            return speed
        velocity = self._velocity(speed)
        if self.correcting:  # too short a way to steer
            return velocity
        return velocity._replace(angular=velocity.angular + steering(
            velocity.linear, self._aside, self._off))

    def seconds(self) -> float:
        """Return how long what is left takes at most, about."""
        ramps = self._top / 2 * (1 / self._up + 1 / self._down)
        settling = (1 + MAX_CORRECTIONS) * (MAX_SETTLE_TIME + PUSH_DISTANCE / self._creep)
        return abs(self._left) / self._top + ramps + settling

    @abstractmethod
    def progress(self, phase: Phase | None = None) -> Progress:
        """Return what is left, in a phase of the goal."""

    @abstractmethod
    def way(self) -> str:
        """Say how far the robot has got."""

    @abstractmethod
    def done(self) -> str:
        """Say what was done."""

    def _locate(self, estimate: Estimate) -> None:
        """Note where an estimate is, after that of `_view`, without corrections of before."""
        (way, turn), (last_way, last_turn) = estimate.trip, self._view.estimate.trip
        turned = turn - last_turn
        off = self._off + turned / 2
        along, aside = (way - last_way) * cos(off), (way - last_way) * sin(off)
        self._off += turned - self._bend(along, turned)  # the line itself may turn
        self._aside += aside
        went, self._pace, variance = self._of_wheel(estimate, along, turned)
        self._left -= went
        self._least = min(self._least, variance)
        self._deviation = sqrt(max(0.0, variance - self._least))

    @abstractmethod
    def _bend(self, along: float, turned: float) -> float:
        """Return by how many rad the line turns where the robot goes m along it and turns rad."""

    @abstractmethod
    def _of_wheel(self, at: Estimate, along: float, turned: float) -> tuple[float, float, float]:
        """Return m of the faster wheel for m along the line and rad; its m/s; variance, m²."""

    @abstractmethod
    def _velocity(self, speed: float) -> Velocity:
        """Return the velocity for a speed along the leg."""

    def _arrive(self) -> Iterator[float | Instruction]:
        """Yield the speed for each frame until the robot has arrived."""
        if abs(self._left) <= self._tolerance:
            return
        yield from self._drive(copysign(1.0, self._left))
        corrections = 0
        while abs(left := self._left) > self._tolerance and corrections < MAX_CORRECTIONS:
            self.correcting = True
            yield 0.0
            sign = copysign(1.0, left)
            yield from self._push(left) if abs(left) < PUSH_DISTANCE else self._drive(sign)
            went = (left - self._left) * sign
            if went < MIN_CORRECTED * abs(left) and self._creep < self._faster():
                self._creep = self._faster()  # and it was no correction
                continue
            corrections += 1

    def _drive(self, sign: float) -> Iterator[float | Instruction]:
        """Drive until a stop leaves the robot at the end of the way; stop, and learn the coast."""
        speed = crept = 0.0
        while True:
            pace, ahead = max(0.0, self._pace * sign), self._left * sign
            coast = pace * self._learned.coast
            if ahead <= coast:
                break
            unsure = min(UNCERTAINTY_GAIN * self._deviation, MAX_UNCERTAINTY)
            room = max(ahead - coast - CREEP_DISTANCE - unsure, 0.0)
            wanted = min(self._top, sqrt(self._creep ** 2 + 2 * self._down * room),
                         speed + self._up * self._view.dt)
            if self.correcting or room < FINAL_DISTANCE:
                wanted = min(wanted, speed)
            speed = max(wanted, self._creep)
            stuck = speed == self._creep and pace < STUCK * speed
            crept = crept + self._view.dt if stuck else 0.0
            if crept > STUCK_TIME:
                crept, self._creep = 0.0, self._faster()
            yield sign * speed
        yield from self._settle()
        if pace > CREEP / 2:
            self._learned.stopped(pace, ahead - self._left * sign)

    def _push(self, way: float) -> Iterator[float | Instruction]:
        """Push the robot a short way, m: for a set time, rounded to frames."""
        left = abs(way) / self._creep
        while left > self._view.dt / 2:
            left -= self._view.dt
            yield copysign(self._creep, way)
        yield from self._settle()

    def _settle(self) -> Iterator[float | Instruction]:
        """Stop, and wait until the robot stands and its place is known."""
        yield 0.0
        stood, confirmed = 0.0, inf
        while True:
            stood = stood + self._view.dt if abs(self._pace) < STANDSTILL else 0.0
            if self._view.measured and stood > SETTLE_TIME:
                confirmed = min(confirmed, stood)
            if stood >= min(confirmed, MAX_SETTLE_TIME):
                return
            yield Instruction.MEASURE if stood > SETTLE_TIME and confirmed == inf else 0.0

    def _faster(self) -> float:
        """Return the next speed to creep at."""
        return min(self._creep + CREEP_STEP, MAX_CREEP, self._top)


class Straight(Leg):
    """A straight line, forwards or backwards."""

    def __init__(self, view: View, distance: float, heading: float, top: float) -> None:
        """Drive a distance, m, along a heading, rad, at m/s at most; negative: backwards."""
        super().__init__(view, distance, top, STRAIGHT_TOLERANCE,
                         view.limits.linear_acceleration, view.straight)
        self.forward = distance > 0
        self._off = remainder(view.estimate.yaw - heading, tau)

    def progress(self, phase: Phase | None = None) -> Progress:
        return Progress(distance=abs(self._left), phase=phase)

    def way(self) -> str:
        return f'{abs(self._whole - self._left):.2f} m'

    def done(self) -> str:
        return f'drove {self._whole - self._left:.3f} m'

    def _bend(self, along: float, turned: float) -> float:
        return 0.0

    def _of_wheel(self, at: Estimate, along: float, turned: float) -> tuple[float, float, float]:
        return along, at.linear, at.trip_variance[0]

    def _velocity(self, speed: float) -> Velocity:
        return Velocity(speed, 0.0)


class Arc(Leg):
    """
    A part of a circle: the heading tells how far it is driven, steering keeps the radius.

    On a radius of 0 it is a turn in place.
    """

    def __init__(self, view: View, angle: float, radius: float, direction: int,
                 top: float) -> None:
        """
        Turn by an angle, rad, on a circle of a radius, m, at this many rad/s at most.

        `direction` is 1 for forwards and -1 for backwards.
        """
        limits = view.limits
        self._reach = radius + limits.wheel_separation / 2
        caps = [limits.angular_acceleration * self._reach]
        if radius:
            caps.append(limits.linear_acceleration / radius * self._reach)
        super().__init__(view, angle * self._reach, top * self._reach,
                         TURN_TOLERANCE * self._reach, min(filter(None, caps), default=0.0),
                         view.turning)
        self.forward, self.in_place = radius > 0 and direction > 0, radius == 0
        self._radius = radius
        self._side = direction * copysign(1.0, angle)
        """1 where the circle's centre is on the robot's left, -1 on its right."""

    @property
    def _turned(self) -> float:
        return (self._whole - self._left) / self._reach

    def progress(self, phase: Phase | None = None) -> Progress:
        return Progress(angle=abs(self._left / self._reach), phase=phase)

    def way(self) -> str:
        return f'{abs(degrees(self._turned)):.0f} degrees'

    def done(self) -> str:
        circle = f' on a radius of {self._radius:g} m' if self._radius else ''
        return f'turned by {self._turned:.3f} rad ({degrees(self._turned):.1f} degrees){circle}'

    def _bend(self, along: float, turned: float) -> float:
        if not self._radius:
            return turned
        return self._side * along / (self._radius - self._side * self._aside)

    def _of_wheel(self, at: Estimate, along: float, turned: float) -> tuple[float, float, float]:
        return (turned * self._reach, at.angular * self._reach,
                at.trip_variance[1] * self._reach ** 2)

    def _velocity(self, speed: float) -> Velocity:
        angular = speed / self._reach
        return Velocity(angular * self._side * self._radius, angular)


def steering(speed: float, aside: float, off: float) -> float:
    """
    Return the rad/s that bring a robot back to its line while it drives at a speed, m/s.

    It is `aside` metres left of the line, and `off` radians left of the line's direction.
    """
    if speed == 0.0:
        return 0.0
    wanted = max(-MAX_RETURN_ANGLE, min(MAX_RETURN_ANGLE, -copysign(ASIDE_GAIN, speed) * aside))
    most = min(MAX_STEERING, MAX_CURVATURE * abs(speed))
    return max(-most, min(most, HEADING_GAIN * (wanted - off)))
