"""Draws a recording: the track on top, everything over time below."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from math import cos, hypot, isfinite, nan, sin
from textwrap import shorten, wrap
from typing import Any, TYPE_CHECKING

from .recording import Curve, Recording, Span, SPANS
from .summary import clock, events, summary, TimelineEvent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INCHES = (12.0, 15.0)
LISTED = 24
"""Events numbered on the track; a page has no room for more."""
HEADINGS = 30
"""Arrows along the track."""
AVERAGED = 0.5
"""Seconds over which speeds are averaged: one frame resolves only steps of 67 mm/s."""
MEASURED, COMMANDED, GAP = '#1f6fb4', '#e08214', '#bbbbbb'
MODES = {'Off': '#555555', 'Passive': '#f4b942', 'Safe': '#5aae61', 'Full': '#9970ab',
         'no robot': '#dddddd'}
COLORS = {'bumper': '#d62728', 'cliff': '#8c3b00', 'wheel drop': '#8c3b00', 'mode': '#7b3294',
          'song': '#17a2a2', 'buttons': '#555555', 'charging': '#2ca02c', 'gap': '#888888',
          'overcurrent': '#d62728'}
MARKS = {'bumper': 'X', 'cliff': 'v', 'wheel drop': 'v', 'mode': 'D', 'song': 'o',
         'buttons': 's', 'charging': 'P', 'gap': 'p', 'overcurrent': '*'}


def draw(recording: Recording) -> Figure:
    """Return the picture."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=INCHES, layout='constrained')
    grid = figure.add_gridspec(6, 2, height_ratios=(4.6, 1.3, 1.3, 1.5, 2.2, 1.1))
    shown = events(recording)
    _track(figure.add_subplot(grid[0, 0]), recording, shown[:LISTED])
    _words(figure.add_subplot(grid[0, 1]), recording, shown)
    first = figure.add_subplot(grid[1, :])
    rows = [first, *(figure.add_subplot(grid[row, :], sharex=first) for row in range(2, 6))]
    _speeds(rows[0], recording, 'speed', 'forward, m/s')
    _speeds(rows[1], recording, 'turn', 'turning, rad/s')
    _battery(rows[2], recording)
    _timeline(rows[3], recording)
    _link(rows[4], recording)
    for axes in rows:
        _time_axis(axes, recording, labelled=axes is rows[-1])
    name = f'{recording.name}, robot {recording.robot}' if recording.robot else recording.name
    figure.suptitle(f'What the robot did: {name}', fontsize=16, fontweight='bold')
    return figure


def _track(axes: Axes, recording: Recording, shown: list[TimelineEvent]) -> None:
    axes.set(xlabel='x, m', ylabel='y, m')
    axes.set_aspect('equal', adjustable='datalim')
    axes.grid(alpha=0.3)
    axes.set_title('Track by odometry, from dark to light; arrows: heading;\n'
                   'numbers: events listed on the right, side by side at one place',
                   fontsize=9)
    odom = recording.odom
    if not odom:
        axes.text(0.5, 0.5, 'no odometry in this bag', ha='center', transform=axes.transAxes)
        return
    xs, ys = broken(odom, 'x', recording.gaps)[1], broken(odom, 'y', recording.gaps)[1]
    axes.plot(xs, ys, color='#dddddd', linewidth=5, solid_capstyle='round', zorder=1)
    axes.scatter(odom['x'], odom['y'], c=odom.times, cmap='viridis', s=3, linewidths=0, zorder=2)
    _headings(axes, odom)
    axes.plot(odom['x'][0], odom['y'][0], 'o', color='#2ca02c', markersize=15, label='start')
    axes.plot(odom['x'][-1], odom['y'][-1], 's', color='black', markersize=9, label='end')
    _marks(axes, recording, shown)
    axes.legend(loc='best', fontsize=8)


def _headings(axes: Axes, odom: Curve) -> None:
    """Draw arrows at equal distances along the track."""
    known = [each for each in zip(odom['x'], odom['y'], odom['yaw'], strict=True)
             if all(map(isfinite, each))]
    if not known:
        return
    xs, ys, _ = zip(*known, strict=True)
    size = max(max(xs) - min(xs), max(ys) - min(ys), 0.5)
    whole = sum(hypot(b - a, d - c) for a, b, c, d in zip(xs, xs[1:], ys, ys[1:]))
    # Invisible points leave room for marks: equal axes have no margins.
    axes.plot([min(xs) - size / 8, max(xs) + size / 8], [min(ys) - size / 8, max(ys) + size / 8],
              alpha=0)
    apart, gone, chosen = max(whole / HEADINGS, size / 40), 0.0, known[:1]
    for before, place in pairwise(known):
        gone += hypot(place[0] - before[0], place[1] - before[1])
        if gone >= apart:
            chosen.append(place)
            gone = 0.0
    axes.quiver([x for x, _, _ in chosen], [y for _, y, _ in chosen],
                [cos(yaw) for _, _, yaw in chosen], [sin(yaw) for _, _, yaw in chosen],
                angles='xy', scale=28, width=0.006, color='#333333', zorder=3)


def _marks(axes: Axes, recording: Recording, shown: list[TimelineEvent]) -> None:
    """Mark each event at its place; numbers at one place stand side by side."""
    from matplotlib.transforms import ScaledTranslation
    inches = axes.figure.dpi_scale_trans
    seen: set[str] = set()
    here: dict[tuple[float, float], list[str]] = {}
    for number, each in enumerate(shown, 1):
        place = recording.place(each.time)
        if place is None:
            continue
        label = each.kind if each.kind not in seen else '_'
        seen.add(each.kind)
        numbers = here.setdefault((round(place[0], 1), round(place[1], 1)), [])
        aside = ScaledTranslation(0.12 * len(numbers), 0, inches)
        axes.plot(*place, MARKS[each.kind], color=COLORS[each.kind], markersize=9, label=label,
                  markeredgecolor='white', linestyle='none', zorder=4,
                  transform=axes.transData + aside)
        numbers.append(str(number))
    for (x, y), numbers in here.items():
        axes.annotate(', '.join(numbers), (x, y), xytext=(7, 7), textcoords='offset points',
                      fontsize=9, fontweight='bold', zorder=5,
                      bbox={'boxstyle': 'round,pad=0.15', 'fc': 'white', 'ec': 'none',
                            'alpha': 0.75})


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
    times, values = broken(odom, name, recording.gaps)
    axes.plot(times, values, color=MEASURED, linewidth=0.5, alpha=0.25,
              label='measured, each frame')
    axes.plot(times, smooth(times, values), color=MEASURED, linewidth=1.5,
              label=f'measured, mean of {AVERAGED} s')
    # A command ends unless it is repeated, and so does its line.
    axes.plot(*broken(commands, name, pauses(commands)), color=COMMANDED, linewidth=1.2,
              linestyle='--', drawstyle='steps-post', label='commanded (cmd_vel)')
    axes.set_ylabel(label)
    _widen(axes, 0.1)
    axes.legend(loc='upper right', fontsize=8, ncols=3)


def _widen(axes: Axes, least: float) -> None:
    """Widen the axis to a least span of values, so that noise does not fill it."""
    low, high = axes.get_ylim()
    more = max(0.0, least - (high - low)) / 2
    axes.set_ylim(low - more, high + more + 0.2 * max(least, high - low))


def _battery(axes: Axes, recording: Recording) -> None:
    battery = recording.battery
    axes.set_ylabel('battery, V', color=MEASURED)
    axes.plot(battery.times, battery['volts'], color=MEASURED, label='voltage, V')
    current = axes.twinx()
    current.plot(battery.times, battery['amperes'], color='#d62728', linewidth=1,
                 label='current, A (negative: discharging)')
    current.set_ylabel('A', color='#d62728', labelpad=0)
    _widen(axes, 0.5)
    _widen(current, 0.5)
    charge = axes.twinx()
    charge.plot(battery.times, battery['charge'], color='#2ca02c', linestyle=':',
                label='charge, %')
    charge.set_ylim(0, 125)
    charge.set_yticks([0, 50, 100])
    charge.spines['right'].set_position(('axes', 1.07))
    charge.set_ylabel('%', color='#2ca02c')
    for span in recording.spans['charging'].all:
        axes.axvspan(span.start, span.end, color='#2ca02c', alpha=0.12)
        axes.text(span.start, 0.04, f' {span.text}', fontsize=8, color='#1a6b1a',
                  transform=axes.get_xaxis_transform())
    lines = [*axes.lines, *current.lines, *charge.lines]
    axes.legend(handles=lines, loc='upper right', fontsize=8, ncols=3)


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
        axes.text(span.start + width / 2, row, span.text, ha='center', va='center', fontsize=7)


def _link(axes: Axes, recording: Recording) -> None:
    link = recording.link
    axes.plot(link.times, link['frames'], color=MEASURED, label='frames/s')
    axes.set_ylabel('frames/s', color=MEASURED)
    axes.set_ylim(0, 100)
    faults = axes.twinx()
    faults.bar(link.times, link['damaged'], width=1.0, color='#d62728', label='damaged frames/s')
    faults.step(link.times, link['garbage'], color='#8c3b00', linewidth=1, where='mid',
                label='garbage bytes/s')
    faults.set_ylim(0, max([5.0, *finite(link['damaged']), *finite(link['garbage'])]) * 1.4)
    faults.set_ylabel('faults/s', color='#d62728')
    axes.legend(handles=[*axes.lines, *faults.containers, *faults.lines], loc='upper right',
                fontsize=8, ncols=3)


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


def broken(curve: Curve, name: str, gaps: list[Span]) -> tuple[list[float], list[float]]:
    """Return times and values of a curve, with nan at each gap so that the line breaks."""
    times, values = list(curve.times), list(curve[name])
    for gap in reversed(gaps):
        at = curve.at(gap.start)
        if at is not None and at + 1 < len(times):
            times.insert(at + 1, times[at])
            values.insert(at + 1, nan)
    return times, values


def save(figure: Figure, target: Any, dots: int = 100) -> None:
    """Write the picture as PNG to a file or a stream."""
    figure.savefig(target, format='png', dpi=dots)
