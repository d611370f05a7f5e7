"""
What a body at a pose meets in its world: contact, walls beside it, floor below, beams in the air.

A robot crosses a room slowly, so `Surroundings` remembers what is near and forgets the rest until
the robot has moved a quarter of a metre; the floor, where no edge is near, is one number.

The numbers below are guesses unless they say otherwise.  Bearings are seen from the robot's
centre, left positive.
"""

from __future__ import annotations

import math

from ..world import HomeBase, Pose, World
from ..world.geometry import Obstacle, Point, reach, sees
from .sensed import NO_INFRARED

TOUCH = 0.0005
"""A bumper is pressed when an obstacle is as near as this to the hull, metres."""
BUMPER_HALF = math.pi / 2
"""The bumper covers the front half of the hull (by the robot's shape)."""
BUMPER_MIDDLE = math.radians(15)
"""Within this of straight ahead a contact presses both sides."""

WALL_BEARING = math.radians(-65)
"""Where the wall sensor sits on the hull, and where it looks."""
WALL_REACH = 0.15
"""Metres from the hull beyond which the wall sensor gets nothing back."""
WALL_PEAK, WALL_FALL = 4000, 0.04
"""Signal of a wall at the hull, and the distance at which a quarter of it is left, metres."""
WALL_SEEN = 600
"""Signal from which packet 8 says wall: at about 6 cm."""

CLIFF_BEARINGS = tuple(map(math.radians, (60, 15, -15, -60)))
"""Left, front left, front right, right."""
CLIFF_FORWARD = 0.15
"""Distance of the cliff sensors from the robot's centre, metres."""
CLIFF_PLACES = tuple((CLIFF_FORWARD * math.cos(bearing), CLIFF_FORWARD * math.sin(bearing))
                      for bearing in CLIFF_BEARINGS)
FLOOR_PEAK = 2500
"""Cliff signal over a floor that reflects all."""
CLIFF_BELOW = 150
"""Signal below which a cliff is seen: a floor that reflects less than 6 % is a cliff, too."""

RECEIVER_FORWARD = 0.13
"""Distance of the infrared receiver ahead of the centre, metres: on top of the bumper (manual)."""
RED_BUOY, GREEN_BUOY, FORCE_FIELD, BEAMS = 8, 4, 2, 240
"""Bits of the Home Base's characters, and what they are added to (manual)."""

DOCK_GAP, DOCK_ASIDE, DOCK_ASKEW = 0.01, 0.03, math.radians(15)
"""Contacts touch within these of the perfect docked pose: metres, metres, radians."""

MARGIN = 0.25
"""Metres the robot may move before it looks around anew."""
ROUNDS = 6
"""Obstacles that may push a robot out of each other before it is stuck between them."""


class Surroundings:
    """The part of a world that a round body at some place can touch or see beside it."""

    __slots__ = ('obstacles', '_world', '_radius', '_x', '_y', '_even', '_floor')

    def __init__(self, world: World, radius: float) -> None:
        self._world, self._radius = world, radius
        self._x = self._y = math.nan
        self.obstacles: tuple[Obstacle, ...] = ()
        """Those near enough to be touched or seen by the wall sensor."""
        self._even = False
        self._floor: float | None = None

    def move_to(self, x: float, y: float) -> None:
        """Look around anew if the last look was too far from here."""
        # Written so that the first time, from nowhere, counts as far.
        if not (x - self._x) ** 2 + (y - self._y) ** 2 < MARGIN ** 2:
            self._look_around(x, y)

    def _look_around(self, x: float, y: float) -> None:
        self._x, self._y = x, y
        near = self._radius + WALL_REACH + MARGIN
        self.obstacles = tuple(each for each in self._world.obstacles if each.gap(x, y) < near)
        near = self._radius + MARGIN
        self._even = all(each.edge_gap(x, y) > near for each in self._world.borders)
        self._floor = self._world.floor(x, y)

    @property
    def firm(self) -> bool:
        """There is floor everywhere below the robot, and no edge near."""
        return self._even and self._floor is not None

    def floor(self, point: Point) -> float | None:
        """Return the reflectance at a point below the robot; None where there is no floor."""
        return self._floor if self._even else self._world.floor(*point)

    def push_out(self, x: float, y: float, back: Point) -> Point | None:
        """
        Return the nearest place for a centre that obstacles do not allow; None if they do.

        Where they leave no room at all (a wedge), the way is `back`.
        """
        free = True
        for _ in range(ROUNDS):
            depth, nx, ny = self._deepest(x, y)
            if depth <= 1e-9:
                return None if free else (x, y)
            x, y, free = x + nx * depth, y + ny * depth, False
        return (x, y) if self._deepest(x, y)[0] <= TOUCH else back

    def _deepest(self, x: float, y: float) -> tuple[float, float, float]:
        """Return how deep the worst obstacle is in the hull, and the unit vector out."""
        worst, out_x, out_y = 0.0, 1.0, 0.0
        for each in self.obstacles:
            gap = each.gap(x, y)
            depth = self._radius - gap
            if depth > worst and gap != 0:
                dx, dy = each.away(x, y)
                worst, out_x, out_y = depth, dx / gap, dy / gap
        return worst, out_x, out_y

    def bumps(self, pose: Pose) -> tuple[bool, bool]:
        """Return whether the bumper is pressed left and right."""
        left = right = False
        for each in self.obstacles:
            if each.gap(pose.x, pose.y) <= self._radius + TOUCH:
                dx, dy = each.away(pose.x, pose.y)
                bearing = math.remainder(math.atan2(-dy, -dx) - pose.yaw, math.tau)
                if abs(bearing) <= BUMPER_HALF:
                    left = left or bearing >= -BUMPER_MIDDLE
                    right = right or bearing <= BUMPER_MIDDLE
        return left, right

    def wall_signal(self, pose: Pose) -> int:
        """Return what the wall sensor gets back: 0 to WALL_PEAK."""
        dx, dy = math.cos(pose.yaw + WALL_BEARING), math.sin(pose.yaw + WALL_BEARING)
        gap = reach(self.obstacles, pose.x + self._radius * dx, pose.y + self._radius * dy,
                    dx, dy)
        return int(WALL_PEAK * (WALL_FALL / (WALL_FALL + gap)) ** 2) if gap < WALL_REACH else 0

    def cliff_signals(self, pose: Pose) -> tuple[int, ...]:
        """Return what the four cliff sensors get back, without noise; 0 where no floor is."""
        if self._even:
            return (int(FLOOR_PEAK * (self._floor or 0.0)),) * 4
        return tuple(int(FLOOR_PEAK * (self.floor(pose.ahead(*place)) or 0.0))
                     for place in CLIFF_PLACES)


def beams(world: World, pose: Pose, powered: bool) -> tuple[bool, int]:
    """
    Return whether a virtual wall is seen (packet 13) and the character received (packet 17).

    `powered` is for Home Bases.  Their force field trips packet 13, too (manual).  A Virtual
    Wall has no character in the manual's table, so packet 17 says nothing of it.
    """
    if not world.home_bases and not world.virtual_walls:
        return False, NO_INFRARED
    receiver = pose.ahead(RECEIVER_FORWARD)
    bits = 0
    for base in world.home_bases if powered else ():
        red, green, field = base.beams_on(receiver)
        if (red or green or field) and _clear(world, base, receiver):
            bits |= RED_BUOY * red | GREEN_BUOY * green | FORCE_FIELD * field
    walled = bool(bits & FORCE_FIELD) or any(
        each.shines_on(receiver) and sees(world.obstacles, (each.pose.x, each.pose.y), receiver)
        for each in world.virtual_walls)
    return walled, BEAMS + bits if bits else NO_INFRARED


def _clear(world: World, base: HomeBase, point: Point) -> bool:
    """Return whether nothing but the base's own front stands between it and the point."""
    others = [each for each in world.obstacles if each is not base.plate]
    return sees(others, (base.pose.x, base.pose.y), point)


def docked(world: World, pose: Pose, radius: float) -> bool:
    """Return whether the robot touches the contacts of a Home Base."""
    for base in world.home_bases:
        far, bearing = base.pose.polar(pose.x, pose.y)
        askew = math.remainder(pose.yaw - base.pose.yaw - math.pi, math.tau)
        if (abs(far * math.sin(bearing)) <= DOCK_ASIDE and abs(askew) <= DOCK_ASKEW
                and -TOUCH <= far * math.cos(bearing) - radius <= DOCK_GAP):
            return True
    return False
