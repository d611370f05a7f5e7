# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Draws the track, and numbers the events along it so that no two numbers touch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import groupby, pairwise, product
from math import cos, hypot, isfinite, sin
from typing import TYPE_CHECKING

from .colors import COLORS, MARKS
from .recording import Recording
from .summary import TimelineEvent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

LISTED = 24
"""Events numbered on the track; a page has no room for more."""
HEADINGS = 30
"""Arrows along the track at most."""
DOTTED = 20_000
"""Points of the track at most that have a colour of their time."""
APART = 1 / 7
"""Least distance of two arrows, as part of the track's size."""
SMALLEST = 0.5
"""Metres that the picture shows at least."""
TOGETHER = 0.17
"""Inches; events that are closer share a label."""
ASIDE = 0.12
"""Inches between the marks of one place."""


def draw_track(axes: Axes, recording: Recording, shown: list[TimelineEvent]) -> None:
    """Draw all but the events."""
    axes.set(xlabel='x, m', ylabel='y, m')
    axes.set_aspect('equal', adjustable='datalim')
    axes.grid(alpha=0.3)
    axes.set_title('Track by odometry, from dark to light;\narrows: heading; numbers: events',
                   fontsize=9)
    odom = recording.odom
    known = [each for each in zip(odom['x'], odom['y'], odom['yaw'], strict=True)
             if all(map(isfinite, each))]
    if not known:
        axes.text(0.5, 0.5, 'no odometry in this bag', ha='center', transform=axes.transAxes)
        return
    xs, ys = odom.broken('x', recording.gaps)[1], odom.broken('y', recording.gaps)[1]
    axes.plot(xs, ys, color='#dddddd', linewidth=5, solid_capstyle='round', zorder=1)
    every = slice(None, None, 1 + len(odom) // DOTTED)
    axes.scatter(odom['x'][every], odom['y'][every], c=odom.times[every], cmap='viridis',
                 s=3, linewidths=0, zorder=2)
    _headings(axes, known)
    ends = (known[0], 'o', 17, 'start'), (known[-1], 's', 11, 'end')
    for (x, y, _), mark, size, label in ends:
        axes.plot(x, y, mark, color='black', markersize=size, fillstyle='none',
                  markeredgewidth=1.5, label=label)
    _legend(axes, recording, shown)


def _legend(axes: Axes, recording: Recording, shown: list[TimelineEvent]) -> None:
    """Explain the marks below the picture, where no track is."""
    from matplotlib.lines import Line2D
    kinds = dict.fromkeys(each.kind for each in shown if recording.place(each.time))
    handles = [line for line in axes.lines if line.get_label() in ('start', 'end')]
    handles += [Line2D([], [], color=COLORS[kind], marker=MARKS[kind], markersize=9,
                       markeredgecolor='white', linestyle='none', label=kind) for kind in kinds]
    axes.legend(handles=handles, loc='upper center', bbox_to_anchor=(0.5, -0.1), fontsize=8,
                ncols=4, columnspacing=1.2, handletextpad=0.3, frameon=False)


def _headings(axes: Axes, known: list[tuple[float, float, float]]) -> None:
    """Draw arrows at equal distances along the track; leave room around it."""
    xs, ys, _ = zip(*known, strict=True)
    size = max(max(xs) - min(xs), max(ys) - min(ys), SMALLEST)
    # Invisible points leave room for marks: equal axes have no margins.
    room = [((size - (max(each) - min(each))) / 2 + size / 8, each) for each in (xs, ys)]
    axes.plot(*([min(each) - more, max(each) + more] for more, each in room), alpha=0)
    whole = sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(known))
    apart, gone, chosen = max(whole / HEADINGS, size * APART), 0.0, known[:1]
    for before, place in pairwise(known):
        gone += hypot(place[0] - before[0], place[1] - before[1])
        if gone >= apart:
            chosen.append(place)
            gone = 0.0
    axes.quiver([x for x, _, _ in chosen], [y for _, y, _ in chosen],
                [cos(yaw) for _, _, yaw in chosen], [sin(yaw) for _, _, yaw in chosen],
                angles='xy', scale=28, width=0.004, color='#333333', zorder=3)


@dataclass
class MarkedPlace:
    """A place on the track, in pixels, with the events that happened there."""

    x: float
    y: float
    events: list[tuple[int, str]] = field(default_factory=list)
    """Number and kind of each."""

    @property
    def label(self) -> str:
        """Return the numbers, such as `1-3, 7`."""
        runs = [[number for _, number in run] for _, run in groupby(
            enumerate(number for number, _ in self.events), lambda each: each[1] - each[0])]
        return ', '.join(f'{run[0]}-{run[-1]}' if len(run) > 2 else ', '.join(map(str, run))
                         for run in runs)


def number_events(axes: Axes, recording: Recording, shown: list[TimelineEvent]) -> None:
    """Mark and number the events; the axes have their final size."""
    places = _places(axes, recording, shown)
    taken = [_mark(axes, place) for place in places]
    for place in places:
        taken.append(_number(axes, place, taken))


def _places(axes: Axes, recording: Recording, shown: list[TimelineEvent]) -> list[MarkedPlace]:
    """Return the places of the events; events that are close share one."""
    found: list[MarkedPlace] = []
    near = TOGETHER * axes.figure.dpi
    for number, each in enumerate(shown, 1):
        where = recording.place(each.time)
        if where is None or not all(map(isfinite, where)):
            continue
        x, y = axes.transData.transform(where)
        place = next((old for old in found if hypot(old.x - x, old.y - y) < near), None)
        if place is None:
            place = MarkedPlace(x, y)
            found.append(place)
        place.events.append((number, each.kind))
    return found


def _mark(axes: Axes, place: MarkedPlace) -> Bbox:
    """Draw a mark for each kind of event, side by side; return the pixels that they cover."""
    from matplotlib.lines import Line2D
    from matplotlib.transforms import Bbox, IdentityTransform
    dots = axes.figure.dpi
    kinds = dict.fromkeys(kind for _, kind in place.events)
    for step, kind in enumerate(kinds):
        axes.add_artist(Line2D(  # `plot` would change the limits of the axes
            [place.x + step * ASIDE * dots], [place.y], marker=MARKS[kind], color=COLORS[kind],
            markersize=9, markeredgecolor='white', linestyle='none', zorder=4,
            transform=IdentityTransform()))
    half = ASIDE / 2 * dots
    return Bbox.from_extents(place.x - half, place.y - half,
                             place.x + (2 * len(kinds) - 1) * half, place.y + half)


def _number(axes: Axes, place: MarkedPlace, taken: list[Bbox]) -> Bbox:
    """Write the numbers where nothing is yet; return the pixels that they cover."""
    text = axes.annotate(
        place.label, (place.x, place.y), xycoords='figure pixels', xytext=(0, 0),
        textcoords='offset points', fontsize=9, fontweight='bold', zorder=5,
        bbox={'boxstyle': 'round,pad=0.15', 'fc': 'white', 'ec': 'none', 'alpha': 0.75})
    text.set_in_layout(False)
    inside = axes.get_window_extent()
    box = text.get_window_extent()
    for side, up in _offsets():
        _move(text, side, up)
        box = text.get_window_extent()
        if not any(box.overlaps(other) for other in taken) and inside.fully_contains(
                box.x0, box.y0) and inside.fully_contains(box.x1, box.y1):
            break
    return box


def _offsets() -> Iterator[tuple[float, float]]:
    """Yield places of a label beside its mark, points: right and left, above and below."""
    for far in range(5):
        for up, side in product((7 + 13 * far, -7 - 13 * far, 0), (7 + 10 * far, -7 - 10 * far)):
            yield side, up


def _move(text: Annotation, side: float, up: float) -> None:
    """Put a label with its near corner at an offset, points."""
    text.set_horizontalalignment('left' if side > 0 else 'right')
    text.set_verticalalignment('bottom' if up > 0 else 'top' if up < 0 else 'center')
    text.set_position((side, up))
