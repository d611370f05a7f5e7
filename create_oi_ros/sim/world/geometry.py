# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Plane geometry for rooms: line segments, discs, polygons; metres in the world frame."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
import math

Point = tuple[float, float]


class LineSegment:
    """A straight line between two points: a wall without thickness, or a border."""

    def __init__(self, a: Point, b: Point) -> None:
        self.ax, self.ay = a
        self.length = math.dist(a, b)
        if self.length == 0:
            raise ValueError(f'a line from {a} to the same point has no length')
        self.ux, self.uy = (b[0] - a[0]) / self.length, (b[1] - a[1]) / self.length

    @property
    def ends(self) -> tuple[Point, Point]:
        """Both ends, for drawing."""
        return ((self.ax, self.ay),
                (self.ax + self.ux * self.length, self.ay + self.uy * self.length))

    def away(self, x: float, y: float) -> tuple[float, float]:
        """Return the vector from the nearest point of the line to (x, y)."""
        x -= self.ax
        y -= self.ay
        ux, uy = self.ux, self.uy
        along = x * ux + y * uy
        along = 0.0 if along < 0 else self.length if along > self.length else along
        return x - along * ux, y - along * uy

    def gap(self, x: float, y: float) -> float:
        """Return the distance from (x, y), metres."""
        return math.hypot(*self.away(x, y))

    def hit(self, x: float, y: float, dx: float, dy: float) -> float:
        """Return how far a ray from (x, y) along (dx, dy), a unit vector, runs; inf: no hit."""
        cross = dx * self.uy - dy * self.ux
        if abs(cross) < 1e-12:
            return math.inf
        x, y = self.ax - x, self.ay - y
        ray = (x * self.uy - y * self.ux) / cross
        along = (x * dy - y * dx) / cross
        return ray if ray >= 0 and 0 <= along <= self.length else math.inf


class Disc:
    """A round obstacle."""

    def __init__(self, x: float, y: float, radius: float) -> None:
        if not radius > 0:
            raise ValueError(f'radius {radius}; allowed: above 0')
        self.x, self.y, self.radius = x, y, radius

    def away(self, x: float, y: float) -> tuple[float, float]:
        """Return the vector from the nearest point of the disc to (x, y)."""
        dx, dy = x - self.x, y - self.y
        far = math.hypot(dx, dy) or 1e-9
        part = 1 - self.radius / far
        return dx * part, dy * part

    def gap(self, x: float, y: float) -> float:
        """Return the distance from (x, y), metres; negative inside."""
        return math.hypot(x - self.x, y - self.y) - self.radius

    def hit(self, x: float, y: float, dx: float, dy: float) -> float:
        """Return how far a ray from (x, y) along (dx, dy), a unit vector, runs; inf: no hit."""
        x, y = self.x - x, self.y - y
        along = x * dx + y * dy
        inside = self.radius ** 2 - (x * x + y * y - along * along)
        if inside < 0:
            return math.inf
        ray = along - math.sqrt(inside)
        return ray if ray >= 0 else math.inf


Obstacle = LineSegment | Disc


class Polygon:
    """A closed region of floor."""

    def __init__(self, points: Sequence[Point]) -> None:
        self.points = tuple(points)
        self.edges = chain([*points, points[0]])

    def __contains__(self, point: Point) -> bool:
        x, y = point
        inside = False
        ax, ay = self.points[-1]
        for bx, by in self.points:
            if (ay > y) != (by > y) and x < (bx - ax) * (y - ay) / (by - ay) + ax:
                inside = not inside
            ax, ay = bx, by
        return inside

    def edge_gap(self, x: float, y: float) -> float:
        """Return the distance of (x, y) from the border, inside or outside."""
        return min(edge.gap(x, y) for edge in self.edges)


def chain(points: Sequence[Point]) -> tuple[LineSegment, ...]:
    """Return the line segments that join the points in their order."""
    return tuple(LineSegment(a, b) for a, b in pairwise(points))


def reach(obstacles: Iterable[Obstacle], x: float, y: float, dx: float, dy: float) -> float:
    """Return how far a ray runs to the first obstacle; inf: it meets none."""
    return min((each.hit(x, y, dx, dy) for each in obstacles), default=math.inf)


def sees(obstacles: Iterable[Obstacle], a: Point, b: Point) -> bool:
    """Return whether no obstacle stands between a and b."""
    far = math.dist(a, b)
    if far == 0:
        return True
    return reach(obstacles, *a, (b[0] - a[0]) / far, (b[1] - a[1]) / far) >= far - 1e-9
