# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The goal of following a wall on the right, where the sensor is.

How strong a wall's signal is depends on its colour, but the robot itself says whether it sees a
wall. So it bends away while it does and towards the wall while it does not. At a touch it backs
off a little and turns left.
"""

from collections.abc import Iterator
from math import inf

from ..motion import Velocity
from .goal import (
    bumps,
    check_range,
    Code,
    DrivingGoal,
    Malformed,
    Order,
    Over,
    Phase,
    Progress,
)

RIGHT = -1
"""The side of the sensor, as the action has it."""
SPEED, BEND = 0.15, 0.35
"""m/s, and rad/s along a wall."""
CORNER = 0.6
"""rad/s to the right where the wall has ended: round its end, on a circle of 25 cm."""
WALL_ENDED_TIME, ENGAGED = 0.5, 2.0
"""Seconds without the wall after which it has ended, and after which none is followed."""
MINUTE = 60.0
BACK_OFF = ((Velocity(-0.1, 0.0), 0.4), (Velocity(0.0, 1.2), 0.5))
"""Velocities after a touch, and for how many seconds: back a little, then turn left."""


class WallFollow(DrivingGoal):
    """Follow a wall for a while."""

    def __init__(self, side: int, runtime: float, allowance: float) -> None:
        """Take the side, and seconds; Malformed says what this robot could not follow."""
        super().__init__(allowance, direction=1, bumper=False)
        if side != RIGHT:
            raise Malformed(f'follow_side = {side}; allowed: {RIGHT}, the right: there is the '
                            'only wall sensor')
        check_range('max_runtime', runtime, 's', 0.0)
        self._runtime = runtime or MINUTE
        self.allowance = self.allowance or 2 * self._runtime
        self._seen_at = -inf
        """When the wall was seen or touched last, s."""
        self.progress = Progress(phase=Phase.SEARCHING)

    def orders(self) -> Iterator[Order]:
        """Follow the wall until the time is over."""
        begun_at, velocities = self.view.now, self._velocities()
        while self.view.now - begun_at < self._runtime:
            self._look()
            velocity = next(velocities)
            self.forward = velocity.linear > 0
            yield velocity
        yield Over(Code.NONE, f'followed for {self._runtime:g} s')

    def _look(self) -> None:
        if self._touches or self._sees:
            self._seen_at = self.view.now
        engaged = self.view.now - self._seen_at <= ENGAGED
        self.progress = Progress(phase=Phase.ENGAGED if engaged else Phase.SEARCHING)

    @property
    def _touches(self) -> bool:
        return bool(bumps(self.view.readings))

    @property
    def _sees(self) -> bool:
        return bool(self.view.readings.number('wall', 0))

    def _velocities(self) -> Iterator[Velocity]:
        """Yield a velocity for each frame."""
        while True:
            if self._touches:
                for velocity, seconds in BACK_OFF:
                    since = self.view.now
                    while self.view.now - since < seconds:
                        yield velocity
            unseen = self.view.now - self._seen_at
            if unseen == inf:
                yield Velocity(SPEED, 0.0)
            elif self._sees:
                yield Velocity(SPEED, BEND)
            else:
                yield Velocity(SPEED, -CORNER if unseen > WALL_ENDED_TIME else -BEND)
