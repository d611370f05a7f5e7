# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals that lead somewhere by the odometry: a distance, an angle, an arc, a place."""

from abc import abstractmethod
from collections.abc import Iterator
from math import atan2, degrees, hypot, remainder, tau
from typing import NamedTuple

from ..events import MotionLimits
from .goal import (
    check_finite,
    check_range,
    check_speed,
    check_turning,
    Code,
    DrivingGoal,
    Malformed,
    MAX_ANGLE,
    MAX_DISTANCE,
    Order,
    Over,
    Phase,
    Progress,
    ROUNDING,
)
from .legs import Arc, Leg, StoppingModel, Straight, STRAIGHT_TOLERANCE

Legs = Iterator[tuple[Phase | None, Leg]]
MANY_TURNS = 4
"""Turns above which an angle may have been meant in degrees."""


class MotionGoal(DrivingGoal):
    """A motion of one or more legs; each is made when the one before has ended."""

    _leg: Leg | None = None
    """The leg that was begun last."""

    def obstacle(self) -> Over | None:
        """Return why the motion cannot begin; work out how long it may take."""
        over = super().obstacle()
        if over is None and self.allowance == 0:
            self.allowance = 2 * sum(leg.seconds() for _, leg in self._legs())
        return over

    def orders(self) -> Iterator[Order]:
        """Follow one leg after the other."""
        slowed = self._slowed(self.view.limits)
        for phase, leg in self._legs():
            self._leg, self.forward = leg, leg.forward
            while (order := leg.step(self.view)) is not None:
                self.progress = Progress(abs(leg.distance), abs(leg.angle), phase)
                yield order
        yield Over(Code.NONE, self._done() + slowed)

    @abstractmethod
    def _legs(self) -> Legs:
        """Yield the legs, each made where the robot is when its turn comes."""

    @abstractmethod
    def _slowed(self, limits: MotionLimits) -> str:
        """Say which speeds are too fast, and what is used instead; empty where none is."""

    def way(self, seconds: float) -> str:
        """Say how far the robot has got."""
        return 'at the start' if self._leg is None else self._went()

    @abstractmethod
    def _went(self) -> str:
        """Say how far the robot has got, on its first leg or a later one."""

    @abstractmethod
    def _done(self) -> str:
        """Say what was done, after the last leg."""

    @property
    def _present(self) -> Leg:
        assert self._leg is not None
        return self._leg


class DriveDistance(MotionGoal):
    """Drive straight; a negative distance is backwards."""

    def __init__(self, distance: float, speed: float, allowance: float,
                 learned: StoppingModel) -> None:
        """Take metres, m/s and seconds; Malformed says what no robot could follow."""
        check_range('distance', distance, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        check_speed(speed)
        super().__init__(allowance, (distance > 0) - (distance < 0))
        self._distance, self._speed, self._learned = distance, speed, learned

    def _legs(self) -> Legs:
        at = self.view.estimate
        yield None, Straight(
            at, self._distance, at.yaw, self._speed, self._learned, self.view.limits)

    def _slowed(self, limits: MotionLimits) -> str:
        return slowed('max_translation_speed', self._speed, limits.max_wheel_speed, 'm/s')

    def _went(self) -> str:
        return f'after {abs(self._distance - self._present.distance):.2f} m'

    def _done(self) -> str:
        return f'drove {self._distance - self._present.distance:.3f} m'


class Circle(NamedTuple):
    """A part of a circle."""

    angle: float
    """Radians by which the robot turns, counter-clockwise."""
    radius: float
    """Metres; 0: it turns in place."""
    direction: int
    """1 for forwards, -1 for backwards."""


class TurningGoal(MotionGoal):
    """A turn by an angle, in place or on a circle; any number of turns."""

    def __init__(self, circle: Circle, turning: float, allowance: float,
                 learned: StoppingModel) -> None:
        """Take a circle, rad/s and seconds."""
        super().__init__(allowance, circle.direction if circle.radius else 0)
        self._circle, self._turning, self._learned = circle, turning, learned
        turns = abs(circle.angle) / tau
        if turns > MANY_TURNS:
            self.hint = f'{circle.angle:g} rad is {turns:.1f} turns: degrees?'

    def _legs(self) -> Legs:
        yield None, Arc(self.view.estimate, *self._circle, self._turning, self._learned,
                        self.view.limits)

    def _went(self) -> str:
        return f'after {abs(degrees(self._circle.angle - self._present.angle)):.0f} degrees'

    def _done(self) -> str:
        turned = self._circle.angle - self._present.angle
        return f'turned by {turned:.3f} rad ({degrees(turned):.1f} degrees)'


class RotateAngle(TurningGoal):
    """Turn in place, counter-clockwise."""

    def __init__(self, angle: float, speed: float, allowance: float,
                 learned: StoppingModel) -> None:
        """Take radians, rad/s and seconds; Malformed says what no robot could follow."""
        check_range('angle', angle, 'rad', -MAX_ANGLE, MAX_ANGLE)
        check_turning(speed)
        super().__init__(Circle(angle, 0.0, 1), speed, allowance, learned)

    def _slowed(self, limits: MotionLimits) -> str:
        return slowed('max_rotation_speed', self._turning, fastest_turn(limits), 'rad/s')


class DriveArc(TurningGoal):
    """Drive on a circle."""

    def __init__(self, circle: Circle, speed: float, allowance: float,
                 learned: StoppingModel) -> None:
        """Take a circle, m/s and seconds; Malformed says what no robot could follow."""
        check_range('angle', circle.angle, 'rad', -MAX_ANGLE, MAX_ANGLE)
        check_finite('radius', circle.radius, 'm')
        if circle.radius <= 0:
            raise Malformed(f'radius = {circle.radius:g} m; allowed: above 0')
        length = circle.angle * circle.radius
        check_range('length of the arc', length, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        check_speed(speed)
        if circle.direction not in (1, -1):
            raise Malformed(f'translate_direction = {circle.direction}; allowed: 1 forward, '
                            '-1 backward')
        super().__init__(circle, speed / circle.radius, allowance, learned)
        self._speed = speed

    def _slowed(self, limits: MotionLimits) -> str:
        radius = self._circle.radius
        most = limits.max_wheel_speed * radius / (radius + limits.wheel_separation / 2)
        return slowed('max_translation_speed', self._speed, most, 'm/s')

    def _done(self) -> str:
        return f'{super()._done()} on a radius of {self._circle.radius:g} m'


class TargetPose(NamedTuple):
    """Where to go, in the frame of the odometry."""

    x: float
    y: float
    heading: float | None = None
    """Radians; None: any."""


class NavigateToPosition(MotionGoal):
    """Turn to a place, drive there straight, and turn to a heading."""

    def __init__(self, place: TargetPose, speed: float, turning: float, allowance: float,
                 learned: StoppingModel, learned_turning: StoppingModel) -> None:
        """Take a place, m/s, rad/s and seconds; Malformed says what no robot could follow."""
        check_range('goal_pose.position.x', place.x, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        check_range('goal_pose.position.y', place.y, 'm', -MAX_DISTANCE, MAX_DISTANCE)
        check_finite('heading of goal_pose', place.heading or 0.0, 'rad')
        check_speed(speed)
        check_turning(turning)
        super().__init__(allowance)
        self._place, self._speed, self._turning = place, speed, turning
        self._learned, self._learned_turning = learned, learned_turning

    def _legs(self) -> Legs:
        """Yield a turn and a straight line to the place, unless the robot is there, and a turn."""
        if self._far > STRAIGHT_TOLERANCE:
            yield Phase.TURNING_TO_PLACE, self._turn_to(self._direction_to_place)
            yield Phase.DRIVING, Straight(
                self.view.estimate, self._far, self._direction_to_place, self._speed,
                self._learned, self.view.limits)
        if self._place.heading is not None:
            yield Phase.TURNING_TO_HEADING, self._turn_to(self._place.heading)

    def _turn_to(self, heading: float) -> Arc:
        at = self.view.estimate
        return Arc(at, remainder(heading - at.yaw, tau), 0.0, 1, self._turning,
                   self._learned_turning, self.view.limits)

    @property
    def _far(self) -> float:
        at = self.view.estimate
        return hypot(self._place.x - at.x, self._place.y - at.y)

    @property
    def _direction_to_place(self) -> float:
        at = self.view.estimate
        return atan2(self._place.y - at.y, self._place.x - at.x)

    def _slowed(self, limits: MotionLimits) -> str:
        return (slowed('max_translation_speed', self._speed, limits.max_wheel_speed, 'm/s')
                + slowed('max_rotation_speed', self._turning, fastest_turn(limits), 'rad/s'))

    def _went(self) -> str:
        return f'{self._far:.2f} m from the goal'

    def _done(self) -> str:
        at = self.view.estimate
        return f'at x {at.x:.3f} m, y {at.y:.3f} m, {self._far:.3f} m from the goal'


def fastest_turn(limits: MotionLimits) -> float:
    """Return the rad/s at which both wheels run at their limit."""
    return 2 * limits.max_wheel_speed / limits.wheel_separation


def slowed(name: str, speed: float, most: float, unit: str) -> str:
    """Say that a speed is too fast; empty where it is not."""
    if speed <= most * (1 + ROUNDING):
        return ''
    return f'; slowed to {most:.2f} {unit}: {name} = {speed:g} is beyond max_wheel_speed'
