# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a body at a pose meets in its world: obstacles, walls beside it, floor below, beams.

A robot crosses a room slowly. So `Surroundings` keeps the obstacles nearby until the robot has
moved a quarter of a metre, and one reflectance for the floor where no edge is near.

The numbers below are guesses unless marked otherwise. Bearings are seen from the robot's centre,
left positive.
"""

import math

from ...oi.codes import BEAMS, FORCE_FIELD, GREEN_BUOY, RED_BUOY
from ...robot import BODY_RADIUS, CLIFF_BEARINGS
from ..world import Pose, World
from ..world.geometry import Obstacle, Point, reach, sees
from .sensed import NO_INFRARED

TOUCH = 0.0005
"""Gap to an obstacle at which the bumper is pressed, metres."""
BUMPER_HALF = math.pi / 2
"""Largest bearing that the bumper covers: the front half of the hull (the robot's shape)."""
BUMPER_MIDDLE = math.radians(15)
"""A contact within this bearing presses both sides."""

WALL_BEARING = math.radians(-65)
"""Where the wall sensor sits on the hull, and the direction it looks in."""
WALL_REACH = 0.15
"""Range of the wall sensor from the hull, metres."""
WALL_PEAK, WALL_FALL = 4000, 0.04
"""Signal of a wall at the hull; distance at which a quarter of that is left, metres."""
WALL_SEEN = 600
"""Least signal at which packet 8 reports a wall: at about 6 cm."""

CLIFF_FORWARD = 0.15
"""Distance of the cliff sensors from the robot's centre, metres."""
CLIFF_PLACES = tuple((CLIFF_FORWARD * math.cos(bearing), CLIFF_FORWARD * math.sin(bearing))
                      for bearing in map(math.radians, CLIFF_BEARINGS))
FLOOR_PEAK = 2500
"""Cliff signal over a floor that reflects everything."""
CLIFF_BELOW = 150
"""Signal below which a cliff is seen; so a floor that reflects less than 6 % is one too."""

RECEIVER_FORWARD = 0.13
"""Distance of the infrared receiver ahead of the centre, metres: on top of the bumper (manual)."""
DOCK_GAP, DOCK_ASIDE, DOCK_ASKEW = 0.01, 0.03, math.radians(15)
"""Largest errors of the docked pose at which the contacts touch: metres, metres, radians."""

SEARCH_DISTANCE = 0.25
"""Metres that the robot may move before the nearby obstacles are searched again."""
MAX_PUSHES = 6
"""Attempts to push the robot out of obstacles before it counts as stuck between them."""


class Surroundings:
    """The part of a world near a round body."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._x = self._y = math.nan
        self.obstacles: tuple[Obstacle, ...] = ()
        """Those that the body or the wall sensor can reach."""
        self.floor_everywhere = False
        """There is floor everywhere below the robot and no edge near."""
        self._edge_near = True
        self._floor: float | None = None

    def move_to(self, x: float, y: float) -> None:
        """Search again if the robot has moved too far since the last search."""
        # `<`, because the first time `_x` is NaN.
        if (x - self._x) ** 2 + (y - self._y) ** 2 < SEARCH_DISTANCE ** 2:
            return
        self._x, self._y = x, y
        world, near = self._world, BODY_RADIUS + SEARCH_DISTANCE
        self.obstacles = tuple(
            each for each in world.obstacles if each.gap(x, y) < near + WALL_REACH)
        self._edge_near = any(each.edge_gap(x, y) <= near for each in world.borders)
        self._floor = world.floor(x, y)
        self.floor_everywhere = not self._edge_near and self._floor is not None

    def floor(self, point: Point) -> float | None:
        """Return the reflectance at a point below the robot; None where there is no floor."""
        return self._world.floor(*point) if self._edge_near else self._floor

    def push_out(self, x: float, y: float, back: Point) -> Point | None:
        """
        Return the nearest free place for a centre; None if (x, y) itself is free.

        Where obstacles leave no room (a wedge), return `back`.
        """
        free = True
        for _ in range(MAX_PUSHES):
            depth, nx, ny = self._deepest(x, y)
            if depth <= 1e-9:
                return None if free else (x, y)
            x, y, free = x + nx * depth, y + ny * depth, False
        return (x, y) if self._deepest(x, y)[0] <= TOUCH else back

    def _deepest(self, x: float, y: float) -> tuple[float, float, float]:
        """Return how deep the worst obstacle is in the hull, and the unit vector out of it."""
        worst, out_x, out_y = 0.0, 1.0, 0.0
        for each in self.obstacles:
            gap = each.gap(x, y)
            depth = BODY_RADIUS - gap
            if depth > worst and gap != 0:
                dx, dy = each.away(x, y)
                worst, out_x, out_y = depth, dx / gap, dy / gap
        return worst, out_x, out_y

    def bumps(self, pose: Pose) -> tuple[bool, bool]:
        """Return whether the bumper is pressed left and right."""
        left = right = False
        for each in self.obstacles:
            if each.gap(pose.x, pose.y) <= BODY_RADIUS + TOUCH:
                dx, dy = each.away(pose.x, pose.y)
                bearing = math.remainder(math.atan2(-dy, -dx) - pose.yaw, math.tau)
                if abs(bearing) <= BUMPER_HALF:
                    left = left or bearing >= -BUMPER_MIDDLE
                    right = right or bearing <= BUMPER_MIDDLE
        return left, right

    def wall_signal(self, pose: Pose) -> int:
        """Return the signal of the wall sensor, 0 to WALL_PEAK."""
        dx, dy = math.cos(pose.yaw + WALL_BEARING), math.sin(pose.yaw + WALL_BEARING)
        gap = reach(self.obstacles, pose.x + BODY_RADIUS * dx, pose.y + BODY_RADIUS * dy,
                    dx, dy)
        return int(WALL_PEAK * (WALL_FALL / (WALL_FALL + gap)) ** 2) if gap < WALL_REACH else 0

    def cliff_signals(self, pose: Pose) -> tuple[int, ...]:
        """Return the signals of the four cliff sensors without noise; 0 where no floor is."""
        if not self._edge_near:
            return (int(FLOOR_PEAK * (self._floor or 0.0)),) * 4
        return tuple(int(FLOOR_PEAK * (self._world.floor(*pose.ahead(*place)) or 0.0))
                     for place in CLIFF_PLACES)

    def beams(self, pose: Pose, powered: bool) -> tuple[bool, int]:
        """
        Return whether a virtual wall is seen (packet 13) and the character received (packet 17).

        `powered` is about Home Bases. Their force field sets packet 13 too (manual). The manual's
        table has no character for a Virtual Wall, so packet 17 does not show one.
        """
        world, receiver = self._world, pose.ahead(RECEIVER_FORWARD)
        bits = 0
        for base in world.home_bases if powered else ():
            red, green, field = base.beams_on(receiver)
            if (red or green or field) and self._sees(receiver, base.pose):
                bits |= RED_BUOY * red | GREEN_BUOY * green | FORCE_FIELD * field
        walled = bool(bits & FORCE_FIELD) or any(
            wall.shines_on(receiver) and self._sees(receiver, wall.pose)
            for wall in world.virtual_walls)
        return walled, BEAMS + bits if bits else NO_INFRARED

    def _sees(self, receiver: Point, source: Pose) -> bool:
        """Return whether no obstacle hides a source; the front of a Home Base does not."""
        return sees(self._world.obstacles, receiver, (source.x, source.y))

    def docked(self, pose: Pose) -> bool:
        """Return whether the robot touches the contacts of a Home Base."""
        for base in self._world.home_bases:
            far, bearing = base.pose.polar(pose.x, pose.y)
            askew = math.remainder(pose.yaw - base.pose.yaw - math.pi, math.tau)
            if (abs(far * math.sin(bearing)) <= DOCK_ASIDE and abs(askew) <= DOCK_ASKEW
                    and -TOUCH <= far * math.cos(bearing) - BODY_RADIUS <= DOCK_GAP):
                return True
        return False
