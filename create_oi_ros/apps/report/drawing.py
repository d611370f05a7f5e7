# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Draws a recording: the track on top, everything over time below."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite, nan
from typing import Any, TYPE_CHECKING

from .colors import COLORS, COMMANDED, FAULTS, GAP, MEASURED, MODES
from .recording import Curve, Recording, Span, SPANS
from .summary import clock, events
from .text_drawing import cut, draw_words, LINE, MARGIN, measure, plain, rows_needed
from .track_drawing import draw_track, LISTED, number_events

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DOTS = 100
"""Pixels an inch."""
ONE_COLUMN = 800
"""Pixels of width below which the words stand under the track."""
TRACK, CHARTS = 480, (120, 120, 90, 90, 60, 220, 110)
"""Pixels of height: the track, and the rows from the speed to the serial link."""
SPARE, NARROW_SPARE = 330, 420
"""Pixels between and around all these: titles, axes, legends."""
LETTER, HANDLE = 7.0, 48.0
"""Pixels of a letter and of a sign in a legend, at most on average."""
TITLE_SIZE = 16
AVERAGED = 0.5
"""Seconds over which speeds are averaged: one frame resolves only steps of 67 mm/s."""


def draw(recording: Recording, width: int) -> Figure:
    """Return the picture, so many pixels wide."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(width / DOTS, 1), dpi=DOTS, layout='constrained')
    shown = events(recording)
    track, words, rows = _axes(figure, recording, len(shown), width)
    draw_track(track, recording, shown[:LISTED])
    words.axis('off')
    _charts(rows, recording, width)
    figure.align_ylabels(rows)
    name = f'{recording.name}, robot {recording.robot}' if recording.robot else recording.name
    title = cut(f'What the robot did: {name}', width - MARGIN,
                measure(figure, TITLE_SIZE, 'bold'))
    figure.suptitle(plain(title), fontsize=TITLE_SIZE, fontweight='bold')
    figure.draw_without_rendering()  # labels avoid each other, so all else has its place first
    figure.set_layout_engine('none')
    number_events(track, recording, shown[:LISTED])
    draw_words(figure, words, recording, shown, words_width(width))
    return figure


def words_width(width: int) -> float:
    """Return the pixels that words have in a picture so many pixels wide."""
    return width - 2 * MARGIN if width < ONE_COLUMN else width / 2 - 3 * MARGIN


def _axes(figure: Figure, recording: Recording, shown: int,
          width: int) -> tuple[Axes, Axes, list[Axes]]:
    """Return the axes of the track, of the words, and of the charts."""
    one = width < ONE_COLUMN
    words = LINE * (1 + rows_needed(figure, recording, shown, words_width(width)))
    heights = [min(TRACK, width), words, *CHARTS] if one else [max(TRACK, words), *CHARTS]
    spare = NARROW_SPARE if one else SPARE
    figure.set_size_inches(width / DOTS, (sum(heights) + spare) / DOTS)
    grid = figure.add_gridspec(len(heights), 1 if one else 2, height_ratios=heights)
    track = figure.add_subplot(grid[0, 0])
    beside = figure.add_subplot(grid[1, 0] if one else grid[0, 1])
    first = len(heights) - len(CHARTS)
    speed = figure.add_subplot(grid[first, :])
    return track, beside, [speed, *(figure.add_subplot(grid[row, :], sharex=speed)
                                    for row in range(first + 1, len(heights)))]


def _charts(rows: Sequence[Axes], recording: Recording, width: int) -> None:
    _speeds(rows[0], recording, 'speed', 'forward, m/s')
    _speeds(rows[1], recording, 'turn', 'turning, rad/s')
    _battery(rows[2], recording, 'volts', 'battery, V')
    _battery(rows[3], recording, 'amperes', 'current, A')
    _battery(rows[4], recording, 'charge', 'charge, %')
    rows[4].set(ylim=(0, 105), yticks=(0, 50, 100))
    _charging(rows[2], recording)
    _timeline(rows[5], recording, width)
    _link(rows[6], recording)
    for axes in rows:
        _time_axis(axes, recording, width, labelled=axes is rows[-1])


def _speeds(axes: Axes, recording: Recording, name: str, label: str) -> None:
    odom, commands = recording.odom, recording.commands
    times, values = odom.broken(name, recording.gaps)
    axes.plot(times, values, color=MEASURED, linewidth=0.5, alpha=0.25,
              label='measured, each frame')
    axes.plot(times, smooth(times, values), color=MEASURED, linewidth=1.5,
              label=f'measured, mean of {AVERAGED} s')
    # A command ends unless it is repeated, and so does its line.
    axes.plot(*commands.broken(name, pauses(commands)), color=COMMANDED, linewidth=1.2,
              linestyle='--', drawstyle='steps-post', label='commanded (cmd_vel)')
    axes.set_ylabel(label, fontsize=8)
    _widen(axes, 0.1)
    _legend_above(axes)


def _widen(axes: Axes, least: float) -> None:
    """Widen the axis to a least span of values, so that noise does not fill it."""
    low, high = axes.get_ylim()
    more = max(0.0, least - (high - low)) / 2
    axes.set_ylim(low - more, high + more)


def _legend_above(axes: Axes, more: Sequence[Any] = ()) -> None:
    """Explain the lines above the axes, where no curve is."""
    handles = [*axes.lines, *more]
    columns = legend_columns(axes, [str(each.get_label()) for each in handles])
    axes.legend(handles=handles, loc='lower right', bbox_to_anchor=(1, 1), fontsize=8,
                ncols=columns, frameon=False, borderpad=0, borderaxespad=0.2, columnspacing=1)


def _battery(axes: Axes, recording: Recording, name: str, label: str) -> None:
    battery = recording.battery
    axes.plot(battery.times, battery[name], color=MEASURED)
    axes.set_ylabel(label, fontsize=8)
    _widen(axes, 0.5)


def _charging(axes: Axes, recording: Recording) -> None:
    for span in recording.spans['charging'].all:
        axes.axvspan(span.start, span.end, color=COLORS['charging'], alpha=0.15)
        axes.text(span.start, 0.04, f' {plain(span.text)}', fontsize=8, clip_on=True,
                  transform=axes.get_xaxis_transform())


def _timeline(axes: Axes, recording: Recording, width: int) -> None:
    rows = [*SPANS, 'gap']
    for row, kind in enumerate(rows):
        spans = recording.gaps if kind == 'gap' else recording.spans[kind].all
        for span in spans:
            _bar(axes, row, kind, span, recording.seconds, width)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.set_ylim(len(rows) - 0.4, -0.6)


def _bar(axes: Axes, row: int, kind: str, span: Span, seconds: float, pixels: int) -> None:
    # Even the shortest bar is visible.
    width = max(span.end - span.start, seconds / 400)
    color = MODES.get(span.text, '#888888') if kind == 'mode' else COLORS[kind]
    axes.barh(row, width, left=span.start, height=0.75, color=color)
    if width > seconds * 13 / pixels * len(span.text):
        axes.text(span.start + width / 2, row, plain(span.text), clip_on=True,
                  ha='center', va='center', fontsize=7,
                  bbox={'boxstyle': 'round,pad=0.1', 'fc': 'white', 'ec': 'none', 'alpha': 0.6})


def _link(axes: Axes, recording: Recording) -> None:
    link = recording.link
    axes.plot(link.times, link['frames'], color=MEASURED, label='frames/s')
    axes.set_ylabel('frames/s', color=MEASURED, fontsize=8)
    axes.set_ylim(0, 100)
    faults = axes.twinx()
    faults.bar(link.times, link['damaged'], width=1.0, color=FAULTS, label='damaged frames/s')
    faults.step(link.times, link['garbage'], color='black', linewidth=1, linestyle=':',
                where='mid', label='garbage bytes/s')
    faults.set_ylim(0, max([5.0, *finite(link['damaged']), *finite(link['garbage'])]) * 1.1)
    faults.set_ylabel('faults/s', color=FAULTS, fontsize=8)
    _legend_above(axes, [*faults.containers, *faults.lines])


def _time_axis(axes: Axes, recording: Recording, width: int, *, labelled: bool) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator
    axes.set_xlim(0, recording.seconds or 1.0)
    axes.grid(axis='x', alpha=0.3)
    axes.xaxis.set_major_locator(MaxNLocator(min(12, width // 90), steps=[1, 2, 3, 5, 6, 10]))
    axes.xaxis.set_major_formatter(FuncFormatter(
        lambda seconds, _: clock(seconds).removesuffix('.0')))
    axes.tick_params(labelbottom=labelled, labelsize=8)
    for gap in recording.gaps:
        axes.axvspan(gap.start, gap.end, color=GAP, alpha=0.35, linewidth=0)
    if labelled:
        axes.set_xlabel('minutes and seconds; grey: gaps', fontsize=8)


def legend_columns(axes: Axes, labels: Sequence[str]) -> int:
    """Return how many columns of a legend stay in the picture."""
    longest = max(map(len, labels), default=0) * LETTER + HANDLE
    return max(1, min(len(labels), int(axes.figure.bbox.width * 0.85 // longest)))


def smooth(times: list[float], values: list[float]) -> list[float]:
    """Return the mean of the values around each time; nan stays nan."""
    made, first, last, total = [], 0, 0, 0.0
    for time, value in zip(times, values):
        if not isfinite(value):
            made.append(nan)
            first, last, total = len(made), len(made), 0.0
            continue
        while last < len(times) and times[last] <= time + AVERAGED / 2 and isfinite(values[last]):
            total += values[last]
            last += 1
        while times[first] < time - AVERAGED / 2:
            total -= values[first]
            first += 1
        made.append(total / (last - first))
    return made


def finite(values: Iterable[float]) -> list[float]:
    """Return the finite values."""
    return [each for each in values if isfinite(each)]


def pauses(curve: Curve, longest: float = 0.6) -> list[Span]:
    """Return the periods in which a curve has no points."""
    return [Span(a, '', b) for a, b in zip(curve.times, curve.times[1:]) if b - a > longest]


def save(figure: Figure, target: Any) -> None:
    """Write the picture as PNG to a file or a stream."""
    figure.savefig(target, format='png', dpi=DOTS)
