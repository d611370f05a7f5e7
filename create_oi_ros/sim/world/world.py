# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Rooms: their obstacles, their floor, and where a robot starts.

A room file has a keyword and its numbers on each line, in metres and degrees (counter-clockwise
from x). `#` starts a comment; blank lines are ignored.

    start X Y YAW               the robot's first pose (0 0 0)
    floor R                     reflectance of the floor, 0 (black) to 1 (white); default 0.6
    patch R X Y X Y X Y ...     another reflectance in a polygon; later lines lie on top
    ground X Y X Y X Y ...      a polygon outside of which there is no floor: a table, a stage
    cliff X Y X Y X Y ...       a polygon without floor: stairs, a pit
    wall X Y X Y ...            straight walls from point to point
    box X Y X Y                 a closed box between two corners
    post X Y R                  a round obstacle of radius R
    virtual_wall X Y YAW L      an iRobot Virtual Wall whose beam runs L metres along YAW
    home_base X Y YAW           a Home Base that faces YAW; X Y is the middle of its front

`parse` raises WorldError with the file's name and the line number for anything else.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import resources
import math
from typing import NamedTuple

from .. import LONGEST, number
from .geometry import chain, Disc, LineSegment, Obstacle, Point, Polygon

PLATE = 0.1
"""Half the width of a Home Base's front, metres (guess)."""
BUOY_REACH = 2.4
"""Range of a Home Base's two buoy beams, metres (reported: 8 feet)."""
BUOY_SPREAD = math.radians(50)
"""Angle by which a buoy beam opens to its own side (guess)."""
BUOY_OVERLAP = math.radians(3)
"""Angle by which it reaches to the other side; there, both beams are seen (guess)."""
FIELD_REACH = 0.5
"""Range of the force field in front of a Home Base, metres (guess)."""
HALO = 0.3
"""Distance within which a Virtual Wall is seen from all sides, metres (guess)."""
VIRTUAL_WALL_SPREAD = math.radians(8)
"""Half the opening of a Virtual Wall's beam (guess)."""


class WorldError(ValueError):
    """A line of a world file is wrong; the message says where, why, and what is allowed."""


class Pose(NamedTuple):
    """Place and heading in the world frame: metres, radians counter-clockwise from x."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def ahead(self, forward: float, left: float = 0.0) -> Point:
        """Return the world coordinates of a point given in this pose's frame."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + forward * cos - left * sin, self.y + forward * sin + left * cos

    def polar(self, x: float, y: float) -> tuple[float, float]:
        """Return distance and bearing (-pi to pi, left positive) of a point seen from here."""
        x, y = x - self.x, y - self.y
        return math.hypot(x, y), math.remainder(math.atan2(y, x) - self.yaw, math.tau)


@dataclass(frozen=True, slots=True)
class VirtualWall:
    """An iRobot Virtual Wall and its beam."""

    pose: Pose
    reach: float

    def shines_on(self, point: Point) -> bool:
        """Return whether the beam, or the halo round the unit, covers the point."""
        far, bearing = self.pose.polar(*point)
        return far <= HALO or (far <= self.reach and abs(bearing) <= VIRTUAL_WALL_SPREAD)


@dataclass(frozen=True, slots=True)
class HomeBase:
    """
    A Home Base: a plate to touch, two buoy beams side by side, a force field in front.

    The red beam is on the right of a robot that comes in (users' docking programs turn left on
    red and right on green).
    """

    pose: Pose

    @property
    def plate(self) -> LineSegment:
        """The front, as an obstacle."""
        return LineSegment(self.pose.ahead(0, -PLATE), self.pose.ahead(0, PLATE))

    def beams_on(self, point: Point) -> tuple[bool, bool, bool]:
        """Return whether red buoy, green buoy and force field cover the point."""
        far, bearing = self.pose.polar(*point)
        near = far <= BUOY_REACH
        return (near and -BUOY_OVERLAP <= bearing <= BUOY_SPREAD,
                near and -BUOY_SPREAD <= bearing <= BUOY_OVERLAP,
                far <= FIELD_REACH and abs(bearing) <= math.pi / 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """A room; immutable. Without arguments: endless floor and nothing on it."""

    name: str = 'empty'
    start: Pose = Pose()
    reflectance: float = 0.6
    """Of the floor where no patch is, 0 to 1."""
    patches: tuple[tuple[float, Polygon], ...] = ()
    ground: tuple[Polygon, ...] = ()
    """If given, there is floor only inside one of these."""
    cliffs: tuple[Polygon, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    virtual_walls: tuple[VirtualWall, ...] = ()
    home_bases: tuple[HomeBase, ...] = ()

    def floor(self, x: float, y: float) -> float | None:
        """Return the reflectance of the floor at a point; None where there is no floor."""
        point = (x, y)
        if self.ground and not any(point in each for each in self.ground):
            return None
        if any(point in each for each in self.cliffs):
            return None
        for reflectance, region in reversed(self.patches):
            if point in region:
                return reflectance
        return self.reflectance

    @property
    def borders(self) -> tuple[Polygon, ...]:
        """All polygons at whose edge the floor changes."""
        return (*self.ground, *self.cliffs, *(region for _, region in self.patches))


KEYWORDS = {
    'start': 'X Y YAW',
    'floor': 'R',
    'patch': 'R X Y X Y X Y ...',
    'ground': 'X Y X Y X Y ...',
    'cliff': 'X Y X Y X Y ...',
    'wall': 'X Y X Y ...',
    'box': 'X Y X Y',
    'post': 'X Y R',
    'virtual_wall': 'X Y YAW L',
    'home_base': 'X Y YAW',
}
"""The numbers of each line; three dots take more X Y pairs."""


def _fits(form: str, count: int) -> bool:
    """Return whether a line of this form may have this many numbers."""
    more = count - len(form.removesuffix(' ...').split())
    return more == 0 or (form.endswith('...') and more > 0 and more % 2 == 0)


def parse(text: str, name: str) -> World:
    """Read a room; messages of WorldError begin with its name."""
    world = World(name=name)
    for line_number, line in enumerate(text.splitlines(), 1):
        words = line.partition('#')[0].split()
        if words:
            try:
                world = _with_line(world, words)
            except ValueError as error:
                raise WorldError(f'{name}, line {line_number}: {error}') from None
    return world


def _with_line(world: World, words: Sequence[str]) -> World:
    """Return a world with what another line says."""
    form = KEYWORDS.get(words[0])
    if form is None:
        raise ValueError(f'unknown {words[0][:LONGEST]!r}; allowed: {", ".join(KEYWORDS)}')
    numbers = [number(each) for each in words[1:]]
    if not _fits(form, len(numbers)):
        raise ValueError(f'{len(numbers)} numbers after {words[0]!r}; '
                         f'allowed: "{words[0]} {form}"')
    obstacles = world.obstacles
    match words[0]:
        case 'start':
            return replace(world, start=_pose(numbers))
        case 'floor':
            return replace(world, reflectance=_fraction(numbers[0]))
        case 'patch':
            patch = _fraction(numbers[0]), Polygon(_points(numbers[1:]))
            return replace(world, patches=(*world.patches, patch))
        case 'ground':
            return replace(world, ground=(*world.ground, Polygon(_points(numbers))))
        case 'cliff':
            return replace(world, cliffs=(*world.cliffs, Polygon(_points(numbers))))
        case 'wall':
            return replace(world, obstacles=(*obstacles, *chain(_points(numbers))))
        case 'box':
            (ax, ay), (bx, by) = _points(numbers)
            box = chain([(ax, ay), (bx, ay), (bx, by), (ax, by), (ax, ay)])
            return replace(world, obstacles=(*obstacles, *box))
        case 'post':
            return replace(world, obstacles=(*obstacles, Disc(*numbers)))
        case 'virtual_wall':
            if not numbers[3] > 0:
                raise ValueError(f'a beam of {numbers[3]} metres; allowed: above 0')
            wall = VirtualWall(_pose(numbers), numbers[3])
            return replace(world, virtual_walls=(*world.virtual_walls, wall))
        case _:
            base = HomeBase(_pose(numbers))
            return replace(world, home_bases=(*world.home_bases, base),
                           obstacles=(*obstacles, base.plate))


def _fraction(number: float) -> float:
    if not 0 <= number <= 1:
        raise ValueError(f'reflectance {number}; allowed: 0 to 1')
    return number


def _points(numbers: Sequence[float]) -> list[Point]:
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def _pose(numbers: Sequence[float]) -> Pose:
    return Pose(numbers[0], numbers[1], math.radians(numbers[2]))


def shipped_names() -> tuple[str, ...]:
    """Return the names of the rooms in the package."""
    folder = resources.files(__package__) / 'shipped'
    return tuple(sorted(each.name.removesuffix('.world') for each in folder.iterdir()
                        if each.name.endswith('.world')))


def shipped(name: str) -> World:
    """Read a room of the package; FileNotFoundError: none has this name."""
    text = (resources.files(__package__) / 'shipped' / f'{name}.world').read_text('utf-8')
    return parse(text, name)
