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

from collections.abc import Iterator
from math import copysign, cos, degrees, inf, radians, sin, sqrt

from ...odometry import Estimate
from ..motion import Velocity
from .goal import Instruction, Phase, Progress, View

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


STRAIGHT = Velocity(1.0, 0.0)
"""The unit of a leg that is a straight line."""


class Leg:
    """One way, from where the robot is when the leg is made."""

    def __init__(self, view: View, unit: Velocity, way: float, top: float,
                 off: float = 0.0) -> None:
        """
        Drive a way, m of the faster wheel, at a top speed, m/s.

        `unit` is the robot's velocity while that wheel runs at 1 m/s. The robot heads `off`
        radians to the left of the line that it is to follow.
        """
        limits = view.limits
        self._view, self._unit = view, unit
        self._whole = self._left = way
        self.forward = unit.linear * way > 0
        """Whether it leads forward."""
        self.in_place = not unit.linear
        """Whether it is a turn in place."""
        self._pace = 0.0
        """m/s of the faster wheel, now."""
        self._aside, self._off = 0.0, off
        """Metres left of the line, and radians left of the line's direction."""
        self._top = min(top, limits.max_wheel_speed)
        self.allowed = self._top / top
        """Part of the top speed that `max_wheel_speed` allows."""
        self._tolerance = TURN_TOLERANCE / unit.angular if unit.angular else STRAIGHT_TOLERANCE
        self._learned = view.turning if unit.angular else view.straight
        most = [limit / abs(part) for limit, part in zip(
            (limits.linear_acceleration, limits.angular_acceleration), unit) if limit and part]
        self._up, self._down = min([ACCELERATION, *most]), min([BRAKING, *most])
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
        velocity = Velocity(speed * self._unit.linear, speed * self._unit.angular)
        if self.correcting:  # too short a way to steer
            return velocity
        return velocity._replace(angular=velocity.angular + self._steering(velocity.linear))

    def _steering(self, speed: float) -> float:
        """Return the rad/s that bring the robot back to its line at a speed along it, m/s."""
        if speed == 0.0:
            return 0.0
        wanted = -copysign(ASIDE_GAIN, speed) * self._aside
        wanted = max(-MAX_RETURN_ANGLE, min(MAX_RETURN_ANGLE, wanted))
        most = min(MAX_STEERING, MAX_CURVATURE * abs(speed))
        return max(-most, min(most, HEADING_GAIN * (wanted - self._off)))

    def seconds(self) -> float:
        """Return how long what is left takes at most, about."""
        ramps = self._top / 2 * (1 / self._up + 1 / self._down)
        settling = (1 + MAX_CORRECTIONS) * (MAX_SETTLE_TIME + PUSH_DISTANCE / self._creep)
        return abs(self._left) / self._top + ramps + settling

    def progress(self, phase: Phase | None = None) -> Progress:
        """Return what is left, in a phase of the goal."""
        if self._unit.angular:
            return Progress(angle=abs(self._left * self._unit.angular), phase=phase)
        return Progress(distance=abs(self._left), phase=phase)

    def way(self) -> str:
        """Say how far the robot has got."""
        went, angular = self._whole - self._left, self._unit.angular
        return f'{abs(degrees(went * angular)):.0f} degrees' if angular else f'{abs(went):.2f} m'

    def done(self) -> str:
        """Say what was done."""
        went, (linear, angular) = self._whole - self._left, self._unit
        if not angular:
            return f'drove {went:.3f} m'
        circle = f' on a radius of {abs(linear / angular):g} m' if linear else ''
        turned = went * angular
        return f'turned by {turned:.3f} rad ({degrees(turned):.1f} degrees){circle}'

    def _locate(self, estimate: Estimate) -> None:
        """Note where an estimate is, after that of `_view`, without corrections of before."""
        (way, turn), (last_way, last_turn) = estimate.trip, self._view.estimate.trip
        turned = turn - last_turn
        off = self._off + turned / 2
        along, aside = (way - last_way) * cos(off), (way - last_way) * sin(off)
        linear, angular = self._unit
        if angular:  # the line itself may turn
            went, self._pace = turned / angular, estimate.angular / angular
            variance = estimate.trip_variance[1] / angular ** 2
            turned -= along / (linear / angular - self._aside) if linear else turned
        else:
            went, self._pace, variance = along, estimate.linear, estimate.trip_variance[0]
        self._off += turned
        self._aside += aside
        self._left -= went
        self._least = min(self._least, variance)
        self._deviation = sqrt(max(0.0, variance - self._least))

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


def arc(view: View, angle: float, radius: float, direction: int, top: float) -> Leg:
    """
    Return a turn by an angle, rad, on a circle of a radius, m, at this many rad/s at most.

    The heading tells how far it is driven, steering keeps the radius; on a radius of 0 it is a
    turn in place. `direction` is 1 for forwards and -1 for backwards.
    """
    reach = radius + view.limits.wheel_separation / 2
    side = direction * copysign(1.0, angle)  # -1 where the centre is on the robot's right
    return Leg(view, Velocity(side * radius / reach, 1 / reach), angle * reach, top * reach)
