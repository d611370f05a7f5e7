"""Rooms: what stands in them, what floor they have, and where a robot starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Pose(NamedTuple):
    """Place and heading in the world frame: metres, radians counter-clockwise from x."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """A room."""

    name: str = 'empty'
    start: Pose = Pose()
