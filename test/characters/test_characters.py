# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of characters: lines that join, dots, and colours that never stand alone."""

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.characters.box_lines import BoxLines, cells_between
from create_oi_ros.characters.canvas import Canvas
from create_oi_ros.characters.dots import Dots
from create_oi_ros.characters.ink import encoded, Ink, InkedText
from create_oi_ros.characters.robot_sign import arrow, hull

CELLS = st.tuples(st.integers(-20, 20), st.integers(-20, 20))


def drawn(lines, rows: int, columns: int, *, plain: bool = False) -> list[str]:
    """Return lines between cells as they are drawn."""
    made, canvas = BoxLines(), Canvas(columns, rows, plain=plain)
    for start, end in lines:
        made.add(start, end)
    for (row, column), character in made.characters(plain=plain):
        canvas.put(row, column, character)
    return canvas.lines()


def test_lines_that_meet_are_joined():
    room = [((0, 0), (0, 4)), ((0, 4), (2, 4)), ((2, 4), (2, 0)), ((2, 0), (0, 0)),
            ((0, 2), (2, 2))]
    assert drawn(room, 3, 5) == ['┌─┬─┐', '│ │ │', '└─┴─┘']
    assert drawn(room, 3, 5, plain=True) == ['+-+-+', '| | |', '+-+-+']


def test_lines_that_cross_end_and_stand_alone():
    assert drawn([((1, 0), (1, 2)), ((0, 1), (2, 1)), ((0, 4), (0, 4))], 3, 5) == [
        ' ╷  ·', '╶┼╴  ', ' ╵   ']


def test_a_slanted_line_is_a_staircase_without_a_gap():
    assert drawn([((0, 0), (2, 4))], 3, 5) == ['╶┐   ', ' └─┐ ', '   └╴']


@given(CELLS, CELLS)
def test_cells_of_a_line_are_neighbours_and_no_more_than_needed(start, end):
    cells = list(cells_between(start, end))
    assert (cells[0], cells[-1]) == (start, end)
    assert len(cells) == abs(end[0] - start[0]) + abs(end[1] - start[1]) + 1
    for (row, column), (next_row, next_column) in zip(cells, cells[1:], strict=False):
        assert abs(next_row - row) + abs(next_column - column) == 1


def test_dots_of_a_cell_make_one_character():
    dots = Dots()
    dots.add(0.0, 0.0)
    dots.add(0.9, 0.9)
    assert dict(dots.characters()) == {(0, 0): '⢁'}
    assert dict(dots.characters(plain=True)) == {(0, 0): '.'}


def test_a_ring_has_its_radii():
    dots = Dots()
    dots.ring(10.0, 10.0, 3.0, 6.0)
    cells = [cell for cell, _ in dots.characters()]
    assert {min(row for row, _ in cells), max(row for row, _ in cells)} <= {6, 7, 12, 13}
    assert min(column for _, column in cells) in (3, 4)
    assert (10, 10) not in cells


@pytest.mark.parametrize(('row', 'colors', 'written'), [
    ([InkedText('a')], True, 'a'),
    ([InkedText('a', highlighted=True)], False, '\x1b[7ma\x1b[0m'),
    ([InkedText('a', ink=Ink.BAD)], True, '\x1b[31ma\x1b[0m'),
    ([InkedText('a', ink=Ink.BAD)], False, 'a'),
    ([InkedText('a', True, Ink.BAD)], True, '\x1b[7;31ma\x1b[0m'),
    ([InkedText('a'), InkedText('⠁⠁', ink=Ink.TRACK), InkedText('b')], True,
     'a\x1b[36m⠁⠁\x1b[0m\x1b[4Gb'),
])
def test_a_row_is_written(row, colors, written):
    assert encoded(row, colors=colors) == written


def test_a_robot_points_where_it_looks():
    assert [arrow(yaw, plain=True) for yaw in (0.0, 0.8, 1.6, -3.1)] == ['>', '/', '^', '<']
    assert [arrow(yaw, plain=False) for yaw in (0.3, -0.8)] == ['→', '↘']


def test_a_hull_is_drawn_where_it_is_larger_than_an_arrow():
    assert list(hull(5.0, 5.0, 1.0, plain=False).characters())
    assert not list(hull(5.0, 5.0, 0.7, plain=False).characters())
    assert not list(hull(5.0, 5.0, 1.0, plain=True).characters())
