# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page needs of a recording, small: whole steps, compressed. Pure."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable
import json
from math import isfinite
from typing import Any, NamedTuple
import zlib

from .recording import Curve, Recording, Span, SPANS
from .thinning import kept

LARGEST = 2_800_000
"""Bytes of the data in the page: with all else, an hour stays below 3 MB."""
PAUSE = 0.6
"""Seconds without a command after which its line ends."""
FEWEST = 500
"""Points of a curve that stay, whatever the size."""
LEVEL = 9
"""Of the compression."""


TIME = 0.001
"""Step of the times, seconds."""


class PageCurve(NamedTuple):
    """A curve in the page: the step of each column, and the columns whose peaks stay."""

    units: dict[str, float]
    peaks: tuple[str, ...]


CURVES = {
    'odom': PageCurve(dict.fromkeys(('x', 'y', 'yaw', 'speed', 'turn'), 0.001),
                      ('speed', 'turn')),
    'commands': PageCurve({'speed': 0.001, 'turn': 0.001}, ('speed', 'turn')),
    'battery': PageCurve({'volts': 0.001, 'amperes': 0.001, 'charge': 0.1},
                         ('volts', 'amperes')),
    'link': PageCurve(dict.fromkeys(('frames', 'damaged', 'garbage'), 0.1),
                      ('frames', 'damaged', 'garbage')),
}
"""The curves of the page, and of a recording."""


def steps(values: Iterable[float], unit: float) -> list[int | None]:
    """Return values as whole steps of a unit, each from the one before; None: it is no number."""
    found: list[int | None] = []
    before = 0
    for value in values:
        if not isfinite(value):
            found.append(None)
            continue
        whole = round(value / unit)
        found.append(whole - before)
        before = whole
    return found


def _curve(curve: Curve, shape: PageCurve, most: int) -> Any:
    places = kept([curve[name] for name in shape.peaks], most)
    columns = {'t': (curve.times, TIME)}
    columns |= {name: (curve[name], unit) for name, unit in shape.units.items()}
    return {name: {'unit': unit, 'steps': steps((values[at] for at in places), unit)}
            for name, (values, unit) in columns.items()}


def _bars(spans: Iterable[Span]) -> list[list[Any]]:
    return [[round(span.start, 3), round(span.end, 3), span.text] for span in spans]


def page_data(recording: Recording, most: int) -> dict[str, Any]:
    """Return all that the page draws, with at most `most` points of each curve."""
    return {
        'seconds': recording.seconds, 'pause': PAUSE, 'damage': recording.damage,
        'began': recording.began, 'jumps': [round(each.start, 3) for each in recording.jumps],
        'gaps': [each[:2] for each in _bars(recording.gaps)],
        'spans': [{'name': name, 'spans': _bars(recording.spans[name].all)} for name in SPANS
                  if name.replace(' ', '_') in recording.heard],
        'curves': {name: _curve(getattr(recording, name), shape, most)
                   for name, shape in CURVES.items()},
    }


def packed(recording: Recording) -> str:
    """Return the page's data as text of letters, thinned only as far as its size demands."""
    most = max(len(getattr(recording, name)) for name in CURVES) + 1
    while True:
        text = json.dumps(page_data(recording, most), allow_nan=False, separators=(',', ':'))
        found = b64encode(zlib.compress(text.encode(), LEVEL)).decode('ascii')
        if len(found) <= LARGEST or most <= FEWEST:
            return found
        most = max(FEWEST, int(most * LARGEST / len(found) * 0.95))
