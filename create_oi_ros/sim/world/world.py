"""
Rooms: what stands in them, what floor they have, and where a robot starts.

A room is a text of lines, each a word and its numbers, in metres and degrees (counter-clockwise
from x).  `#` starts a comment; blank lines say nothing.

    start X Y YAW               the robot's first pose (0 0 0)
    floor R                     what the floor reflects, 0 (black) to 1 (white); 0.6 if not said
    patch R X Y X Y X Y ...     another floor on a polygon; later lines lie on top
    ground X Y X Y X Y ...      there is floor inside this polygon only: a table, a stage
    cliff X Y X Y X Y ...       a polygon without floor: stairs, a pit
    wall X Y X Y ...            straight walls from point to point
    box X Y X Y                 a closed box between two corners
    post X Y R                  a round obstacle of radius R
    virtual_wall X Y YAW L      an iRobot Virtual Wall whose beam runs L metres along YAW
    home_base X Y YAW           a Home Base that faces YAW; X Y is the middle of its front

`parse` raises WorldError with the file's name and the line for anything else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import resources
import math
from typing import NamedTuple

from .geometry import chain, Disc, LineSegment, Obstacle, Point, Polygon

PLATE = 0.1
"""Half the width of a Home Base's front, metres (guess)."""
BUOY_REACH = 2.4
"""Metres at which a Home Base's two buoy beams are still seen (reported: 8 feet)."""
BUOY_SPREAD = math.radians(50)
"""How far a buoy beam opens to its own side (guess)."""
BUOY_OVERLAP = math.radians(3)
"""How far it reaches over to the other side: between, both are seen (guess)."""
FIELD_REACH = 0.5
"""Metres of force field in front of a Home Base (guess)."""
HALO = 0.3
"""Metres around a Virtual Wall within which it is seen from all sides (guess)."""
VIRTUAL_WALL_SPREAD = math.radians(8)
"""Half the opening of a Virtual Wall's beam (guess)."""


class WorldError(ValueError):
    """A line of a world file cannot be understood; the message says where, why and what can."""


class Pose(NamedTuple):
    """Place and heading in the world frame: metres, radians counter-clockwise from x."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def ahead(self, forward: float, left: float = 0.0) -> Point:
        """Return the world's name for a point given in this pose's frame."""
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
    """A room; immutable.  Without arguments: endless floor and nothing on it."""

    name: str = 'empty'
    start: Pose = Pose()
    reflectance: float = 0.6
    """Of the floor where no patch lies: 0 to 1."""
    patches: tuple[tuple[float, Polygon], ...] = ()
    ground: tuple[Polygon, ...] = ()
    """Where given, there is floor only inside one of these."""
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
    """A world while its lines are being read: one method for each word."""

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
            raise ValueError(f'a beam of {numbers[3]} metres must be longer than 0')
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
    """How a line is read: its method, its form for messages, how many numbers it wants."""

    read: Callable[[_Draft, Sequence[float]], None]
    form: str
    least: int
    most: float

    def fits(self, count: int) -> bool:
        """Return whether a line may have so many numbers; an open end takes whole points."""
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
    """Read a room; `name` is its name and stands in the messages of WorldError."""
    draft = _Draft()
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition('#')[0].split()
        if words:
            try:
                _read(draft, words)
            except ValueError as error:
                raise WorldError(f'{name}, line {number}: {error}') from None
    return draft.world(name)


def _read(draft: _Draft, words: Sequence[str]) -> None:
    word = KEYWORDS.get(words[0])
    if word is None:
        raise ValueError(f'{words[0]!r} is not known: one of {", ".join(KEYWORDS)}')
    numbers = [_number(each) for each in words[1:]]
    if not word.fits(len(numbers)):
        raise ValueError(f'{len(numbers)} numbers after {words[0]!r}: '
                         f'"{words[0]} {word.form}" is wanted')
    word.read(draft, numbers)


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f'{text!r} is not a number')
    return number


def _fraction(number: float) -> float:
    if not 0 <= number <= 1:
        raise ValueError(f'a reflectance of {number} is not within 0 to 1')
    return number


def _points(numbers: Sequence[float]) -> list[Point]:
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def _pose(numbers: Sequence[float]) -> Pose:
    return Pose(numbers[0], numbers[1], math.radians(numbers[2]))


def shipped_names() -> tuple[str, ...]:
    """Return the names of the rooms that come with the package."""
    folder = resources.files(__package__) / 'shipped'
    return tuple(sorted(each.name.removesuffix('.world') for each in folder.iterdir()
                        if each.name.endswith('.world')))


def shipped(name: str) -> World:
    """Read a room that comes with the package; ValueError names them all."""
    if name not in shipped_names():
        raise ValueError(f'no world {name!r}: one of {", ".join(shipped_names())}')
    text = (resources.files(__package__) / 'shipped' / f'{name}.world').read_text('utf-8')
    return parse(text, name)
