# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes the words of a picture: wrapped and shortened to the pixels that they have."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TYPE_CHECKING

from .colors import COLORS
from .recording import Recording
from .summary import clock, summary, TimelineEvent
from .track_drawing import LISTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE, HEAD_SIZE = 9, 10
"""Points of the text, and of its head line."""
LINE = 16
"""Pixels from one line to the next."""
MARGIN = 24
"""Pixels of a page beside its words."""
NUMBER, TIME, TEXT = 24, 78, 88
"""Pixels from the left: ends of number and time, start of the text."""
MORE = ' ...'
Measure = Callable[[str], float]
"""Returns the pixels of a text."""


def measure(figure: Figure, size: float, weight: str = 'normal') -> Measure:
    """Return a function that measures texts of this size in this picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.font_manager import FontProperties
    font = FontProperties(size=size, weight=weight)
    canvas: Any = FigureCanvasAgg(figure)  # its methods have no types
    renderer = canvas.get_renderer()
    return lambda text: float(renderer.get_text_width_height_descent(text, font, False)[0])


def wrapped(text: str, width: float, pixels: Measure) -> list[str]:
    """Return the lines of a text that is wrapped to a width; a longer word is cut."""
    lines = ['']
    for word in text.split():
        longer = f'{lines[-1]} {word}'.strip()
        if pixels(longer) <= width or not lines[-1]:
            lines[-1] = cut(longer, width, pixels)
        else:
            lines.append(cut(word, width, pixels))
    return lines


def cut(text: str, width: float, pixels: Measure) -> str:
    """Return a text that is cut to a width, with MORE in its end if it was."""
    if pixels(text) <= width:
        return text
    low, high = 0, len(text)
    while low < high:
        middle = (low + high + 1) // 2
        if pixels(text[:middle] + MORE) <= width:
            low = middle
        else:
            high = middle - 1
    return text[:low] + MORE


def plain(text: str) -> str:
    """Return a text that matplotlib writes as it stands: `$` would begin a formula."""
    return text.replace('$', r'\$')


class TextColumn:
    """Writes lines from the top of some axes down, so many pixels wide, up to the margin."""

    def __init__(self, figure: Figure, axes: Axes, width: float) -> None:
        self._figure, self.width = figure, width
        self._left = figure.bbox.width - MARGIN - width
        self._top = axes.get_window_extent().y1
        self.row = 0

    def write(self, text: str, left: float = 0, **style: Any) -> None:
        """Write a text in the present row."""
        self._figure.text(
            self._left + left, self._top - self.row * LINE - LINE / 2, plain(text),
            transform=None, va='center', in_layout=False, **{'fontsize': SIZE, **style})


def rows_needed(figure: Figure, recording: Recording, shown: int, width: float) -> int:
    """Return how many rows the words take in a column of so many pixels."""
    pixels = measure(figure, SIZE)
    lines = sum(len(wrapped(each, width, pixels)) for each in summary(recording))
    return lines + 2 + min(shown, LISTED) + (shown > LISTED)


def draw_words(figure: Figure, axes: Axes, recording: Recording, shown: list[TimelineEvent],
               width: float) -> None:
    """Write summary and events, so many pixels wide; the axes have their final size."""
    column = TextColumn(figure, axes, width)
    pixels = measure(figure, SIZE)
    for each in summary(recording):
        for line in wrapped(each, column.width, pixels):
            column.write(line)
            column.row += 1
    column.row += 1
    column.write(cut('What happened when', column.width,
                     measure(figure, HEAD_SIZE, 'bold')),
                 fontsize=HEAD_SIZE, fontweight='bold')
    for number, event in enumerate(shown[:LISTED], 1):
        column.row += 1
        column.write(f'{number}', NUMBER, ha='right', fontweight='bold', color=COLORS[event.kind])
        column.write(clock(event.time), TIME, ha='right')
        column.write(cut(event.text, column.width - TEXT, pixels), TEXT)
    if len(shown) > LISTED:
        column.row += 1
        column.write(cut(f'and {len(shown) - LISTED} more: see the HTML page',
                         column.width - TEXT, pixels), TEXT, style='italic')
