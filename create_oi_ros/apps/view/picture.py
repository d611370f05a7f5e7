"""The whole picture of a state, exactly as large as the terminal; pure."""

from __future__ import annotations

from textwrap import wrap

from . import chart, panels
from .canvas import Canvas
from .keys import BINDINGS
from .robot_state import State

LEAST_COLUMNS, LEAST_ROWS = 80, 24
PANEL, LABEL = 36, 8
"""Columns of the panel, and of what its lines are about."""
FOOT, ALARM_ROWS = 4, 2
"""Rows at the bottom: what is amiss, what was answered, which keys there are."""
KEYS = 'arrows drive  space stop  +- speed  123 mode  p song  g dock  h help  q quit'


def picture(state: State, now: float, columns: int, rows: int, *, plain: bool = False) -> Canvas:
    """Draw all; on too small a terminal say so."""
    canvas = Canvas(columns, rows, plain=plain)
    if columns < LEAST_COLUMNS or rows < LEAST_ROWS:
        _too_small(canvas)
        return canvas
    box = chart.Box(1, 0, rows - 1 - FOOT, columns - PANEL - 1)
    _head(canvas, state)
    if state.helping:
        _help(canvas, box)
    elif state.silent:
        _paragraph(canvas, box, 'Nothing heard yet. Is a driver running, in this ROS domain and '
                   'namespace?')
    else:
        chart.draw(canvas, box, state.track, state.pose)
    _panel(canvas, state, now, box.rows)
    _foot(canvas, state, now)
    return canvas


def _too_small(canvas: Canvas) -> None:
    text = (f'create_view needs {LEAST_COLUMNS} x {LEAST_ROWS} characters; here are '
            f'{canvas.columns} x {canvas.rows}. q ends.')
    for row, line in enumerate(wrap(text, max(1, canvas.columns))[:canvas.rows]):
        canvas.put(row, 0, line)


def _head(canvas: Canvas, state: State) -> None:
    linear, angular = state.speeds
    canvas.put(0, 0, ' ' * canvas.columns, loud=True)
    speeds = f'keys: {linear:.2f} m/s {angular:.2f} rad/s '
    canvas.put(0, 1, state.title, loud=True, width=canvas.columns - len(speeds) - 2)
    canvas.put(0, canvas.columns - len(speeds), speeds, loud=True)


def _help(canvas: Canvas, box: chart.Box) -> None:
    for row, each in enumerate(BINDINGS[:box.rows], box.row):
        canvas.put(row, box.column + 1, each.shown, width=8)
        canvas.put(row, box.column + 9, each.about, width=box.columns - 9)


def _paragraph(canvas: Canvas, box: chart.Box, text: str) -> None:
    lines = wrap(text, box.columns - 4)[:box.rows]
    top = box.row + (box.rows - len(lines)) // 2
    for row, line in enumerate(lines, top):
        canvas.put(row, box.column + 2, line)


def _panel(canvas: Canvas, state: State, now: float, rows: int) -> None:
    left = canvas.columns - PANEL
    for row in range(rows):
        canvas.put(row + 1, left - 1, '|' if canvas.plain else '│')
    for row, (about, line) in enumerate(panels.lines(state, now)[:rows], 1):
        canvas.put(row, left, about)
        for piece in line:
            column = left + LABEL + piece.column
            canvas.put(row, column, piece.text, loud=piece.loud, width=canvas.columns - column)


def _foot(canvas: Canvas, state: State, now: float) -> None:
    found = '  *  '.join(panels.alarms(state, now)) if not state.silent else ''
    note, since = state.note, state.note.waiting_since
    text = note.text if since is None else f'{note.text} ... {now - since:.0f} s'
    amiss = wrap(found, canvas.columns)[:ALARM_ROWS]
    said = wrap(text, canvas.columns)[:FOOT - 1 - len(amiss)]
    for row, line in enumerate(amiss, canvas.rows - FOOT):
        canvas.put(row, 0, line, loud=True)
    for row, line in enumerate(said, canvas.rows - 1 - len(said)):
        canvas.put(row, 0, line, loud=note.loud)
    canvas.put(canvas.rows - 1, 0, KEYS)
