"""A picture of room, robot, track and sensors as text: 24 lines of 80 characters."""

from collections.abc import Callable, Iterator
import math
import os
from typing import TextIO

from ...robot import MILLI
from ..firmware import Create
from ..world import World
from ..world.geometry import Disc, LineSegment, Point

COLUMNS, ROWS = 80, 24
STATUS_ROWS = 3
CELL_SHAPE = 2.0
"""Height of a character over its width."""
AROUND = 1.5
"""Metres that are shown around the track in a room without walls."""
ARROWS = '→↗↑↖←↙↓↘'
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
                yield '#', each
            case Disc(x=x, y=y, radius=radius):
                ring = [(x + radius * math.cos(turn * math.tau / 12),
                         y + radius * math.sin(turn * math.tau / 12)) for turn in range(13)]
                yield from (('O', LineSegment(a, b)) for a, b in zip(ring, ring[1:], strict=False))
    for base in world.home_bases:
        yield 'H', base.plate


class RoomMap:
    """A sheet of characters, scaled so that it shows all the given points of a room."""

    def __init__(self, points: list[Point], columns: int, rows: int) -> None:
        xs, ys = [x for x, _ in points], [y for _, y in points]
        self._columns, self._rows = columns, rows
        self._cell = max((max(xs) - min(xs)) / (columns - 1),
                         (max(ys) - min(ys)) / (rows - 1) / CELL_SHAPE, 1e-3)
        self._left = (min(xs) + max(xs)) / 2 - self._cell * (columns - 1) / 2
        self._top = (min(ys) + max(ys)) / 2 + self._cell * CELL_SHAPE * (rows - 1) / 2
        self._sheet = [[' '] * columns for _ in range(rows)]

    def put(self, character: str, x: float, y: float) -> None:
        """Draw one character, unless it is outside the sheet."""
        column = round((x - self._left) / self._cell)
        row = round((self._top - y) / self._cell / CELL_SHAPE)
        if 0 <= column < self._columns and 0 <= row < self._rows:
            self._sheet[row][column] = character

    def line(self, character: str, segment: LineSegment) -> None:
        """Draw a line."""
        (ax, ay), (bx, by) = segment.ends
        steps = max(1, math.ceil(segment.length / self._cell))
        for step in range(steps + 1):
            self.put(character, ax + (bx - ax) * step / steps, ay + (by - ay) * step / steps)

    def text(self) -> list[str]:
        """Return the lines of the sheet."""
        return [''.join(row).rstrip() for row in self._sheet]


class Show:
    """Remembers the robot's track and draws the picture."""

    LONGEST_TRACK = 3000
    """Points."""

    def __init__(self, create: Create) -> None:
        self._create = create
        self._outline = list(outline(create.body.world))
        self._track: list[Point] = []

    def picture(self) -> list[str]:
        """Return the lines of the picture."""
        return [line[:COLUMNS] for line in self._map() + self._status()]

    def _map(self) -> list[str]:
        pose = self._create.body.truth().pose
        here = (pose.x, pose.y)
        if not self._track or math.dist(here, self._track[-1]) > 0.03:
            self._track = [*self._track[-self.LONGEST_TRACK:], here]
        points = [end for _, segment in self._outline for end in segment.ends] or [
            (x + side, y + side) for x, y in self._track for side in (-AROUND, AROUND)]
        room_map = RoomMap(points, COLUMNS, ROWS - STATUS_ROWS)
        for x, y in self._track:
            room_map.put('·', x, y)
        for character, segment in self._outline:
            room_map.line(character, segment)
        room_map.put(ARROWS[round(pose.yaw / (math.tau / 8)) % 8], *here)
        return room_map.text()

    def _status(self) -> list[str]:
        create, truth = self._create, self._create.body.truth()
        sense = create.body.sense()
        on = ' '.join(name for name, value in sense._asdict().items()
                      if value is True and name != 'device_detect')
        demo = f' {create.demo.name.lower()}' if create.demo is not None else ''
        return [
            f'{create.time:8.1f} s  {create.mode.name}{demo}  x {truth.pose.x:.2f} '
            f'y {truth.pose.y:.2f} m  {math.degrees(truth.pose.yaw):.0f}°  '
            f'{truth.speed:.2f} m/s {math.degrees(truth.rate):.0f}°/s',
            f'wheels {create.actuators.wheels.left:.0f} {create.actuators.wheels.right:.0f} mm/s'
            f'  {sense.voltage * MILLI:.1f} V {sense.current} mA  wall {sense.wall_signal}'
            f'  infrared {sense.infrared}  frames {create.frames}',
            f'{on or "nothing touched"}',
        ]


def has_cursor(screen: TextIO) -> bool:
    """Return whether a stream is a terminal that obeys escape sequences."""
    return screen.isatty() and os.environ.get('TERM', 'dumb') != 'dumb'


def shower(create: Create, screen: TextIO) -> Callable[[], None]:
    """
    Return a function that is called in every slot and draws in some.

    Without a cursor (a file, a pipe, TERM=dumb) each picture stands below the last one.
    """
    show, slots, in_place = Show(create), 0, has_cursor(screen)
    period = SLOTS_IN_PLACE if in_place else SLOTS_BELOW
    if in_place:
        screen.write(CLEAR)

    def draw() -> None:
        nonlocal slots
        slots += 1
        if slots % period:
            return
        lines = show.picture()
        if in_place:
            screen.write(HOME_CURSOR + '\n'.join(line + CLEAR_REST for line in lines))
        else:
            screen.write('\n'.join([*lines, '', '']))
        screen.flush()
    return draw
