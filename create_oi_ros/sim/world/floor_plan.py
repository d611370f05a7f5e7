# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A world for other programs: a map for Nav2, outlines for a drawing. Pure: text and numbers.

Beams have no place in a map: virtual walls and the signals of Home Bases are left out. A cliff is
occupied, since no robot may go there.
"""

from collections.abc import Iterator
from math import ceil, floor, hypot
from typing import NamedTuple

from .geometry import Disc, LineSegment, Obstacle, Point, Polygon
from .world import World, WorldError

RESOLUTION = 0.02
"""Metres of a cell."""
MARGIN = 0.5
"""Metres around everything; a world with nothing in it is EMPTY metres wide either way."""
EMPTY = 3.0
LARGEST = 200.0
"""Side of the largest map's square, metres: 100 MB."""
OCCUPIED, UNKNOWN, FREE = 0, 205, 254
"""Grey values, as Nav2 reads them with the thresholds below."""


class Map(NamedTuple):
    """A map of cells; the first row is the one with the highest y, as in an image."""

    width: int
    height: int
    x: float
    """m, of the lower left corner."""
    y: float
    """m, of the same."""
    cells: bytes

    def pgm(self) -> bytes:
        """Return the image."""
        return f'P5\n{self.width} {self.height}\n255\n'.encode() + self.cells

    def yaml(self, image: str, name: str) -> str:
        """Return the description that goes with the image."""
        return (f'# World {name}; free is what can be reached from the start.\n'
                f'image: {image}\nmode: trinary\nresolution: {RESOLUTION}\n'
                f'origin: [{self.x:.3f}, {self.y:.3f}, 0.0]\nnegate: 0\n'
                'occupied_thresh: 0.65\nfree_thresh: 0.196\n')


def map_of(world: World) -> Map:
    low_x, low_y, high_x, high_y = _bounds(world)
    left, bottom = floor(low_x / RESOLUTION), floor(low_y / RESOLUTION)
    width, height = ceil(high_x / RESOLUTION) - left, ceil(high_y / RESOLUTION) - bottom
    if width * height > (LARGEST / RESOLUTION) ** 2:
        raise WorldError(
            f'{world.name}: {width * RESOLUTION:.0f} m by {height * RESOLUTION:.0f} m is too '
            f'large for a map; allowed: the area of {LARGEST:.0f} m by {LARGEST:.0f} m')
    cells = bytearray([UNKNOWN]) * (width * height)  # rows from the lowest y up

    def middles(points: list[Point]) -> Iterator[tuple[int, float, float]]:
        """Yield the cells of the box around points, with their middles."""
        xs, ys = zip(*points)
        for row in range(max(0, floor(min(ys) / RESOLUTION) - bottom - 1),
                         min(height, floor(max(ys) / RESOLUTION) - bottom + 2)):
            for column in range(max(0, floor(min(xs) / RESOLUTION) - left - 1),
                                min(width, floor(max(xs) / RESOLUTION) - left + 2)):
                yield (row * width + column, (left + column + 0.5) * RESOLUTION,
                       (bottom + row + 0.5) * RESOLUTION)

    reach = hypot(RESOLUTION, RESOLUTION) / 2
    for obstacle in world.obstacles:
        for place, x, y in middles(_corners(obstacle)):
            if obstacle.gap(x, y) <= reach:
                cells[place] = OCCUPIED
    if world.ground or world.cliffs:
        for place, x, y in middles([(low_x, low_y), (high_x, high_y)]):
            if world.floor(x, y) is None:
                cells[place] = OCCUPIED
    start = floor(world.start.x / RESOLUTION) - left, floor(world.start.y / RESOLUTION) - bottom
    waiting = [start]
    while waiting:  # what can be reached from the start is free
        column, row = waiting.pop()
        if (0 <= column < width and 0 <= row < height
                and cells[row * width + column] == UNKNOWN):
            cells[row * width + column] = FREE
            waiting += [(column - 1, row), (column + 1, row), (column, row - 1), (column, row + 1)]
    rows = [bytes(cells[row * width:(row + 1) * width]) for row in reversed(range(height))]
    return Map(width, height, left * RESOLUTION, bottom * RESOLUTION, b''.join(rows))


def _bounds(world: World) -> tuple[float, float, float, float]:
    """Return the lowest and the highest x and y that the map shows."""
    points = [point for each in world.borders for point in each.points]
    for obstacle in world.obstacles:
        points += _corners(obstacle)
    if not points:
        start = world.start
        points = [(start.x - EMPTY, start.y - EMPTY), (start.x + EMPTY, start.y + EMPTY)]
    points.append((world.start.x, world.start.y))
    xs, ys = zip(*points)
    return min(xs) - MARGIN, min(ys) - MARGIN, max(xs) + MARGIN, max(ys) + MARGIN


def _corners(obstacle: Obstacle) -> list[Point]:
    if isinstance(obstacle, LineSegment):
        return list(obstacle.ends)
    return [(obstacle.x - obstacle.radius, obstacle.y - obstacle.radius),
            (obstacle.x + obstacle.radius, obstacle.y + obstacle.radius)]


Numbers = list[float]


def outlines(world: World) -> dict[str, list[Numbers]]:
    """
    Return the parts of a room, in metres and radians.

    Walls are x, y of both ends; posts x, y and radius; cliffs and grounds x, y of their corners;
    Home Bases x, y and heading; virtual walls the same and their reach.
    """
    walls = [each for each in world.obstacles if isinstance(each, LineSegment)]
    posts = [each for each in world.obstacles if isinstance(each, Disc)]
    return {
        'walls': [_rounded(*(value for end in wall.ends for value in end)) for wall in walls],
        'posts': [_rounded(post.x, post.y, post.radius) for post in posts],
        'cliffs': list(map(_polygon, world.cliffs)),
        'grounds': list(map(_polygon, world.ground)),
        'home_bases': [_rounded(*base.pose) for base in world.home_bases],
        'virtual_walls': [[*_rounded(*each.pose), each.reach] for each in world.virtual_walls],
    }


def _rounded(*values: float) -> Numbers:
    return [round(value, 4) for value in values]


def _polygon(polygon: Polygon) -> Numbers:
    return _rounded(*(value for edge in polygon.edges for value in edge.ends[0]))
