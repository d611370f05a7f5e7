"""
Two wheels and what they do to the robot's pose.

A wheel's speed runs to its target at a constant acceleration.  `Drivetrain.horizon` says how long
the present accelerations last, so the body can cut time there; within such a piece wheel travel
and yaw are exact, and the position is a two-point Gauss sum, off by less than 1e-10 m in 15 ms.
The result therefore hardly depends on how time is cut.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .config import BodyConfig, EncoderSign

_STEADY = 1e-9
"""Metres per second below which a wheel has reached its goal."""
_NODE = 0.5 - 0.5 / math.sqrt(3)


class Motion(NamedTuple):
    """What one piece of time did, if nothing is in the way: metres and radians."""

    dx: float
    dy: float
    turn: float
    """True change of yaw, counter-clockwise."""
    travel: float
    """True travel of the robot's centre along its heading."""
    right: float
    """Travel of the tyres' treads, forwards positive."""
    left: float


class Wheel:
    """One drive wheel: motor, tyre and encoder.  Speeds in m/s, forwards positive."""

    __slots__ = ('speed', 'target', 'held', 'slip', 'grounded', '_up', '_scale', '_gain',
                 '_limit', '_top', '_sign')

    def __init__(self, config: BodyConfig, scale: float, gain: float, slip: float) -> None:
        self.speed = 0.0
        """Of the tyre, as the encoder would measure it."""
        self.target = 0.0
        self.held = False
        self.slip = slip
        self.grounded = True
        self._up = True
        self._scale, self._gain = scale, gain
        self._limit, self._top = config.wheel_acceleration, config.max_wheel_speed
        self._sign = config.encoder_sign

    def command(self, speed: float) -> None:
        """Set the speed to run to, clamped to the wheel's maximum."""
        top = self._top
        self.target = max(-top, min(top, speed)) * self._gain
        if speed:
            self._up = speed > 0
        elif self.speed == 0 or self._sign is EncoderSign.COMMAND:
            self._up = True

    @property
    def grip(self) -> float:
        """True travel over tyre travel."""
        return self._scale * (1 - self.slip) if self.grounded else 0.0

    @property
    def goal(self) -> float:
        """Where the present ramp ends: at zero first when the wheel has to reverse."""
        if self.held or self.speed * self.target < 0:
            return 0.0
        return self.target

    def ramp_time(self) -> float:
        """Seconds until the goal is reached; 0 when it is."""
        return abs(self.goal - self.speed) / self._limit

    def acceleration(self) -> float:
        """Present acceleration, m/s^2."""
        rest = self.goal - self.speed
        return math.copysign(self._limit, rest) if rest else 0.0

    def advance(self, h: float, acceleration: float) -> float:
        """Turn for h seconds, at most `ramp_time`; return the tread's travel, metres."""
        goal = self.goal
        travel = (self.speed + acceleration * h / 2) * h
        speed = self.speed + acceleration * h
        self.speed = goal if abs(goal - speed) < _STEADY else speed
        return travel

    def count(self, travel: float) -> float:
        """Return the signed metres that the encoder makes of the tread's travel."""
        if self._sign is EncoderSign.TRUE:
            return travel
        counted = abs(travel) if self._up else -abs(travel)
        if self.speed == 0 and self.target == 0:
            self._up = True
        return counted


class Drivetrain:
    """Both wheels, and the true motion that follows from them."""

    __slots__ = ('right', 'left', '_separation')

    def __init__(self, config: BodyConfig) -> None:
        self.right = Wheel(config, config.right_wheel_scale, config.right_speed_gain,
                           config.right_slip)
        self.left = Wheel(config, config.left_wheel_scale, config.left_speed_gain,
                          config.left_slip)
        self._separation = config.wheel_separation

    @property
    def at_rest(self) -> bool:
        """Neither wheel turns nor is told to."""
        right, left = self.right, self.left
        return right.speed == 0 == left.speed and right.goal == 0 == left.goal

    def twist(self) -> tuple[float, float]:
        """Return the forward velocity (m/s) and yaw rate (rad/s) that the wheels give the body."""
        right = self.right.speed * self.right.grip
        left = self.left.speed * self.left.grip
        return (right + left) / 2, (right - left) / self._separation

    def horizon(self, longest: float) -> float:
        """Seconds, at most `longest`, for which both accelerations stay what they are."""
        for wheel in (self.right, self.left):
            ramp = wheel.ramp_time()
            if 0 < ramp < longest:
                longest = ramp
        return longest

    def advance(self, h: float, yaw: float) -> Motion:
        """Drive for h seconds, at most `horizon`, from a heading of `yaw` radians."""
        right, left = self.right, self.left
        right_acceleration, left_acceleration = right.acceleration(), left.acceleration()
        speed, rate = self.twist()
        right_gain, left_gain = right_acceleration * right.grip, left_acceleration * left.grip
        motion = glide(h, yaw, speed, rate, (right_gain + left_gain) / 2,
                       (right_gain - left_gain) / self._separation)
        return motion._replace(right=right.advance(h, right_acceleration),
                               left=left.advance(h, left_acceleration))

    def roll(self, h: float, yaw: float, speed: float, rate: float) -> Motion:
        """Be pushed for h seconds at a twist of m/s and rad/s: the wheels follow the floor."""
        half = rate * self._separation / 2
        motion = glide(h, yaw, speed, rate, 0.0, 0.0)
        for wheel, rolled in ((self.right, speed + half), (self.left, speed - half)):
            wheel.speed = rolled if wheel.grounded and not wheel.held else 0.0
        return motion._replace(right=self.right.speed * h, left=self.left.speed * h)

    def let_go(self) -> None:
        """End a push: the gears stop whatever the motors do not drive."""
        for wheel in (self.right, self.left):
            if wheel.target == 0:
                wheel.speed = 0.0

    def stall(self, part: float) -> None:
        """Take this part, 0 to 1, of what both wheels have in common from their speeds."""
        common = (self.right.speed + self.left.speed) / 2 * part
        self.right.speed -= common
        self.left.speed -= common


def glide(h: float, yaw: float, speed: float, rate: float,
          acceleration: float, turn_acceleration: float) -> Motion:
    """Move for h seconds with constant linear and angular acceleration; nothing is counted."""
    x = y = 0.0
    for t in (h * _NODE, h * (1 - _NODE)):
        heading = yaw + (rate + turn_acceleration * t / 2) * t
        stride = (speed + acceleration * t) * h / 2
        x += stride * math.cos(heading)
        y += stride * math.sin(heading)
    return Motion(x, y, (rate + turn_acceleration * h / 2) * h,
                  (speed + acceleration * h / 2) * h, 0.0, 0.0)
