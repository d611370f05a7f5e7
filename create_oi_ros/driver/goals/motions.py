# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals that drive: a distance, an angle, an arc, a place by the odometry; what ends them."""

from abc import abstractmethod
from collections.abc import Iterator
from math import atan2, hypot, radians, remainder, tau

from ... import oi
from ...robot import MILLI
from ..events import Cause
from ..mode import causes_in
from ..motion import BUMPS
from ..stream import requested_speeds
from .goal import (
    check_finite,
    check_range,
    Code,
    Goal,
    MAX_ANGLE,
    MAX_DISTANCE,
    MIN_SPEED,
    MIN_TURN_RATE,
    Order,
    Over,
    Phase,
    ROUNDING,
    View,
)
from .legs import arc, Leg, STRAIGHT, STRAIGHT_TOLERANCE

Legs = Iterator[tuple[Phase | None, Leg]]
MANY_TURNS = 4
"""Turns above which an angle may have been meant in degrees."""

# What ends a motion: the bumper, a cliff, a wheel that drops, wheels that do not follow.

DROPS = (Cause.WHEEL_DROP_LEFT, Cause.WHEEL_DROP_RIGHT, Cause.WHEEL_DROP_CASTER)
CLIFFS = {Cause.CLIFF_LEFT: 'on the left', Cause.CLIFF_FRONT_LEFT: 'at the front left',
          Cause.CLIFF_FRONT_RIGHT: 'at the front right', Cause.CLIFF_RIGHT: 'on the right'}
WHEELS = int(oi.Overcurrents.LEFT_WHEEL | oi.Overcurrents.RIGHT_WHEEL)
OVERLOAD_TIME = 0.5
"""Seconds for which a wheel must draw too much current to count as held."""
STALL_DISTANCE, MIN_FOLLOWED = 0.15, 0.3
"""Metres of a wheel after which it is compared with what was asked, and the least part of that
which a wheel that is not held travels."""
STALL_TIME = 2.0
"""Seconds over which it is compared at least."""
SIDES = {BUMPS: 'in front', int(oi.BumpsAndWheelDrops.BUMP_LEFT): 'on the left',
         int(oi.BumpsAndWheelDrops.BUMP_RIGHT): 'on the right'}
FROM_CLIFF = 'call set_mode with SAFE, then drive backwards'
"""Advice at a cliff, where the robot leaves Safe by itself."""
AGAIN = 'wait a second, then send the goal again'
TO_FLOOR = f'put the robot on the floor, {AGAIN}'
LIFTED = Over(Code.WHEEL_DROP, f'a wheel hangs in the air: {TO_FLOOR}')
NO_SPEED = Over(
    Code.STALL, 'max_wheel_speed is 0, or too little to turn a wheel: set the parameter to '
    f'{MIN_SPEED} m/s or more')


def bumps(readings: oi.Readings) -> int:
    """Return the bits of the bumper's halves that are pressed."""
    return int(readings.bumps_and_wheel_drops) & BUMPS


def dropped(readings: oi.Readings) -> bool:
    """Tell whether a wheel hangs in the air."""
    return any(cause in DROPS for cause in causes_in(readings))


class Stall:
    """
    Notices wheels that do not turn as the robot says that it was asked to turn them.

    How far they went is what the robot has counted, and what it may have dropped of that at each
    reading: a wheel that is slow, for whatever reason, is not taken for one that is held. Nor is
    one of which a reading was lost: all is counted anew from there.
    """

    def __init__(self) -> None:
        self._overloaded = 0.0
        self._restart()

    def _restart(self) -> None:
        self._asked = self._went = self._seconds = 0.0

    def check(self, view: View) -> Over | None:
        """Return what ends the motion."""
        readings, dt = view.readings, view.dt
        overloaded = readings.has('overcurrents') and int(readings.overcurrents) & WHEELS
        self._overloaded = self._overloaded + dt if overloaded else 0.0
        if self._overloaded > OVERLOAD_TIME:
            return Over(Code.STALL, 'a wheel draws too much current: is it held or blocked?')
        if view.lost:
            self._restart()
        self._asked += max(abs(speed or 0) for speed in requested_speeds(readings)) * MILLI * dt
        self._seconds += dt
        if not view.measured:
            return None
        turned = radians(abs(readings.angle) + 1) * view.limits.wheel_separation / 2
        self._went += (abs(readings.distance) + 1) * MILLI + turned
        if self._asked < STALL_DISTANCE or self._seconds < STALL_TIME:
            return None
        stalled = self._went < MIN_FOLLOWED * self._asked
        self._restart()
        if not stalled:
            return None
        return Over(Code.STALL, 'the wheels do not follow: are they held, or is the robot stuck?')


class MotionGoal(Goal):
    """
    A motion of one or more legs, each made when the one before has ended, until a hazard ends it.

    A cliff or a bump that is there when the motion begins does not end it while it leads away:
    backwards, or for the bumper in place. Once it has gone and come back, it does.
    """

    leg: Leg
    """The leg that was begun last."""

    def __init__(self, allowance: float, direction: int = 0, *, speed: float = MIN_SPEED,
                 turning: float = MIN_TURN_RATE) -> None:
        """
        Take the way that the motion leads first: 1 forward, -1 backward, 0 a turn.

        A goal that only drives, or only turns, needs one of the highest m/s and rad/s.
        """
        super().__init__(allowance)
        check_range('max_translation_speed', speed, 'm/s', MIN_SPEED)
        check_range('max_rotation_speed', turning, 'rad/s', MIN_TURN_RATE)
        self.speed, self.turning = speed, turning
        self.forward = direction > 0
        """Whether the motion leads forward now."""
        self.known_cliff, self.known_bump = direction < 0, True
        """Whether these have been there from the beginning."""
        self.stall = Stall()

    def hazard(self) -> Over | None:
        view, readings = self.view, self.view.readings
        if view.limits.max_wheel_speed < MIN_SPEED:
            return NO_SPEED
        if dropped(readings):
            return LIFTED
        cliffs = [CLIFFS[cause] for cause in causes_in(readings) if cause in CLIFFS]
        cliff, bump = bool(cliffs), bool(bumps(readings))
        self.known_cliff, self.known_bump = self.known_cliff and cliff, self.known_bump and bump
        if cliff and (self.forward or not self.known_cliff):
            return Over(Code.CLIFF, f'there is no floor {", ".join(cliffs)}: {FROM_CLIFF}')
        if bump and (self.forward or not self.known_bump):
            return Over(Code.BUMP, f'the bumper is pressed {SIDES[bumps(readings)]}: drive '
                        'backwards or turn away')
        return self.stall.check(view)

    def orders(self) -> Iterator[Order]:
        """Work out how long the motion may take, and follow one leg after the other."""
        self.allowance = self.allowance or 2 * sum(leg.seconds() for _, leg in self.legs())
        slowed: list[str] = []
        for phase, leg in self.legs():
            self.leg, self.forward = leg, leg.forward
            if self._slowed(leg) not in slowed:
                slowed.append(self._slowed(leg))
            while (order := leg.step(self.view)) is not None:
                self.progress = leg.progress(phase)
                yield order
        yield Over(Code.NONE, self.done() + ''.join(slowed))

    @abstractmethod
    def legs(self) -> Legs:
        """Yield the legs, each made where the robot is when its turn comes."""

    def _slowed(self, leg: Leg) -> str:
        """Say that a speed is too fast for a leg; empty where it is not."""
        name, speed, unit = (('max_rotation_speed', self.turning, 'rad/s') if leg.in_place else
                             ('max_translation_speed', self.speed, 'm/s'))
        return '' if leg.allowed * (1 + ROUNDING) >= 1 else (
            f'; slowed to {leg.allowed * speed:.2f} {unit}: {name} = {speed:g} is beyond '
            'max_wheel_speed')

    def way(self, seconds: float) -> str:
        return f'after {self.leg.way()}'

    def done(self) -> str:
        return self.leg.done()


class DriveDistance(MotionGoal):
    """Drive straight; a negative distance is backwards."""

    def __init__(self, distance: float, speed: float, allowance: float) -> None:
        """Take metres, m/s and seconds; ValueError says what no robot could follow."""
        check_range('distance', distance, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        super().__init__(allowance, (distance > 0) - (distance < 0), speed=speed)
        self._distance = distance

    def legs(self) -> Legs:
        yield None, Leg(self.view, STRAIGHT, self._distance, self.speed)


class RotateAngle(MotionGoal):
    """Turn in place, counter-clockwise; any number of turns."""

    def __init__(self, angle: float, speed: float, allowance: float) -> None:
        """Take radians, rad/s and seconds; ValueError says what no robot could follow."""
        super().__init__(allowance, turning=speed)
        self.hint = check_angle(angle)
        self._angle = angle

    def legs(self) -> Legs:
        yield None, arc(self.view, self._angle, 0.0, 1, self.turning)


class DriveArc(MotionGoal):
    """Drive on a circle; any number of turns."""

    def __init__(self, angle: float, radius: float, direction: int, speed: float,
                 allowance: float) -> None:
        """
        Turn by radians, counter-clockwise, on a radius, m, at m/s; seconds that it may take.

        `direction` is 1 for forwards and -1 for backwards. ValueError says what no robot could
        follow.
        """
        super().__init__(allowance, direction, speed=speed)
        self.hint = check_angle(angle)
        check_finite('radius', radius, 'm')
        if radius <= 0:
            raise ValueError(f'radius = {radius:g} m; allowed: above 0')
        check_range('length of the arc', angle * radius, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        if direction not in (1, -1):
            raise ValueError(f'translate_direction = {direction}; allowed: 1 forward, -1 backward')
        self._angle, self._radius, self._direction = angle, radius, direction

    def legs(self) -> Legs:
        yield None, arc(self.view, self._angle, self._radius, self._direction,
                        self.speed / self._radius)


class NavigateToPosition(MotionGoal):
    """Turn to a place, drive there straight, and turn to a heading."""

    def __init__(self, x: float, y: float, heading: float | None, speed: float, turning: float,
                 allowance: float) -> None:
        """
        Take a place, m, and a heading, rad, in the frame of the odometry; m/s, rad/s and seconds.

        A heading of None is any. ValueError says what no robot could follow.
        """
        check_range('goal_pose.position.x', x, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        check_range('goal_pose.position.y', y, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        check_finite('heading of goal_pose', heading or 0.0, 'rad')
        super().__init__(allowance, speed=speed, turning=turning)
        self._x, self._y, self._heading = x, y, heading

    def legs(self) -> Legs:
        """Yield a turn and a straight line to the place, unless the robot is there, and a turn."""
        far, direction = self._to_place()
        if far > STRAIGHT_TOLERANCE:
            yield Phase.TURNING_TO_PLACE, self._turn_to(direction)
            far, direction = self._to_place()
            yield Phase.DRIVING, Leg(
                self.view, STRAIGHT, far, self.speed, self._left_of(direction))
        if self._heading is not None:
            yield Phase.TURNING_TO_HEADING, self._turn_to(self._heading)

    def _turn_to(self, heading: float) -> Leg:
        return arc(self.view, -self._left_of(heading), 0.0, 1, self.turning)

    def _left_of(self, heading: float) -> float:
        """Return by how many rad the robot heads to the left of a heading."""
        return remainder(self.view.estimate.yaw - heading, tau)

    def _to_place(self) -> tuple[float, float]:
        """Return how far the place is, m, and in which direction, rad."""
        x, y = self._x - self.view.estimate.x, self._y - self.view.estimate.y
        return hypot(x, y), atan2(y, x)

    def way(self, seconds: float) -> str:
        return f'{self._to_place()[0]:.2f} m from the goal'

    def done(self) -> str:
        at = self.view.estimate
        far, _ = self._to_place()
        return f'at x {at.x:.3f} m, y {at.y:.3f} m, {far:.3f} m from the goal'


def check_angle(angle: float) -> str:
    """Refuse radians that no robot could turn; return what may be a mistake, else nothing."""
    check_range('angle', angle, 'rad', -MAX_ANGLE, MAX_ANGLE)
    turns = abs(angle) / tau
    return f'{angle:g} rad is {turns:.1f} turns: degrees?' if turns > MANY_TURNS else ''
