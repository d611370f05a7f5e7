# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Two drive wheels with their encoders, and what they do to the robot's pose.

`Drivetrain.horizon` says how long the wheels' present motion keeps its nature; the body cuts time
there. Within such a piece wheel travel and yaw are exact. The position is a two-point Gauss sum of
constant accelerations that give the same travel. So the result hardly depends on how time is cut.
"""

from __future__ import annotations

from collections import deque
import math
from random import Random
from typing import NamedTuple

from ...robot import TOP_SPEED
from .config import BodyConfig, EncoderSign
from .wheels import Lag, Ramp, Response, Spring, TIME_TOLERANCE, Unsteady

GAUSS_NODE = 0.5 - 0.5 / math.sqrt(3)
"""Part of a piece of time at which a two-point Gauss sum looks first."""
TICK_TOLERANCE = 1e-9
"""Ticks by which a sum of floats may miss a whole number of them."""


class Wheel:
    """Motor, tyre and encoder. Speeds in m/s, forwards positive."""

    def __init__(self, config: BodyConfig, scale: float, gain: float, offset: float,
                 slip: float, random: Random) -> None:
        self.target = 0.0
        """What the wheel is driven at now, m/s."""
        self.slip = slip
        self.grounded = True
        self.held = False
        """Whether somebody holds it."""
        self._counts_up = True
        """Whether the encoder takes the wheel to turn forwards."""
        self._config = config
        self._scale, self._gain, self._offset = scale, gain, offset
        self._between = 0.0
        """Metres since the last tick."""
        self._requests: deque[tuple[float, float]] = deque()
        """Seconds until a request takes effect, and its speed."""
        steady = _follower(config)
        self._follower = steady if not (config.speed_jitter or config.speed_wander) else Unsteady(
            steady, config.speed_jitter, config.speed_wander, random)

    def command(self, speed: float) -> None:
        """Set the speed to run to, clamped to the wheel's maximum."""
        speed = max(-TOP_SPEED, min(TOP_SPEED, speed))
        if self._config.encoder_sign is not EncoderSign.DRIVE:
            self._take_sign(speed)
        if self._config.dead_time <= 0:
            self._execute(speed)
        elif speed != (self._requests[-1][1] if self._requests else self.target):
            self._requests.append((self._config.dead_time, speed))

    def _take_sign(self, speed: float) -> None:
        sign = self._config.encoder_sign
        if speed:
            self._counts_up = speed > 0
        elif sign is EncoderSign.COMMAND or (sign is EncoderSign.UNTIL_REST and self.speed == 0):
            self._counts_up = True

    def _execute(self, speed: float) -> None:
        """Let a request take effect."""
        self.target = speed
        if self._config.encoder_sign is EncoderSign.DRIVE:
            self._take_sign(speed)
        self._follower.aim(self.goal)

    @property
    def speed(self) -> float:
        """Of the tyre, as the encoder would measure it."""
        return self._follower.speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._follower.speed = speed
        self._follower.aim(self.goal)

    def hold(self, held: bool) -> None:
        """Hold it, or let it go."""
        self.held = held
        self.speed = 0.0 if held else self.speed

    @property
    def goal(self) -> float:
        """The speed that it settles at."""
        if self.held or abs(self.target) < self._config.dead_band or not self.target:
            return 0.0
        return self.target * self._gain + math.copysign(self._offset, self.target)

    @property
    def grip(self) -> float:
        """True travel over tyre travel."""
        return self._scale * (1 - self.slip) if self.grounded else 0.0

    @property
    def at_rest(self) -> bool:
        """Whether it stands, and nothing that was asked will change that."""
        return self.speed == 0 == self.goal and not self._requests

    def horizon(self, longest: float) -> float:
        """Return the seconds, at most `longest`, for which one `roll` is exact."""
        if self._requests:
            longest = min(longest, max(self._requests[0][0], TIME_TOLERANCE))
        return self._follower.horizon(longest)

    def roll(self, h: float) -> float:
        """Turn for h seconds, at most `horizon`; return the tread's travel, metres."""
        if self._requests:
            self._requests = deque((wait - h, speed) for wait, speed in self._requests)
        return 0.0 if self.held else self._follower.roll(h)

    def count(self, travel: float) -> float:
        """
        Return the signed metres, in whole ticks, that the encoder makes of the tread's travel.

        Call this after each `roll`: requests that are due take effect here.
        """
        sign, counted = self._config.encoder_sign, travel
        if sign is not EncoderSign.TRUE:
            counted = abs(travel) if self._counts_up else -abs(travel)
        while self._requests and self._requests[0][0] <= TIME_TOLERANCE:
            self._execute(self._requests.popleft()[1])
        if sign is EncoderSign.UNTIL_REST and self.at_rest and self.target == 0:
            self._counts_up = True
        tick = self._config.encoder_tick
        if not tick:
            return counted
        self._between += counted
        ticks = math.trunc(self._between / tick + math.copysign(TICK_TOLERANCE, self._between))
        self._between -= ticks * tick
        return ticks * tick


def _follower(config: BodyConfig) -> Lag | Spring | Ramp:
    match config.response:
        case Response.FIRST_ORDER:
            return Lag(config.time_constant, config.braking)
        case Response.SECOND_ORDER:
            return Spring(config.time_constant, config.overshoot, config.braking)
        case Response.RAMP:
            return Ramp(config.wheel_acceleration, config.braking)


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


class Drivetrain:
    """Both wheels, and the true motion that follows from them."""

    def __init__(self, config: BodyConfig, seed: int = 0) -> None:
        self.right = Wheel(config, config.right_wheel_scale, config.right_speed_gain,
                           config.right_speed_offset, config.right_slip,
                           Random(f'right {seed}'))
        self.left = Wheel(config, config.left_wheel_scale, config.left_speed_gain,
                          config.left_speed_offset, config.left_slip, Random(f'left {seed}'))
        self._separation = config.wheel_separation

    @property
    def at_rest(self) -> bool:
        """Neither wheel turns nor is told to."""
        return self.right.at_rest and self.left.at_rest

    def twist(self) -> tuple[float, float]:
        """Return the forward velocity (m/s) and yaw rate (rad/s) that the wheels give the body."""
        return self._together(self.right.speed * self.right.grip, self.left.speed * self.left.grip)

    def _together(self, right: float, left: float) -> tuple[float, float]:
        """Return how far ahead, and how far round, two true travels or speeds take the body."""
        return (right + left) / 2, (right - left) / self._separation

    def horizon(self, longest: float) -> float:
        """Seconds, at most `longest`, for which the motion of both wheels keeps its nature."""
        return self.left.horizon(self.right.horizon(longest))

    def advance(self, h: float, yaw: float) -> Motion:
        """Drive for h seconds, at most `horizon`, from a heading of `yaw` radians."""
        right, left = self.right.grip, self.left.grip
        speed, rate = self.twist()
        right_travel, left_travel = self.right.roll(h), self.left.roll(h)
        far, turn = self._together(right_travel * right, left_travel * left)
        return Motion(*glide(h, yaw, speed, rate, 2 * (far / h - speed) / h,
                             2 * (turn / h - rate) / h), right_travel, left_travel)

    def roll(self, h: float, yaw: float, speed: float, rate: float) -> Motion:
        """Be pushed for h seconds at a twist of m/s and rad/s: the wheels follow the floor."""
        half = rate * self._separation / 2
        for wheel, rolled in ((self.right, speed + half), (self.left, speed - half)):
            wheel.speed = rolled if wheel.grounded and not wheel.held else 0.0
        return Motion(*glide(h, yaw, speed, rate, 0.0, 0.0),
                      self.right.speed * h, self.left.speed * h)

    def let_go(self) -> None:
        """End a push: the gears stop whatever the motors do not drive."""
        for wheel in (self.right, self.left):
            if wheel.target == 0:
                wheel.speed = 0.0


def glide(h: float, yaw: float, speed: float, rate: float,
          acceleration: float, turn_acceleration: float) -> tuple[float, float, float, float]:
    """Return dx, dy, turn and travel of h seconds of constant linear and angular acceleration."""
    x = y = 0.0
    for t in (h * GAUSS_NODE, h * (1 - GAUSS_NODE)):
        heading = yaw + (rate + turn_acceleration * t / 2) * t
        stride = (speed + acceleration * t) * h / 2
        x += stride * math.cos(heading)
        y += stride * math.sin(heading)
    return (x, y, (rate + turn_acceleration * h / 2) * h, (speed + acceleration * h / 2) * h)
