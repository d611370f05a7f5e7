# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole picture of a robot's state, exactly as large as the terminal. Pure."""

from __future__ import annotations

from textwrap import wrap

from ...characters.canvas import Canvas
from ...characters.ink import Ink
from . import chart, panels
from .keys import BINDINGS
from .robot_state import RobotState

LEAST_COLUMNS, LEAST_ROWS = 80, 24
PANEL, LABEL = 36, 8
"""Columns of the panel, and of its labels."""
FOOT, ALARM_ROWS = 4, 2
"""Rows at the bottom (alarms, reply of a service, keys), and those of alarms among them."""
KEYS = 'arrows drive  space stop  +- speed  123 mode  p song  g g dock  h help  q quit'


def picture(
    state: RobotState, now: float, columns: int, rows: int, *, plain: bool = False,
) -> Canvas:
    """Draw everything; on a terminal that is too small, only say so."""
    canvas = Canvas(columns, rows, plain=plain)
    if columns < LEAST_COLUMNS or rows < LEAST_ROWS:
        _too_small(canvas)
        return canvas
    box = chart.Box(1, 0, rows - 1 - FOOT, columns - PANEL - 1)
    _head(canvas, state)
    if state.help_shown:
        _help(canvas, box)
    elif state.nothing_received:
        _paragraph(canvas, box, 'Nothing heard yet. Is a driver running, in this ROS domain and '
                   'namespace?')
    else:
        chart.draw(canvas, box, state.trail, state.pose)
    _panel(canvas, state, now, box.rows)
    _foot(canvas, state, now)
    return canvas


def _too_small(canvas: Canvas) -> None:
    text = (f'create_view needs {LEAST_COLUMNS} x {LEAST_ROWS} characters; here are '
            f'{canvas.columns} x {canvas.rows}. q ends.')
    for row, line in enumerate(wrap(text, max(1, canvas.columns))[:canvas.rows]):
        canvas.put(row, 0, line)


def _head(canvas: Canvas, state: RobotState) -> None:
    linear, angular = state.speeds
    canvas.put(0, 0, ' ' * canvas.columns, highlighted=True)
    speeds = f'keys: {linear:.2f} m/s {angular:.2f} rad/s '
    canvas.put(0, 1, state.title, highlighted=True, width=canvas.columns - len(speeds) - 2)
    canvas.put(0, canvas.columns - len(speeds), speeds, highlighted=True)


def _help(canvas: Canvas, box: chart.Box) -> None:
    lines = [each for each in BINDINGS if each.shown]
    for row, each in enumerate(lines[:box.rows], box.row):
        canvas.put(row, box.column + 1, each.shown, width=8)
        canvas.put(row, box.column + 9, each.about, width=box.columns - 9)


def _paragraph(canvas: Canvas, box: chart.Box, text: str) -> None:
    lines = wrap(text, box.columns - 4)[:box.rows]
    top = box.row + (box.rows - len(lines)) // 2
    for row, line in enumerate(lines, top):
        canvas.put(row, box.column + 2, line)


def _panel(canvas: Canvas, state: RobotState, now: float, rows: int) -> None:
    left = canvas.columns - PANEL
    for row in range(rows):
        canvas.put(row + 1, left - 1, '|' if canvas.plain else '│', ink=Ink.FAINT)
    for row, (about, line) in enumerate(panels.lines(state, now, rows)[:rows], 1):
        canvas.put(row, left, about, ink=Ink.FAINT)
        for piece in line:
            column = left + LABEL + piece.column
            canvas.put(row, column, piece.text, highlighted=piece.highlighted, ink=piece.ink,
                       width=canvas.columns - column)


def _foot(canvas: Canvas, state: RobotState, now: float) -> None:
    alarms = '' if state.nothing_received else '  *  '.join(panels.alarms(state, now))
    call, since = state.call_status, state.call_status.waiting_since
    text = call.text if since is None else f'{call.text} ... {now - since:.0f} s'
    alarm_lines = wrap(alarms, canvas.columns)[:ALARM_ROWS]
    call_lines = wrap(text, canvas.columns)[:FOOT - 1 - len(alarm_lines)]
    for row, line in enumerate(alarm_lines, canvas.rows - FOOT):
        canvas.put(row, 0, line, highlighted=True, ink=Ink.BAD)
    for row, line in enumerate(call_lines, canvas.rows - 1 - len(call_lines)):
        canvas.put(row, 0, line, highlighted=call.highlighted)
    canvas.put(canvas.rows - 1, 0, KEYS, ink=Ink.FAINT)
