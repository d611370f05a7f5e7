# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The goal of following a wall on the right, where the sensor is.

How strong a wall's signal is depends on its colour, but the robot itself says whether it sees a
wall. So it bends away while it does and towards the wall while it does not. At a touch it backs
off a little and turns left.
"""

from typing import NamedTuple

from ..motion import Velocity
from .goal import Code, Goal, LEAST_SPEED, Malformed, Order, Over, Phase, Progress, View
from .hazards import bumps, Hazards, NO_SPEED, Stall

RIGHT = -1
"""The side of the sensor, as the action has it."""
SPEED, BEND = 0.15, 0.35
"""m/s, and rad/s along a wall."""
CORNER = 0.6
"""rad/s to the right where the wall has ended: round its end, on a circle of 25 cm."""
ENDED, ENGAGED = 0.5, 2.0
"""Seconds without the wall after which it has ended, and after which none is followed."""
MINUTE = 60.0


class TimedVelocity(NamedTuple):
    """A part of backing off."""

    velocity: Velocity
    seconds: float


BACK_OFF = (TimedVelocity(Velocity(-0.1, 0.0), 0.4), TimedVelocity(Velocity(0.0, 1.2), 0.5))
"""After a touch: back a little, then turn left."""


class WallFollow(Goal):
    """Follow a wall for a while."""

    def __init__(self, side: int, runtime: float, allowance: float) -> None:
        """Take the side, and seconds; Malformed says what this robot could not follow."""
        super().__init__(allowance)
        if side != RIGHT:
            raise Malformed(f'follow_side = {side}; allowed: {RIGHT}, the right: there is the '
                            'only wall sensor')
        if runtime < 0:
            raise Malformed(f'max_runtime = {runtime:g} s; allowed: 0 or more')
        self._runtime = runtime or MINUTE
        self.allowance = self.allowance or 2 * self._runtime
        self._hazards, self._stall = Hazards(bumper=False), Stall()
        self._told = Velocity()
        self._begun_at = 0.0
        self._seen_at: float | None = None
        self._away: list[TimedVelocity] = []
        self._away_since = 0.0
        self._engaged = False

    def begin(self, view: View) -> Over | None:
        """Start, unless a cliff or a wheel that hangs is in the way."""
        if view.limits.max_wheel_speed < LEAST_SPEED:
            return NO_SPEED
        self._begun_at = view.now
        return self._hazards.begin(view, forward=True, backward=False)

    def step(self, view: View) -> Order:
        """Follow the wall."""
        over = (self._hazards.check(view, forward=self._told.linear > 0)
                or self._stall.check(view, self._told))
        if over is not None:
            return over
        if view.now - self._begun_at >= self._runtime:
            return Over(Code.NONE, f'followed for {self._runtime:g} s')
        self._told = self._steer(view)
        return self._told

    def _steer(self, view: View) -> Velocity:
        touched = bool(bumps(view.readings))
        sees = view.readings.has('wall') and view.readings.wall
        if touched or sees:
            self._seen_at = view.now
        unseen = None if self._seen_at is None else view.now - self._seen_at
        self._engaged = unseen is not None and unseen <= ENGAGED
        if touched and not self._away:
            self._away, self._away_since = list(BACK_OFF), view.now
        if self._away and view.now - self._away_since >= self._away[0].seconds:
            self._away.pop(0)
            self._away_since = view.now
        if self._away:
            return self._away[0].velocity
        if unseen is None:
            return Velocity(SPEED, 0.0)
        if sees:
            return Velocity(SPEED, BEND)
        return Velocity(SPEED, -CORNER if unseen > ENDED else -BEND)

    @property
    def progress(self) -> Progress:
        """Whether a wall is followed."""
        return Progress(phase=Phase.ENGAGED if self._engaged else Phase.SEARCHING)
