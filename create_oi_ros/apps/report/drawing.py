"""Draws a recording: the track on top, everything over time below."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite, nan
from textwrap import shorten, wrap
from typing import Any, TYPE_CHECKING

from .colors import COLORS, COMMANDED, FAULTS, GAP, MEASURED, MODES
from .recording import Curve, Recording, Span, SPANS
from .summary import clock, events, summary, TimelineEvent
from .track_drawing import draw_track, LISTED, number_events

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INCHES = (12.0, 16.0)
DOTS = 100
"""Pixels an inch."""
HEIGHTS = (4.8, 1.2, 1.2, 0.9, 0.9, 0.6, 2.2, 1.1)
"""Relative heights of the rows, from the track to the serial link."""
AVERAGED = 0.5
"""Seconds over which speeds are averaged: one frame resolves only steps of 67 mm/s."""


def draw(recording: Recording) -> Figure:
    """Return the picture."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=INCHES, dpi=DOTS, layout='constrained')
    grid = figure.add_gridspec(len(HEIGHTS), 2, height_ratios=HEIGHTS)
    shown = events(recording)
    track = figure.add_subplot(grid[0, 0])
    draw_track(track, recording, shown[:LISTED])
    _words(figure.add_subplot(grid[0, 1]), recording, shown)
    first = figure.add_subplot(grid[1, :])
    rows = [first, *(figure.add_subplot(grid[row, :], sharex=first)
                     for row in range(2, len(HEIGHTS)))]
    _speeds(rows[0], recording, 'speed', 'forward, m/s')
    _speeds(rows[1], recording, 'turn', 'turning, rad/s')
    _battery(rows[2], recording, 'volts', 'battery, V')
    _battery(rows[3], recording, 'amperes', 'current, A')
    _battery(rows[4], recording, 'charge', 'charge, %')
    rows[4].set(ylim=(0, 105), yticks=(0, 50, 100))
    _charging(rows[2], recording)
    _timeline(rows[5], recording)
    _link(rows[6], recording)
    for axes in rows:
        _time_axis(axes, recording, labelled=axes is rows[-1])
    figure.align_ylabels(rows)
    name = f'{recording.name}, robot {recording.robot}' if recording.robot else recording.name
    figure.suptitle(f'What the robot did: {name}', fontsize=16, fontweight='bold')
    figure.draw_without_rendering()  # labels avoid each other, so all else has its place first
    figure.set_layout_engine('none')
    number_events(track, recording, shown[:LISTED])
    return figure


def _words(axes: Axes, recording: Recording, shown: list[TimelineEvent]) -> None:
    axes.axis('off')
    lines = [line for each in summary(recording) for line in wrap(each, 78)]
    rows = LISTED + 14
    for row, line in enumerate(lines[:11]):
        axes.text(0.0, 1 - row / rows, line, fontsize=9, transform=axes.transAxes)
    first = min(len(lines), 11) + 1
    axes.text(0.0, 1 - first / rows, 'What happened when (minutes:seconds)', fontsize=10,
              fontweight='bold', transform=axes.transAxes)
    for number, each in enumerate(shown[:LISTED], 1):
        height = 1 - (first + number) / rows
        axes.text(0.04, height, f'{number}', ha='right', fontsize=9, fontweight='bold',
                  color=COLORS[each.kind], transform=axes.transAxes)
        axes.text(0.13, height, clock(each.time), ha='right', fontsize=9,
                  transform=axes.transAxes)
        axes.text(0.15, height, shorten(each.text, 66, placeholder=' ...'), fontsize=9,
                  transform=axes.transAxes)
    if len(shown) > LISTED:
        axes.text(0.15, 0, f'and {len(shown) - LISTED} more: see the HTML page', fontsize=9,
                  style='italic', transform=axes.transAxes)


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
    axes.legend(handles=[*axes.lines, *more], loc='lower right', bbox_to_anchor=(1, 1), fontsize=8,
                ncols=3, frameon=False, borderpad=0, borderaxespad=0.2)


def _battery(axes: Axes, recording: Recording, name: str, label: str) -> None:
    battery = recording.battery
    axes.plot(battery.times, battery[name], color=MEASURED)
    axes.set_ylabel(label, fontsize=8)
    _widen(axes, 0.5)


def _charging(axes: Axes, recording: Recording) -> None:
    for span in recording.spans['charging'].all:
        axes.axvspan(span.start, span.end, color=COLORS['charging'], alpha=0.15)
        axes.text(span.start, 0.04, f' {span.text}', fontsize=8,
                  transform=axes.get_xaxis_transform())


def _timeline(axes: Axes, recording: Recording) -> None:
    rows = [*SPANS, 'gap']
    for row, kind in enumerate(rows):
        spans = recording.gaps if kind == 'gap' else recording.spans[kind].all
        for span in spans:
            _bar(axes, row, kind, span, recording.seconds)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.set_ylim(len(rows) - 0.4, -0.6)


def _bar(axes: Axes, row: int, kind: str, span: Span, seconds: float) -> None:
    # Even the shortest bar is visible.
    width = max(span.end - span.start, seconds / 400)
    color = MODES.get(span.text, '#888888') if kind == 'mode' else COLORS[kind]
    axes.barh(row, width, left=span.start, height=0.75, color=color)
    if width > seconds * 0.011 * len(span.text):
        axes.text(span.start + width / 2, row, span.text, ha='center', va='center', fontsize=7,
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


def _time_axis(axes: Axes, recording: Recording, *, labelled: bool) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator
    axes.set_xlim(0, recording.seconds or 1.0)
    axes.grid(axis='x', alpha=0.3)
    axes.xaxis.set_major_locator(MaxNLocator(12, steps=[1, 2, 3, 5, 6, 10]))
    axes.xaxis.set_major_formatter(FuncFormatter(
        lambda seconds, _: clock(seconds).removesuffix('.0')))
    axes.tick_params(labelbottom=labelled, labelsize=8)
    for gap in recording.gaps:
        axes.axvspan(gap.start, gap.end, color=GAP, alpha=0.35, linewidth=0)
    if labelled:
        axes.set_xlabel('minutes and seconds since the first message; grey: gaps')


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
