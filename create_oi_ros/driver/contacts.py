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
from .motion import BUMPS

OUTSIDE = 0.085
"""Metres outside the hull. A costmap clears each cell that the robot's footprint touches. So this
is the diagonal of a cell of 5 cm, and what Nav2 adds to a footprint."""
LEFT_BEHIND = 0.1
"""Metres by which a robot must move to have left what it felt."""
BUMPERS = {int(oi.BumpsAndWheelDrops.BUMP_LEFT): 'bump left',
           int(oi.BumpsAndWheelDrops.BUMP_RIGHT): 'bump right', BUMPS: 'bump front'}
CLIFFS = ('cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right')
BEARINGS = {
    'bump left': BUMPER_BEARING, 'bump right': -BUMPER_BEARING, 'bump front': 0,
    **dict(zip(CLIFFS, CLIFF_BEARINGS)), 'virtual_wall': 0}
"""Degrees to the left at which each sensor looks."""


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


class Contacts:
    """Remembers what was felt, for a while and until the robot has moved away."""

    def __init__(self) -> None:
        self._hits: dict[str, Hit] = {}

    def update(self, readings: oi.Readings, at: Estimate, stamp: float,
               persistence: float) -> None:
        """Take a frame in; what is no longer felt is kept for `persistence` seconds."""
        found = [name for name in (*CLIFFS, 'virtual_wall') if readings.number(name, 0)]
        bumps = readings.number('bumps_and_wheel_drops', 0) & BUMPS
        if bumps:
            found.append(BUMPERS[bumps])
        for name in found:
            bearing, far = at.yaw + radians(BEARINGS[name]), BODY_RADIUS + OUTSIDE
            self._hits[name] = Hit(
                at.x + far * cos(bearing), at.y + far * sin(bearing), at, stamp)
        if 'bump front' in found:  # one half is pressed a moment before the other
            self._hits.pop('bump left', None)
            self._hits.pop('bump right', None)
        for name, hit in list(self._hits.items()):
            moved = hypot(at.x - hit.at.x, at.y - hit.at.y)
            if stamp > hit.stamp and (stamp - hit.stamp > persistence or moved > LEFT_BEHIND):
                del self._hits[name]

    def points(self, at: Estimate) -> tuple[tuple[float, float], ...]:
        """Return the points, m, forward and to the left of a robot that is here."""
        c, s = cos(at.yaw), sin(at.yaw)
        return tuple((c * (hit.x - at.x) + s * (hit.y - at.y),
                      c * (hit.y - at.y) - s * (hit.x - at.x)) for hit in self._hits.values())
