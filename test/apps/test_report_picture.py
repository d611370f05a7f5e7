# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a report can be read: nothing lies over something else, colours differ."""

from itertools import combinations
from math import cos, hypot, pi, sin

import numpy
import pytest

pytest.importorskip('matplotlib')

from matplotlib.colors import to_rgb
from matplotlib.quiver import Quiver
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox

from create_oi_ros.apps.report import colors
from create_oi_ros.apps.report.create_report import WIDE
from create_oi_ros.apps.report.drawing import draw
from create_oi_ros.apps.report.recording import Curve, Recording, Span, Spans

DICHROMATS = {
    'protan': [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    'deutan': [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]}
"""Linear RGB as people without red or green cones see it (Machado and others, 2009)."""
SEEN_APART = 0.15
"""Distance of two colours in RGB, each 0 to 1."""


def recorded(length: float, events: int, turn: float = 0.0) -> Recording:
    """Return a recording of a drive of one minute, with bumps and songs evenly along it."""
    made = Recording(
        'walk', 'MCAP', 0.0, 60.0, 1, odom=Curve('x', 'y', 'yaw', 'speed', 'turn'),
        commands=Curve('speed', 'turn'), battery=Curve('volts', 'amperes', 'charge'),
        link=Curve('frames', 'damaged', 'garbage'))
    x = y = 0.0
    for tick in range(600):
        yaw = turn * tick / 600
        x, y = x + length / 600 * cos(yaw), y + length / 600 * sin(yaw)
        made.odom.add(tick / 10, x, y, yaw, length / 60, 0.0)
        made.commands.add(tick / 10, length / 60, 0.0)
        made.battery.add(tick / 10, 15.0, -1.0 - tick / 600, 90.0)
        made.link.add(tick / 10, 66.0, 3.0, 10.0)
    for number in range(events):
        kind = ('bumper', 'song')[number % 2]
        at = 60.0 * (number + 0.5) / events
        made.spans[kind].all.append(Span(at, 'left', at + 0.1))
    return made


def numbers(label: str) -> list[int]:
    """Return the numbers of a label such as `1-3, 7`."""
    found = []
    for part in label.split(', '):
        first, _, last = part.partition('-')
        found += range(int(first), int(last or first) + 1)
    return found


@pytest.mark.parametrize(('length', 'turn'), [
    (0.0, 0.0), (0.05, 0.0), (0.5, 0.0), (3.0, 0.0), (4.0, 2 * pi), (6.0, 12 * pi)])
def test_numbers_of_events_never_touch(length, turn):
    figure = draw(recorded(length, 24, turn), WIDE)
    figure.draw_without_rendering()
    texts = [each for each in figure.axes[0].texts if isinstance(each, Annotation)]
    boxes = [each.get_window_extent() for each in texts]
    assert sorted(sum((numbers(each.get_text()) for each in texts), [])) == list(range(1, 25))
    assert not [one for one, other in combinations(boxes, 2) if one.overlaps(other)]


def test_numbers_stay_at_their_places_in_the_saved_picture():
    figure = draw(recorded(3.0, 5), WIDE)
    texts = [each for each in figure.axes[0].texts if isinstance(each, Annotation)]
    figure.draw_without_rendering()
    for each, number in zip(texts, range(5), strict=True):
        where = figure.axes[0].transData.transform((3.0 * (number + 0.5) / 5, 0.0))
        assert each.xy == pytest.approx(tuple(where), abs=1.5)


@pytest.mark.parametrize('length', [0.05, 0.3, 1.0, 30.0])
def test_arrows_leave_most_of_the_track_free(length):
    figure = draw(recorded(length, 0), WIDE)
    figure.draw_without_rendering()
    axes = figure.axes[0]
    arrows, = (each for each in axes.collections if isinstance(each, Quiver))
    start, end = axes.transData.transform([(0.0, 0.0), (length, 0.0)])
    wide = axes.get_window_extent().width / arrows.scale
    assert wide * (arrows.N - 1) < 0.5 * hypot(*(end - start))


def test_no_legend_lies_over_a_curve():
    made = recorded(2.0, 8)
    made.spans['charging'] = Spans()
    figure = draw(made, WIDE)
    figure.draw_without_rendering()
    legends = [axes for axes in figure.axes if axes.get_legend()]
    assert len(legends) == 4
    for axes in legends:
        box, inside = axes.get_legend().get_window_extent(), axes.get_window_extent()
        assert box.y0 >= inside.y1 - 1 or box.y1 <= inside.y0, axes.get_ylabel()


def test_every_curve_of_the_battery_has_axes_of_its_own():
    axes = {each.get_ylabel(): each for each in draw(recorded(1.0, 0), WIDE).axes}
    for name in ('battery, V', 'current, A', 'charge, %'):
        assert len(axes[name].lines) == 1
        beside = [each for each in axes.values()
                  if each.get_position().bounds == axes[name].get_position().bounds]
        assert beside == [axes[name]]


def drawn_texts(figure) -> list[Text]:
    """Return the texts of a picture, without labels of ticks outside of their axes."""
    unseen = set()
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        for tick in axis.get_major_ticks():
            if not low <= tick.get_loc() <= high:
                unseen |= {tick.label1, tick.label2}
    return [each for each in figure.findobj(Text)
            if each.get_text() and each.get_visible() and each not in unseen]


@pytest.mark.parametrize('width', [360, 640, WIDE, 2400])
def test_no_text_lies_over_the_edge_of_the_picture(width):
    made = recorded(2.0, 60)
    made.name = made.robot = 'a_long_name_of_a_walk_through_all_rooms_with_a_$ymbol' * 3
    made.damage = 'the_file_ends_within_a_message' * 4 + ' and more words' * 10
    made.spans['mode'].all.append(Span(0.0, 'Safe', 60.0, 'a reason ' * 20))
    made.spans['charging'].all.append(Span(59.0, 'trickle charging', 60.0))
    figure = draw(made, width)
    figure.draw_without_rendering()
    page = figure.bbox
    outside = []
    for text in drawn_texts(figure):
        box = text.get_window_extent()
        if text.get_clip_on() and text.axes is not None:
            box = Bbox.intersection(box, text.axes.get_window_extent()) or page
        if box.x0 < 0 or box.x1 > page.width or box.y0 < 0 or box.y1 > page.height:
            outside.append((text.get_text(), box))
    assert not outside


@pytest.mark.parametrize(('width', 'columns'), [(360, 1), (WIDE, 2)])
def test_a_small_page_has_one_column(width, columns):
    figure = draw(recorded(2.0, 30), width)
    grid = figure.axes[0].get_subplotspec().get_gridspec()
    assert grid.ncols == columns
    words = sorted((text.get_window_extent() for text in figure.texts), key=lambda box: box.y0)
    charts = figure.axes[2].get_window_extent()
    assert words[0].y0 > charts.y1, 'nothing is written over the charts'


def seen(color: str, matrix: list[list[float]]) -> numpy.ndarray:
    """Return a colour as a dichromat sees it."""
    linear = numpy.array(to_rgb(color)) ** 2.2
    return numpy.clip(numpy.array(matrix) @ linear, 0, 1) ** (1 / 2.2)


@pytest.mark.parametrize('kind', DICHROMATS)
@pytest.mark.parametrize('chart', [
    (colors.MEASURED, colors.COMMANDED), (colors.MEASURED, colors.FAULTS, 'black'),
    tuple(colors.MODES.values())], ids=['speeds', 'link', 'modes'])
def test_colours_of_a_chart_differ_for_the_colour_blind(chart, kind):
    for one, other in combinations(chart, 2):
        apart = seen(one, DICHROMATS[kind]) - seen(other, DICHROMATS[kind])
        assert hypot(*apart) > SEEN_APART, (one, other)


def test_marks_differ_in_form():
    assert len(set(colors.MARKS.values())) == len(colors.MARKS)
