# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The map: the robot and its trail, scaled to fit a box of the canvas."""

from __future__ import annotations

from math import ceil, floor, log10
from typing import NamedTuple

from ...characters.canvas import Canvas
from ...characters.dots import Dots
from ...characters.ink import Ink
from ...characters.robot_sign import arrow, CELL_SHAPE, hull
from ...robot import BODY_RADIUS
from .robot_state import OdomPose, Trail

LEAST_WIDTH = 3.0
"""Metres across the map at least."""
MARGIN = 2
"""Cells left free around the trail."""
SIGN_INKS = {'x': Ink.BAD, '!': Ink.WARN}
STEPS = (1.0, 2.0, 5.0, 10.0)
"""Scales and the scale bar are one of these times a power of ten."""


class Box(NamedTuple):
    """A rectangle of the canvas, in cells."""

    row: int
    column: int
    rows: int
    columns: int


def round_up(value: float) -> float:
    """Return the smallest round number that is not below a value."""
    power: float = 10.0 ** floor(log10(value))
    return next(step * power for step in STEPS if step * power >= value * (1 - 1e-9))


class Chart:
    """Maps points of the floor to cells of a box."""

    def __init__(self, box: Box, points: list[tuple[float, float]]) -> None:
        xs, ys = [x for x, _ in points], [y for _, y in points]
        self._box = box
        inner = box.columns - 2 * MARGIN, box.rows - 2 * MARGIN
        self.cell = round_up(max(
            (max(xs) - min(xs)) / inner[0], (max(ys) - min(ys)) / inner[1] / CELL_SHAPE,
            LEAST_WIDTH / inner[0]))
        """Width of a cell, metres; a round number, so that the scale seldom changes."""
        high = self.cell * CELL_SHAPE
        # The centre is a whole number of cells, or the dots would jitter while the trail grows.
        middle_x = round((max(xs) + min(xs)) / 2 / self.cell)
        middle_y = round((max(ys) + min(ys)) / 2 / high)
        self._left = (middle_x - box.columns // 2) * self.cell
        self._top = (middle_y + box.rows // 2) * high

    def place_of(self, x: float, y: float) -> tuple[float, float]:
        """Return row and column with their fractions."""
        return (self._top - y) / (self.cell * CELL_SHAPE), (x - self._left) / self.cell

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Return row and column."""
        row, column = self.place_of(x, y)
        return floor(row), floor(column)

    def inside(self, row: int, column: int) -> bool:
        """Return whether a cell lies in the box."""
        return 0 <= row < self._box.rows and 0 <= column < self._box.columns


def _draw_dots(canvas: Canvas, box: Box, chart: Chart, dots: Dots, ink: Ink) -> None:
    for (row, column), character in dots.characters(plain=canvas.plain):
        if chart.inside(row, column):
            canvas.put(box.row + row, box.column + column, character, ink=ink)


def _trail(canvas: Canvas, box: Box, chart: Chart, trail: Trail) -> None:
    dots = Dots()
    for x, y in trail.points:
        dots.add(*chart.place_of(x, y))
    _draw_dots(canvas, box, chart, dots, Ink.TRACK)


def _bar(canvas: Canvas, box: Box, chart: Chart) -> None:
    """Draw the scale bar."""
    length = round_up(6 * chart.cell)
    text = f'|{"-" * (ceil(length / chart.cell - 0.5) - 1)}| {length:g} m'
    canvas.put(box.row + box.rows - 1, box.column + 1, text, width=box.columns - 1)


def draw(canvas: Canvas, box: Box, trail: Trail, pose: OdomPose | None) -> None:
    """Draw the scale bar, the trail, the origin, the marks, and the robot as an arrow."""
    here = pose if pose is not None and pose.drawable else None
    points = [*trail.points, *((mark.x, mark.y) for mark in trail.marks)]
    points += [(here.x, here.y)] if here else []
    chart = Chart(box, points or [(0.0, 0.0)])

    def put(x: float, y: float, sign: str, ink: Ink = Ink.PLAIN, *,
            highlighted: bool = False) -> None:
        row, column = chart.cell_of(x, y)
        if chart.inside(row, column):
            canvas.put(box.row + row, box.column + column, sign, highlighted=highlighted, ink=ink)
    _bar(canvas, box, chart)
    _trail(canvas, box, chart, trail)
    if here is not None:
        dots = hull(*chart.place_of(here.x, here.y), BODY_RADIUS / chart.cell, plain=canvas.plain)
        _draw_dots(canvas, box, chart, dots, Ink.ROBOT)
    put(0.0, 0.0, '+')
    for mark in trail.marks:
        put(mark.x, mark.y, mark.sign, SIGN_INKS[mark.sign])
    if here is not None:
        put(here.x, here.y, arrow(here.yaw, plain=canvas.plain), highlighted=True)
    elif pose is not None:
        canvas.put(box.row, box.column + 1, 'the pose is no place on a map', width=box.columns - 1)
