# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is kept of a bag: curves, and every change of state."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from math import inf, nan

MOST = 1e6
"""A larger value of any curve (m, m/s, V, bytes/s) is an error in the bag."""


class Curve:
    """Named values over time."""

    def __init__(self, *names: str) -> None:
        self.times = array('d')
        self._columns = {name: array('d') for name in names}

    def __getitem__(self, name: str) -> array[float]:
        return self._columns[name]

    def __len__(self) -> int:
        return len(self.times)

    def add(self, time: float, *values: float) -> None:
        """Add a point, its values in the order of the names; impossible values become nan."""
        self.times.append(time)
        for column, value in zip(self._columns.values(), values, strict=True):
            column.append(value if abs(value) <= MOST else nan)


@dataclass
class Span:
    """A period in one state; `end` is inf while it lasts."""

    start: float
    text: str
    end: float = inf
    reason: str = ''


class Spans:
    """The periods of one kind of state, one after the other."""

    def __init__(self) -> None:
        self.all: list[Span] = []

    def __len__(self) -> int:
        return len(self.all)

    @property
    def _open(self) -> Span | None:
        return self.all[-1] if self.all and self.all[-1].end == inf else None

    def change(self, time: float, text: str, reason: str = '') -> None:
        """Begin a new state; an empty text means none."""
        span = self._open
        if span is not None:
            if (span.text, span.reason) == (text, reason):
                return
            span.end = time
        if text:
            self.all.append(Span(time, text, reason=reason))

    def contact(self, time: float, names: Iterable[str]) -> None:
        """Note the contacts that are active; all until none is active make one span."""
        names, span = list(names), self._open
        if span is None:
            if names:
                self.all.append(Span(time, ' and '.join(names)))
        elif names:
            known = span.text.split(' and ')
            span.text = ' and '.join([*known, *(name for name in names if name not in known)])
        else:
            span.end = time

    def close(self, time: float) -> None:
        """End the span that is still open."""
        if self._open is not None:
            self.all[-1].end = time


CURVES = {
    'odom': dict.fromkeys(('x', 'y', 'yaw', 'speed', 'turn'), 0.001),
    'commands': {'speed': 0.001, 'turn': 0.001},
    'battery': {'volts': 0.001, 'amperes': 0.001, 'charge': 0.1},
    'link': dict.fromkeys(('frames', 'damaged', 'garbage'), 0.1),
}
"""The curves of a recording: their columns, and the step of each in the page."""
SPANS = ('mode', 'bumper', 'cliff', 'wheel drop', 'overcurrent', 'buttons', 'song', 'charging')
"""Rows of the timeline, from top to bottom."""
TOPICS = ('odom', 'cmd_vel', 'battery_state', 'diagnostics', *(
    kind.replace(' ', '_') for kind in SPANS))
"""Topics of a robot that are read, without its namespace."""


@dataclass
class Recording:
    """Everything that the report shows of a bag; times are seconds from its first message."""

    name: str
    storage: str
    began: float
    """Seconds since the epoch."""
    seconds: float
    messages: int
    robot: str = ''
    """Namespace of the robot; empty if it has none."""
    odom: Curve = field(default_factory=partial(Curve, *CURVES['odom']))
    commands: Curve = field(default_factory=partial(Curve, *CURVES['commands']))
    battery: Curve = field(default_factory=partial(Curve, *CURVES['battery']))
    link: Curve = field(default_factory=partial(Curve, *CURVES['link']))
    spans: dict[str, Spans] = field(default_factory=lambda: {name: Spans() for name in SPANS})
    warnings: dict[str, Spans] = field(default_factory=dict)
    """Warnings of the diagnostics, by the name of the status."""
    gaps: list[Span] = field(default_factory=list)
    jumps: list[Span] = field(default_factory=list)
    """Where the odometry goes on elsewhere, without the robot's driving there."""
    heard: set[str] = field(default_factory=set)
    """Topics with messages in the bag, without the robot's namespace."""
    settings: dict[str, str] = field(default_factory=dict)
    """Version and parameters of the driver."""
    faults: list[str] = field(default_factory=list)
    """What of the bag is not whole, in words."""
    undefined: list[str] = field(default_factory=list)
    """Topics whose types the bag does not define."""

    @property
    def damage(self) -> str:
        """A sentence about what is not whole; empty if all is."""
        return f'The bag is not whole: {"; ".join(self.faults)}.' if self.faults else ''
