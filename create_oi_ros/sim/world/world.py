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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import resources
import math
from typing import NamedTuple

from ..numbers import LONGEST, number
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
    plate: LineSegment = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, 'plate', LineSegment(self.pose.ahead(0, -PLATE),
                                                  self.pose.ahead(0, PLATE)))

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


class _Draft:
    """A world while its lines are read: one method for each keyword."""

    __slots__ = ('start', 'reflectance', 'patches', 'ground', 'cliffs', 'obstacles',
                 'virtual_walls', 'home_bases')

    def __init__(self) -> None:
        self.start = Pose()
        self.reflectance = 0.6
        self.patches: list[tuple[float, Polygon]] = []
        self.ground: list[Polygon] = []
        self.cliffs: list[Polygon] = []
        self.obstacles: list[Obstacle] = []
        self.virtual_walls: list[VirtualWall] = []
        self.home_bases: list[HomeBase] = []

    def set_start(self, numbers: Sequence[float]) -> None:
        self.start = _pose(numbers)

    def set_floor(self, numbers: Sequence[float]) -> None:
        self.reflectance = _fraction(numbers[0])

    def add_patch(self, numbers: Sequence[float]) -> None:
        self.patches.append((_fraction(numbers[0]), Polygon(_points(numbers[1:]))))

    def add_ground(self, numbers: Sequence[float]) -> None:
        self.ground.append(Polygon(_points(numbers)))

    def add_cliff(self, numbers: Sequence[float]) -> None:
        self.cliffs.append(Polygon(_points(numbers)))

    def add_wall(self, numbers: Sequence[float]) -> None:
        self.obstacles.extend(chain(_points(numbers)))

    def add_box(self, numbers: Sequence[float]) -> None:
        (ax, ay), (bx, by) = _points(numbers)
        self.obstacles.extend(chain([(ax, ay), (bx, ay), (bx, by), (ax, by), (ax, ay)]))

    def add_post(self, numbers: Sequence[float]) -> None:
        self.obstacles.append(Disc(*numbers))

    def add_virtual_wall(self, numbers: Sequence[float]) -> None:
        if not numbers[3] > 0:
            raise ValueError(f'a beam of {numbers[3]} metres; allowed: above 0')
        self.virtual_walls.append(VirtualWall(_pose(numbers), numbers[3]))

    def add_home_base(self, numbers: Sequence[float]) -> None:
        self.home_bases.append(HomeBase(_pose(numbers)))
        self.obstacles.append(self.home_bases[-1].plate)

    def world(self, name: str) -> World:
        return World(name=name, start=self.start, reflectance=self.reflectance,
                     patches=tuple(self.patches), ground=tuple(self.ground),
                     cliffs=tuple(self.cliffs), obstacles=tuple(self.obstacles),
                     virtual_walls=tuple(self.virtual_walls),
                     home_bases=tuple(self.home_bases))


class Keyword(NamedTuple):
    """How a line is read: its method, its form for messages, how many numbers it takes."""

    read: Callable[[_Draft, Sequence[float]], None]
    form: str
    least: int
    most: float

    def fits(self, count: int) -> bool:
        """Return whether a line may have this many numbers; an open end takes X Y pairs."""
        return self.least <= count <= self.most and (
            self.most < math.inf or (count - self.least) % 2 == 0)


KEYWORDS = {
    'start': Keyword(_Draft.set_start, 'X Y YAW', 3, 3),
    'floor': Keyword(_Draft.set_floor, 'R', 1, 1),
    'patch': Keyword(_Draft.add_patch, 'R X Y X Y X Y ...', 7, math.inf),
    'ground': Keyword(_Draft.add_ground, 'X Y X Y X Y ...', 6, math.inf),
    'cliff': Keyword(_Draft.add_cliff, 'X Y X Y X Y ...', 6, math.inf),
    'wall': Keyword(_Draft.add_wall, 'X Y X Y ...', 4, math.inf),
    'box': Keyword(_Draft.add_box, 'X Y X Y', 4, 4),
    'post': Keyword(_Draft.add_post, 'X Y R', 3, 3),
    'virtual_wall': Keyword(_Draft.add_virtual_wall, 'X Y YAW L', 4, 4),
    'home_base': Keyword(_Draft.add_home_base, 'X Y YAW', 3, 3),
}


def parse(text: str, name: str) -> World:
    """Read a room; messages of WorldError begin with its name."""
    draft = _Draft()
    for line_number, line in enumerate(text.splitlines(), 1):
        words = line.partition('#')[0].split()
        if words:
            try:
                _read(draft, words)
            except ValueError as error:
                raise WorldError(f'{name}, line {line_number}: {error}') from None
    return draft.world(name)


def _read(draft: _Draft, words: Sequence[str]) -> None:
    keyword = KEYWORDS.get(words[0])
    if keyword is None:
        raise ValueError(f'unknown {words[0][:LONGEST]!r}; allowed: {", ".join(KEYWORDS)}')
    numbers = [number(each) for each in words[1:]]
    if not keyword.fits(len(numbers)):
        raise ValueError(f'{len(numbers)} numbers after {words[0]!r}; '
                         f'allowed: "{words[0]} {keyword.form}"')
    keyword.read(draft, numbers)


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
    """Read a room of the package; ValueError lists all their names."""
    if name not in shipped_names():
        raise ValueError(f'no world {name!r}; allowed: {", ".join(shipped_names())}')
    text = (resources.files(__package__) / 'shipped' / f'{name}.world').read_text('utf-8')
    return parse(text, name)
