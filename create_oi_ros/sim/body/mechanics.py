# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot as a thing on the floor: where it is, what its wheels do, what they bump into."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...robot import MM_PER_M, Rounding, SLOT, WHEEL_SEPARATION
from ..world import Pose, World
from .config import BodyConfig
from .drivetrain import Drivetrain, Motion, Wheel
from .surroundings import Surroundings

LONGEST_PIECE = SLOT
"""Seconds. At top speed this is 7.5 mm, so the robot jumps over no wall."""
BLOCKED_SHARE = 0.5
"""Part of the way lost to an obstacle from which the motors labour (guess)."""
WHEEL_IDLE, WHEEL_PER_SPEED = 0.08, 0.3
"""Amperes of a motor whose wheel turns slowly, and that each m/s adds (guesses)."""
WHEEL_BLOCKED, WHEEL_HELD = 0.8, 1.5
"""Amperes of a wheel that slips against an obstacle, and of one that is held: below and above the
manual's limit of 1 A (guesses)."""
WHEEL_LATERAL = WHEEL_SEPARATION / 2
"""Metres of each wheel from the robot's centre line, where its drop switch looks."""
CASTER_FORWARD = 0.13
"""Metres of the front caster ahead of the centre (guess)."""
LOWEST, HIGHEST = -32768, 32767
UNIT_TOLERANCE = 1e-6
"""Units by which a sum of floats may miss a whole number that it means to be."""


class Truth(NamedTuple):
    """What really happened, for teachers and tests; no firmware may look at it."""

    pose: Pose
    """World frame; yaw within -pi to pi."""
    speed: float
    """True forward velocity, m/s."""
    rate: float
    """True yaw rate, rad/s."""
    travelled: float
    """True signed travel of the centre along its heading, metres."""
    turned: float
    """True turn, radians, unwrapped."""
    measured_travelled: float
    """The same by the encoders, before any rounding, metres."""
    measured_turned: float
    """The same by the encoders, before any rounding, radians."""


class Mechanics:
    """A round body on two driven wheels and a caster."""

    def __init__(self, world: World, config: BodyConfig, rounding: Rounding, seed: int) -> None:
        self.wheels = Drivetrain(config, seed)
        self.surroundings = Surroundings(world)
        self.pose = world.start
        self.distance = Accumulator(rounding)
        """Millimetres."""
        self.angle = Accumulator(rounding)
        """Degrees."""
        self.pushed: tuple[float, float] | None = None
        """The twist, m/s and rad/s, at which somebody rolls the robot."""
        self.lifted = False
        self.dropped = (False, False, False)
        """Wheels that hang down by somebody's hand: right, left, caster."""
        self.caster_grounded = True
        self.docked = False
        self._encoder_separation = config.encoder_separation
        self._travelled = self._turned = 0.0
        self._lost = 0.0

    def truth(self) -> Truth:
        speed, rate = self.wheels.twist()
        if self.pushed:
            speed, rate = self.pushed
        return Truth(self.pose, speed * (1 - self._lost), rate, self._travelled, self._turned,
                     self.distance.total / MM_PER_M, math.radians(self.angle.total))

    def place(self, pose: Pose) -> None:
        """Be put elsewhere without a turn of the wheels; obstacles push the body out."""
        x, y = pose.x, pose.y
        self.surroundings.move_to(x, y)
        if not self.lifted:
            x, y = self.surroundings.push_out(x, y, (x, y)) or (x, y)
            self.surroundings.move_to(x, y)
        self.pose = Pose(x, y, math.remainder(pose.yaw, math.tau))
        self._lost = 0.0
        self.update_support()

    def update_support(self) -> None:
        """Work out which wheels have floor below them and whether the robot is docked."""
        right, left, caster = self.dropped
        self.wheels.right.grounded = not right and self._floor_at(0, -WHEEL_LATERAL)
        self.wheels.left.grounded = not left and self._floor_at(0, WHEEL_LATERAL)
        self.caster_grounded = not caster and self._floor_at(CASTER_FORWARD, 0)
        self.docked = not self.lifted and self.surroundings.docked(self.pose)

    def _floor_at(self, forward: float, left: float) -> bool:
        """Return whether a point of the robot stands on floor."""
        return not self.lifted and (self.surroundings.floor_everywhere or self.surroundings.floor(
            self.pose.ahead(forward, left)) is not None)

    def horizon(self, longest: float) -> float:
        """Return the seconds, at most `longest`, that one `advance` may span."""
        if self.pushed:
            return min(longest, LONGEST_PIECE)
        if self.wheels.at_rest:
            return longest
        return self.wheels.horizon(min(longest, LONGEST_PIECE))

    def advance(self, h: float) -> None:
        """Move on by h seconds, at most `horizon`."""
        if self.pushed:
            self._move(self.wheels.roll(h, self.pose.yaw, *self.pushed))
        elif not self.wheels.at_rest:
            self._move(self.wheels.advance(h, self.pose.yaw))
        else:
            self._lost = 0.0

    def _move(self, motion: Motion) -> None:
        """Take the motion as far as obstacles allow, and count it."""
        (x, y, yaw), near = self.pose, self.surroundings
        travel = motion.travel
        to_x, to_y = x + motion.dx, y + motion.dy
        self._lost = 0.0
        if travel:
            near.move_to(to_x, to_y)
            free = None
            if near.obstacles and not self.lifted:
                free = near.push_out(to_x, to_y, (x, y))
            if free is not None:
                to_x, to_y = free
                near.move_to(to_x, to_y)
                heading = yaw + motion.turn / 2
                travel = (to_x - x) * math.cos(heading) + (to_y - y) * math.sin(heading)
                # The wheels slip on the floor: the encoders count on.
                self._lost = min(1.0, max(0.0, 1 - travel / motion.travel))
        self.pose = Pose(to_x, to_y, math.remainder(yaw + motion.turn, math.tau))
        self._travelled += travel
        self._turned += motion.turn
        self._count(self.wheels.right.count(motion.right), self.wheels.left.count(motion.left))
        self.update_support()

    def _count(self, right: float, left: float) -> None:
        """Add what the encoders counted, metres, to what packets 19 and 20 will say."""
        self.distance.add(MM_PER_M * (right + left) / 2)
        self.angle.add(math.degrees((right - left) / self._encoder_separation))

    def overloaded(self, wheel: Wheel) -> bool:
        """Return whether a wheel is told to turn and cannot."""
        return wheel.target != 0 and wheel.held

    def drawn(self) -> float:
        """Return what the wheels' motors draw, amperes."""
        drawn = 0.0
        for wheel in (self.wheels.right, self.wheels.left):
            if self.overloaded(wheel):
                drawn += WHEEL_HELD
            elif wheel.target and self._lost > BLOCKED_SHARE:
                drawn += WHEEL_BLOCKED
            elif wheel.target or wheel.speed:
                drawn += WHEEL_IDLE + WHEEL_PER_SPEED * abs(wheel.speed)
        return drawn

    def contacts_and_floor(self) -> tuple[tuple[bool, bool], int, tuple[int, ...]]:
        """Return bumps left and right, the wall sensor's signal, the cliff sensors' four."""
        if self.lifted:
            return (False, False), 0, (0, 0, 0, 0)
        floors = self.surroundings.cliff_signals(self.pose)
        if not self.surroundings.obstacles:
            return (False, False), 0, floors
        return self.surroundings.bumps(self.pose), self.surroundings.wall_signal(self.pose), floors


class Accumulator:
    """A sum of small floats, read as a 16-bit integer and then set to zero."""

    def __init__(self, rounding: Rounding) -> None:
        self.total = 0.0
        """All that was ever added; reading does not touch it."""
        self._pending = 0.0
        self._rounding = rounding

    def add(self, amount: float) -> None:
        """Add; what is waiting to be read stops at the ends of 16 bits, as the manual says."""
        self.total += amount
        pending = self._pending + amount
        if not LOWEST <= pending <= HIGHEST:
            pending = LOWEST if pending < 0 else HIGHEST
        self._pending = pending

    def take(self) -> int:
        """Read and reset: -32768 to 32767."""
        pending = self._pending
        nudge = 0.5 if self._rounding is Rounding.ROUND else UNIT_TOLERANCE
        whole = int(pending + math.copysign(nudge, pending))
        self._pending = pending - whole if self._rounding is Rounding.CARRY else 0.0
        return whole
