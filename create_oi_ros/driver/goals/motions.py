# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals that lead somewhere by the odometry: a distance, an angle, an arc, a place."""

from abc import abstractmethod
from collections.abc import Iterator
from math import atan2, degrees, hypot, remainder, tau
from typing import NamedTuple

from ...odometry import Estimate
from ..events import MotionLimits
from ..motion import Velocity
from .approach import Learned
from .goal import (
    check_amount,
    check_number,
    check_positive,
    check_speed,
    check_turning,
    Code,
    Goal,
    LEAST_SPEED,
    LONGEST,
    Malformed,
    MOST_TURN,
    Order,
    Over,
    Phase,
    Progress,
    ROUNDING,
    View,
)
from .hazards import Hazards, NO_SPEED, Stall
from .legs import Arc, Leg, Straight, STRAIGHT_TOLERANCE, Turn

Legs = Iterator[tuple[Phase | None, Leg]]
MANY_TURNS = 4
"""Turns above which an angle may have been meant in degrees."""


class MotionGoal(Goal):
    """A motion of one or more legs; each is made when the one before has ended."""

    def __init__(self, allowance: float, learned: Learned, *, ahead: bool = False,
                 back: bool = False) -> None:
        """`ahead` and `back` tell which way the motion leads first; neither for a turn."""
        super().__init__(allowance)
        self._learned = learned
        self._ahead, self._back = ahead, back
        self._hazards, self._stall = Hazards(), Stall()
        self._told = Velocity()
        self._at = Estimate()
        """x, y and yaw at the start."""
        self._slowed = ''
        self._legs: Legs = iter(())
        self._phase: Phase | None = None
        self._leg: Leg | None = None

    def begin(self, view: View) -> Over | None:
        """Start here, unless something is in the way."""
        limits = view.limits
        if limits.max_wheel_speed < LEAST_SPEED:
            return NO_SPEED
        self._at = view.estimate
        self._slowed = ''.join(self._slower(limits))
        self._legs = self._plan(limits)
        if self.allowance == 0:
            self.allowance = 2 * sum(leg.seconds() for leg in self._foreseen(limits))
        return self._hazards.begin(view, forward=self._ahead, backward=self._back)

    def step(self, view: View) -> Order:
        """Follow the present leg; after the last one the goal is over."""
        forward = self._leg is not None and self._leg.forward
        over = self._hazards.check(view, forward=forward) or self._stall.check(view, self._told)
        if over is not None:
            return over
        self._at = view.estimate
        while self._leg is None or (velocity := self._leg.step(view)) is None:
            following = next(self._legs, None)
            if following is None:
                return Over(Code.NONE, self._done() + self._slowed)
            self._phase, self._leg = following
        self._told = velocity
        return velocity

    @property
    def progress(self) -> Progress:
        """What is left of the present leg."""
        if self._leg is None:
            return Progress()
        return Progress(abs(self._leg.distance), abs(self._leg.angle), self._phase)

    @property
    def wants_reading(self) -> bool:
        """Whether the present leg cannot tell whether it is at its end."""
        return self._leg is not None and self._leg.wants_reading

    @abstractmethod
    def _plan(self, limits: MotionLimits) -> Legs:
        """Yield the legs, each made where the robot is when its turn comes."""

    @abstractmethod
    def _done(self) -> str:
        """Say what was done."""

    def way(self, seconds: float) -> str:
        """Say how far the robot has got."""
        return 'at the start' if self._leg is None else self._went()

    @abstractmethod
    def _went(self) -> str:
        """Say how far the robot has got on its first leg or a later one."""

    @abstractmethod
    def _slower(self, limits: MotionLimits) -> list[str]:
        """Say which speeds are too fast, and what is used instead."""

    def _foreseen(self, limits: MotionLimits) -> list[Leg]:
        """Return the legs as they are known at the start, for how long they take."""
        return [leg for _, leg in self._plan(limits)]


class DriveDistance(MotionGoal):
    """Drive straight; a negative distance is backwards."""

    def __init__(self, distance: float, speed: float, allowance: float,
                 learned: Learned) -> None:
        """Take metres, m/s and seconds; Malformed says what no robot could follow."""
        check_amount('distance', distance, LONGEST, 'm')
        check_speed(speed)
        super().__init__(allowance, learned, ahead=distance > 0, back=distance < 0)
        self._distance, self._speed = distance, speed

    def _plan(self, limits: MotionLimits) -> Legs:
        yield None, Straight(
            self._at, self._distance, self._at.yaw, self._speed, self._learned, limits)

    def _done(self) -> str:
        return f'drove {self._distance - _left(self._leg).distance:.3f} m'

    def _went(self) -> str:
        return f'after {abs(self._distance - _left(self._leg).distance):.2f} m'

    def _slower(self, limits: MotionLimits) -> list[str]:
        return slower('max_translation_speed', self._speed, limits.max_wheel_speed, 'm/s')


class RotateAngle(MotionGoal):
    """Turn in place, counter-clockwise; any number of turns."""

    def __init__(self, angle: float, speed: float, allowance: float, learned: Learned) -> None:
        """Take radians, rad/s and seconds; Malformed says what no robot could follow."""
        check_amount('angle', angle, MOST_TURN, 'rad')
        self.hint = degrees_meant(angle)
        check_turning(speed)
        super().__init__(allowance, learned)
        self._angle, self._speed = angle, speed

    def _plan(self, limits: MotionLimits) -> Legs:
        yield None, Turn(self._at, self._angle, self._speed, self._learned, limits)

    def _done(self) -> str:
        return f'turned by {_angle(self._angle - _left(self._leg).angle)}'

    def _went(self) -> str:
        return _after(self._angle - _left(self._leg).angle)

    def _slower(self, limits: MotionLimits) -> list[str]:
        return slower('max_rotation_speed', self._speed, fastest_turn(limits), 'rad/s')


class Circle(NamedTuple):
    """A part of a circle."""

    angle: float
    """Radians by which the robot turns, counter-clockwise."""
    radius: float
    """Metres."""
    direction: int
    """1 for forwards, -1 for backwards."""


class DriveArc(MotionGoal):
    """Drive on a circle."""

    def __init__(self, circle: Circle, speed: float, allowance: float, learned: Learned) -> None:
        """Take a circle, m/s and seconds; Malformed says what no robot could follow."""
        check_amount('angle', circle.angle, MOST_TURN, 'rad')
        self.hint = degrees_meant(circle.angle)
        check_positive('radius', circle.radius, 'm')
        check_amount('length of the arc', circle.angle * circle.radius, LONGEST, 'm')
        check_speed(speed)
        if circle.direction not in (1, -1):
            raise Malformed(f'translate_direction = {circle.direction}; allowed: 1 forward, '
                            '-1 backward')
        super().__init__(allowance, learned, ahead=circle.direction == 1,
                         back=circle.direction == -1)
        self._circle, self._speed = circle, speed

    def _plan(self, limits: MotionLimits) -> Legs:
        yield None, Arc(self._at, *self._circle, self._speed, self._learned, limits)

    def _done(self) -> str:
        return (f'turned by {_angle(self._circle.angle - _left(self._leg).angle)} on a radius of '
                f'{self._circle.radius:g} m')

    def _went(self) -> str:
        return _after(self._circle.angle - _left(self._leg).angle)

    def _slower(self, limits: MotionLimits) -> list[str]:
        radius = self._circle.radius
        most = limits.max_wheel_speed * radius / (radius + limits.wheel_separation / 2)
        return slower('max_translation_speed', self._speed, most, 'm/s')


class TargetPose(NamedTuple):
    """Where to go, in the frame of the odometry."""

    x: float
    y: float
    heading: float | None = None
    """Radians; None: any."""


class NavigateToPosition(MotionGoal):
    """Turn to a place, drive there straight, and turn to a heading."""

    def __init__(self, place: TargetPose, speed: float, turning: float, allowance: float,
                 learned: Learned, learned_turning: Learned) -> None:
        """Take a place, m/s, rad/s and seconds; Malformed says what no robot could follow."""
        check_amount('goal_pose.position.x', place.x, LONGEST, 'm')
        check_amount('goal_pose.position.y', place.y, LONGEST, 'm')
        check_number('heading of goal_pose', place.heading or 0.0, 'rad')
        check_speed(speed)
        check_turning(turning)
        super().__init__(allowance, learned)
        self._place, self._speed, self._turning = place, speed, turning
        self._learned_turning = learned_turning

    def _plan(self, limits: MotionLimits) -> Legs:
        x, y, heading = self._place
        if hypot(x - self._at.x, y - self._at.y) > STRAIGHT_TOLERANCE:
            direction = atan2(y - self._at.y, x - self._at.x)
            yield Phase.TURNING_TO_PLACE, self._turn_to(direction, limits)
            at = self._at
            direction = atan2(y - at.y, x - at.x)
            yield Phase.DRIVING, Straight(at, hypot(x - at.x, y - at.y), direction, self._speed,
                                          self._learned, limits)
        if heading is not None:
            yield Phase.TURNING_TO_HEADING, self._turn_to(heading, limits)

    def _turn_to(self, heading: float, limits: MotionLimits) -> Turn:
        angle = remainder(heading - self._at.yaw, tau)
        return Turn(self._at, angle, self._turning, self._learned_turning, limits)

    def _done(self) -> str:
        return f'at x {self._at.x:.3f} m, y {self._at.y:.3f} m, {self._far:.3f} m from the goal'

    def _went(self) -> str:
        return f'{self._far:.2f} m from the goal'

    @property
    def _far(self) -> float:
        return hypot(self._place.x - self._at.x, self._place.y - self._at.y)

    def _slower(self, limits: MotionLimits) -> list[str]:
        return [
            *slower('max_translation_speed', self._speed, limits.max_wheel_speed, 'm/s'),
            *slower('max_rotation_speed', self._turning, fastest_turn(limits), 'rad/s')]


def fastest_turn(limits: MotionLimits) -> float:
    """Return the rad/s at which both wheels run at their limit."""
    return 2 * limits.max_wheel_speed / limits.wheel_separation


def slower(name: str, speed: float, most: float, unit: str) -> list[str]:
    """Say that a speed is too fast; nothing where it is not."""
    if speed <= most * (1 + ROUNDING):
        return []
    return [f'; slowed to {most:.2f} {unit}: {name} = {speed:g} is beyond max_wheel_speed']


def degrees_meant(angle: float) -> str:
    """Ask whether an angle in rad of many turns was meant in degrees; empty where it is usual."""
    turns = abs(angle) / tau
    return f'{angle:g} rad is {turns:.1f} turns: degrees?' if turns > MANY_TURNS else ''


def _left(leg: Leg | None) -> Leg:
    assert leg is not None
    return leg


def _after(radians: float) -> str:
    return f'after {abs(degrees(radians)):.0f} degrees'


def _angle(radians: float) -> str:
    return f'{radians:.3f} rad ({degrees(radians):.1f} degrees)'
