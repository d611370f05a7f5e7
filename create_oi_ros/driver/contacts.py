# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the robot has felt around it, as points outside its hull, for costmaps.

A point is where the sensor felt something, in the frame of the odometry; seen from the robot it
moves as the robot does. There are no points where nothing is felt.
"""

from math import cos, hypot, radians, sin
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate
from ..robot import BODY_RADIUS, BUMPER_BEARING, CLIFF_BEARINGS
from .goals.goal import CLIFFS

OUTSIDE = 0.085
"""Metres outside the hull. A costmap clears each cell that the robot's footprint touches. So this
is the diagonal of a cell of 5 cm, and what Nav2 adds to a footprint."""
AWAY = 0.1
"""Metres by which a robot must move to have left what it felt."""
LEFT, RIGHT = map(int, (oi.BumpsAndWheelDrops.BUMP_LEFT, oi.BumpsAndWheelDrops.BUMP_RIGHT))
BEARINGS = {
    'bump left': BUMPER_BEARING, 'bump right': -BUMPER_BEARING, 'bump front': 0,
    **dict(zip(CLIFFS, CLIFF_BEARINGS)), 'virtual wall': 0}
"""Degrees to the left at which each sensor looks."""
SIDES = ('bump left', 'bump right')
FEELERS = ('bumps_and_wheel_drops', *CLIFFS, 'virtual_wall')
feelers = oi.Readings.numbers(*FEELERS)


class Hit(NamedTuple):
    """Something that was felt."""

    x: float
    """m, in the frame of the odometry."""
    y: float
    """m."""
    at: Estimate
    """Where the robot was when it was last felt."""
    stamp: float
    """When that was, s."""


def felt(readings: oi.Readings) -> list[str]:
    """Return the sensors that feel something now."""
    try:
        if not any(feelers(readings)):
            return []  # as in most frames
    except KeyError:
        pass  # one of them has not arrived
    bits = int(readings.bumps_and_wheel_drops)
    found = [name for name in CLIFFS if readings.has(name) and getattr(readings, name)]
    if bits & LEFT and bits & RIGHT:
        found.append('bump front')
    elif bits & LEFT:
        found.append('bump left')
    elif bits & RIGHT:
        found.append('bump right')
    if readings.has('virtual_wall') and readings.virtual_wall:
        found.append('virtual wall')
    return found


class Contacts:
    """Remembers what was felt, for a while and until the robot has moved away."""

    def __init__(self) -> None:
        self._hits: dict[str, Hit] = {}

    def update(self, readings: oi.Readings, at: Estimate, stamp: float,
               persistence: float) -> None:
        """Take a frame in; what is no longer felt is kept for `persistence` seconds."""
        found = felt(readings)
        if not found and not self._hits:
            return
        for name in found:
            self._hits[name] = _hit(name, at, stamp)
        if 'bump front' in self._hits and self._hits['bump front'].stamp == stamp:
            for side in SIDES:  # one half is pressed a moment before the other
                self._hits.pop(side, None)
        for name, hit in list(self._hits.items()):
            moved = hypot(at.x - hit.at.x, at.y - hit.at.y)
            if stamp > hit.stamp and (stamp - hit.stamp > persistence or moved > AWAY):
                del self._hits[name]

    def points(self, at: Estimate) -> tuple[tuple[float, float], ...]:
        """Return the points, m, forward and to the left of a robot that is here."""
        if not self._hits:
            return ()
        c, s = cos(at.yaw), sin(at.yaw)
        return tuple((c * (hit.x - at.x) + s * (hit.y - at.y),
                      c * (hit.y - at.y) - s * (hit.x - at.x)) for hit in self._hits.values())


def _hit(name: str, at: Estimate, stamp: float) -> Hit:
    bearing = at.yaw + radians(BEARINGS[name])
    far = BODY_RADIUS + OUTSIDE
    return Hit(at.x + far * cos(bearing), at.y + far * sin(bearing), at, stamp)
