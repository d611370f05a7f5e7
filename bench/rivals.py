# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Two plain odometries to compare with: what anybody would write in twenty lines."""

from collections.abc import Sequence
from math import cos, radians, sin
from typing import NamedTuple, Self

from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.mechanics import Accumulator
from robots import Robot


class Counts(NamedTuple):
    """What the encoders have counted since the start, unrounded: mm and degrees."""

    distance: float
    angle: float


class Rival:
    """Reads every so often and believes what it reads; half a unit added where it is cut off."""

    def __init__(self, robot: Robot, interval: float) -> None:
        self.x = self.y = self.yaw = 0.0
        self._geometry, self._period = robot.geometry, robot.period
        self._interval, self._age = interval, 0.0
        self._half = 0.5 if interval and robot.rounding is Rounding.TRUNCATE else 0.0
        self._distance, self._angle = (Accumulator(robot.rounding) for _ in range(2))
        self._counts = Counts(0.0, 0.0)

    def follow(self, every: Sequence[Counts]) -> Self:
        """Let a drive pass; return itself."""
        for slot, counts in enumerate(every, 1):
            self.frame(counts, last=slot == len(every))
        return self

    def frame(self, counts: Counts, *, last: bool = False) -> None:
        """Let a frame pass."""
        self._distance.add(counts.distance - self._counts.distance)
        self._angle.add(counts.angle - self._counts.angle)
        self._counts = counts
        self._age += self._period
        if self._age >= self._interval - 1e-9 or last:
            self._age = 0.0
            self._believe(self._whole(self._distance), self._whole(self._angle))

    def _whole(self, accumulator: Accumulator) -> float:
        whole = accumulator.take()
        return whole + self._half * ((whole > 0) - (whole < 0))

    def _believe(self, distance: float, angle: float) -> None:
        far = distance / 1000 * self._geometry.linear_scale
        turn = radians(angle) * self._geometry.angular_scale
        middle = self.yaw + turn / 2
        chord = far * (sin(turn / 2) / (turn / 2) if turn else 1.0)
        self.x += chord * cos(middle)
        self.y += chord * sin(middle)
        self.yaw += turn
