# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture of room, robot, track and sensors as text, as large as the terminal."""

from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
import math
import os
from typing import TextIO

from ...characters.box_lines import BoxLines, cells_between
from ...characters.canvas import Canvas
from ...characters.dots import Dots
from ...characters.ink import encoded, has_colors, Ink
from ...characters.robot_sign import arrow, CELL_SHAPE, hull
from ...robot import BODY_RADIUS, MILLI
from ..firmware import Create
from ..world import World
from ..world.geometry import Disc, LineSegment, Point

COLUMNS, ROWS = 80, 24
"""Size of the picture at least, and where there is no terminal."""
STATUS_ROWS = 3
AROUND = 1.5
"""Metres that are shown around the track in a room without walls."""
WALL, POST, BASE = '#', 'O', 'H'
INKS = {'~': Ink.WARN, ':': Ink.SIGNAL, BASE: Ink.GOOD}
"""Colours of what is drawn with these characters."""
HOME_CURSOR, CLEAR, CLEAR_REST = '\x1b[H', '\x1b[2J', '\x1b[K'
SLOTS_IN_PLACE, SLOTS_BELOW = 7, 67
"""Slots between two pictures: a tenth of a second over the last one, a second below it."""


def outline(world: World) -> Iterator[tuple[str, LineSegment]]:
    """Yield the lines of a room, each with the character that draws it."""
    for polygon in (*world.ground, *world.cliffs):
        yield from (('~', edge) for edge in polygon.edges)
    for wall in world.virtual_walls:
        yield ':', LineSegment((wall.pose.x, wall.pose.y), wall.pose.ahead(wall.reach))
    for each in world.obstacles:
        match each:
            case LineSegment():
                yield WALL, each
            case Disc(x=x, y=y, radius=radius):
                ring = [(x + radius * math.cos(turn * math.tau / 12),
                         y + radius * math.sin(turn * math.tau / 12)) for turn in range(13)]
                yield from ((POST, LineSegment(a, b)) for a, b in pairwise(ring))
    for base in world.home_bases:
        yield BASE, base.plate


class RoomMap:
    """The part of a canvas that shows all the given points of a room."""

    def __init__(self, canvas: Canvas, points: list[Point]) -> None:
        xs, ys = [x for x, _ in points], [y for _, y in points]
        self._canvas, self._rows = canvas, canvas.rows - STATUS_ROWS
        columns = canvas.columns
        self.cell = max((max(xs) - min(xs)) / (columns - 1),
                        (max(ys) - min(ys)) / (self._rows - 1) / CELL_SHAPE, 1e-3)
        """Width of a cell, metres."""
        self._left = (min(xs) + max(xs)) / 2 - self.cell * (columns - 1) / 2
        self._top = (min(ys) + max(ys)) / 2 + self.cell * CELL_SHAPE * (self._rows - 1) / 2

    def place_of(self, x: float, y: float) -> tuple[float, float]:
        """Return row and column with their fractions; that of a cell is in its middle."""
        return ((self._top - y) / self.cell / CELL_SHAPE + 0.5,
                (x - self._left) / self.cell + 0.5)

    def cell_of(self, point: Point) -> tuple[int, int]:
        """Return row and column."""
        row, column = self.place_of(*point)
        return math.floor(row), math.floor(column)

    def put(self, cell: tuple[int, int], character: str, ink: Ink = Ink.PLAIN) -> None:
        """Draw one character, unless it is outside the map."""
        if 0 <= cell[0] < self._rows:
            self._canvas.put(*cell, character, ink=ink)

    def line(self, character: str, segment: LineSegment) -> None:
        """Draw a line of one character."""
        for cell in cells_between(*map(self.cell_of, segment.ends)):
            self.put(cell, character, INKS.get(character, Ink.PLAIN))

    def walls(self, segments: Iterable[LineSegment]) -> None:
        """Draw walls, joined where they meet."""
        lines = BoxLines()
        for segment in segments:
            lines.add(*map(self.cell_of, segment.ends))
        for cell, character in lines.characters(plain=self._canvas.plain):
            self.put(cell, character)

    def posts(self, discs: Iterable[Disc]) -> None:
        """Draw round posts."""
        for disc in discs:
            dots, width = Dots(), disc.radius / self.cell
            dots.ring(*self.place_of(disc.x, disc.y), width / CELL_SHAPE, width)
            for cell, character in dots.characters(plain=self._canvas.plain):
                self.put(cell, POST if self._canvas.plain else character)

    def track(self, points: Iterable[Point]) -> None:
        """Draw where the robot has been."""
        dots = Dots()
        for point in points:
            dots.add(*self.place_of(*point))
        self._put_dots(dots, Ink.TRACK)

    def robot(self, here: Point, yaw: float) -> None:
        """Draw the robot: its hull in scale, if there is room, and an arrow."""
        plain = self._canvas.plain
        self._put_dots(
            hull(*self.place_of(*here), BODY_RADIUS / self.cell, plain=plain), Ink.ROBOT)
        self.put(self.cell_of(here), arrow(yaw, plain=plain), Ink.ROBOT)

    def _put_dots(self, dots: Dots, ink: Ink) -> None:
        for cell, character in dots.characters(plain=self._canvas.plain):
            self.put(cell, character, ink)


class Show:
    """Remembers the robot's track and draws the picture."""

    LONGEST_TRACK = 3000
    """Points."""

    def __init__(self, create: Create) -> None:
        self._create = create
        self._outline = list(outline(create.body.world))
        self._track: list[Point] = []

    def picture(self, columns: int, rows: int, *, plain: bool) -> Canvas:
        """Draw everything."""
        canvas = Canvas(columns, rows, plain=plain)
        self._draw_map(canvas)
        for row, (line, ink) in enumerate(self._status(), rows - STATUS_ROWS):
            canvas.put(row, 0, line, ink=ink)
        return canvas

    def _draw_map(self, canvas: Canvas) -> None:
        pose = self._create.body.truth().pose
        here = (pose.x, pose.y)
        if not self._track or math.dist(here, self._track[-1]) > 0.03:
            self._track = [*self._track[-self.LONGEST_TRACK:], here]
        points = [end for _, segment in self._outline for end in segment.ends] or [
            (x + side, y + side) for x, y in self._track for side in (-AROUND, AROUND)]
        room_map = RoomMap(canvas, points)
        room_map.track(self._track)
        late = (WALL, POST, BASE)
        for character, segment in self._outline:
            if character not in late:
                room_map.line(character, segment)
        room_map.walls(segment for character, segment in self._outline if character == WALL)
        room_map.posts(each for each in self._create.body.world.obstacles
                       if isinstance(each, Disc))
        for character, segment in self._outline:
            if character == BASE:
                room_map.line(character, segment)
        room_map.robot(here, pose.yaw)

    def _status(self) -> list[tuple[str, Ink]]:
        create, truth = self._create, self._create.body.truth()
        sense = create.body.sense()
        on = ' '.join(name for name, value in sense._asdict().items()
                      if value is True and name != 'device_detect')
        demo = f' {create.demo.name.lower()}' if create.demo is not None else ''
        lines = [
            f'{create.time:8.1f} s  {create.mode.name}{demo}  x {truth.pose.x:.2f} '
            f'y {truth.pose.y:.2f} m  {math.degrees(truth.pose.yaw):.0f}°  '
            f'{truth.speed:.2f} m/s {math.degrees(truth.rate):.0f}°/s',
            f'wheels {create.actuators.wheels.left:.0f} {create.actuators.wheels.right:.0f} mm/s'
            f'  {sense.voltage * MILLI:.1f} V {sense.current} mA  wall {sense.wall_signal}'
            f'  infrared {sense.infrared}  frames {create.frames}',
        ]
        return [*((line, Ink.PLAIN) for line in lines),
                (on or 'nothing touched', Ink.BAD if on else Ink.FAINT)]


def has_cursor(screen: TextIO) -> bool:
    """Return whether a stream is a terminal that obeys escape sequences."""
    return screen.isatty() and os.environ.get('TERM', 'dumb') != 'dumb'


def writes_utf8(screen: TextIO) -> bool:
    """Return whether a stream takes box characters."""
    return (screen.encoding or '').lower().replace('-', '') == 'utf8'


def size_of(screen: TextIO, *, in_place: bool) -> tuple[int, int]:
    """Return columns and rows of the picture: those of the terminal, if it has more than usual."""
    if not in_place:
        return COLUMNS, ROWS
    try:
        columns, rows = os.get_terminal_size(screen.fileno())
    except OSError:
        return COLUMNS, ROWS
    return max(columns, COLUMNS), max(rows, ROWS)


def shower(create: Create, screen: TextIO) -> Callable[[], None]:
    """
    Return a function that is called in every slot and draws in some.

    Without a cursor (a file, a pipe, TERM=dumb) each picture stands below the last one.
    """
    show, slots, in_place = Show(create), 0, has_cursor(screen)
    colors, plain = in_place and has_colors(os.environ), not writes_utf8(screen)
    period = SLOTS_IN_PLACE if in_place else SLOTS_BELOW
    before = (0, 0)

    def draw() -> None:
        nonlocal slots, before
        slots += 1
        if slots % period:
            return
        size = size_of(screen, in_place=in_place)
        drawn = show.picture(*size, plain=plain)
        if in_place:
            # Cleared first: behind the last column it would clear that one, too.
            screen.write(('' if size == before else CLEAR) + HOME_CURSOR + '\n'.join(
                CLEAR_REST + encoded(row, colors=colors) for row in drawn.runs()))
            before = size
        else:
            screen.write('\n'.join([*(line.rstrip() for line in drawn.lines()), '', '']))
        screen.flush()
    return draw
