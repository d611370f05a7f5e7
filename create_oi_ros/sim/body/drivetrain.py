# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Two wheels and what they do to the robot's pose.

`Drivetrain.horizon` says how long the wheels' present motion keeps its nature; the body cuts time
there. Within such a piece wheel travel and yaw are exact. The position is a two-point Gauss sum of
constant accelerations that give the same travel. So the result hardly depends on how time is cut.
"""

from __future__ import annotations

import math
from random import Random
from typing import NamedTuple

from .config import BodyConfig
from .wheel import Wheel

GAUSS_NODE = 0.5 - 0.5 / math.sqrt(3)
"""Part of a piece of time at which a two-point Gauss sum looks first."""


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

    __slots__ = ('right', 'left', '_separation')

    def __init__(self, config: BodyConfig, seed: int = 0) -> None:
        self.right = Wheel(config, config.right_wheel_scale, config.right_speed_gain,
                           config.right_speed_offset, config.right_slip,
                           Random(f'right {seed}'))
        self.left = Wheel(config, config.left_wheel_scale, config.left_speed_gain,
                          config.left_speed_offset, config.left_slip, Random(f'left {seed}'))
        if config.recording is not None:
            self.right.follow(config.recording.wheel('right'))
            self.left.follow(config.recording.wheel('left'))
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
        speed, rate = self._together(self.right.speed * right, self.left.speed * left)
        right_travel, left_travel = self.right.roll(h), self.left.roll(h)
        far, turn = self._together(right_travel * right, left_travel * left)
        dx, dy, turned, went = glide(
            h, yaw, speed, rate, 2 * (far / h - speed) / h, 2 * (turn / h - rate) / h)
        return Motion(dx, dy, turned, went, right_travel, left_travel)

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

    def stall(self, part: float) -> None:
        """Take this part, 0 to 1, of what both wheels have in common from their speeds."""
        common = (self.right.speed + self.left.speed) / 2 * part
        self.right.speed -= common
        self.left.speed -= common


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
