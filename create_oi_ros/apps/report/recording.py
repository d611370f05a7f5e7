"""What is kept of a bag: curves that are thinned out, and every change of state."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import inf, nan

MOST = 1e6
"""Metres, m/s, volts or bytes a second that nothing here reaches: beyond it a bag is broken."""


class Curve:
    """Values over time, no two nearer to each other than `spacing` seconds."""

    def __init__(self, *names: str, spacing: float = 0.0) -> None:
        self.times = array('d')
        self._columns = {name: array('d') for name in names}
        self._spacing = spacing
        self._next = -inf

    def __getitem__(self, name: str) -> array[float]:
        return self._columns[name]

    def __len__(self) -> int:
        return len(self.times)

    def due(self, time: float) -> bool:
        """Tell whether a value at this time would be kept: only then it need be worked out."""
        return time >= self._next

    def add(self, time: float, *values: float) -> None:
        """Keep values, in the order of their names; nan stands for what cannot be."""
        self._next = time + self._spacing
        self.times.append(time)
        for column, value in zip(self._columns.values(), values, strict=True):
            column.append(value if abs(value) <= MOST else nan)

    def at(self, time: float) -> int | None:
        """Return the place of the last value up to a time; None: there is none."""
        place = bisect_right(self.times, time) - 1
        return place if place >= 0 else None


@dataclass
class Span:
    """A time in which something was so; `end` is inf while it still is."""

    start: float
    text: str
    end: float = inf
    reason: str = ''


class Spans:
    """The times in which something was so, one after the other."""

    def __init__(self) -> None:
        self.all: list[Span] = []

    def __len__(self) -> int:
        return len(self.all)

    @property
    def _open(self) -> Span | None:
        return self.all[-1] if self.all and self.all[-1].end == inf else None

    def become(self, time: float, text: str, reason: str = '') -> None:
        """Note what is so from now on; '': nothing."""
        now = self._open
        if now is not None:
            if (now.text, now.reason) == (text, reason):
                return
            now.end = time
        if text:
            self.all.append(Span(time, text, reason=reason))

    def touch(self, time: float, names: Iterable[str]) -> None:
        """Note what is touched; from the first to the last touch is one time."""
        names, now = list(names), self._open
        if now is None:
            if names:
                self.all.append(Span(time, ' and '.join(names)))
        elif names:
            known = now.text.split(' and ')
            now.text = ' and '.join([*known, *(name for name in names if name not in known)])
        else:
            now.end = time

    def close(self, time: float) -> None:
        """End what is still so where the recording ends."""
        if self._open is not None:
            self.all[-1].end = time


SPANS = ('mode', 'bumper', 'cliff', 'wheel drop', 'overcurrent', 'buttons', 'song', 'charging')
"""What a timeline shows, from top to bottom."""


@dataclass
class Recording:
    """All that the report tells of a bag; times are seconds from its first message."""

    name: str
    storage: str
    began: float
    """Seconds since the epoch."""
    seconds: float
    messages: int
    odom: Curve
    commands: Curve
    battery: Curve
    link: Curve
    robot: str = ''
    """The namespace, where the robot has one."""
    spans: dict[str, Spans] = field(default_factory=lambda: {name: Spans() for name in SPANS})
    complaints: dict[str, Spans] = field(default_factory=dict)
    """What the diagnostics warned of, by the name of the status."""
    gaps: list[Span] = field(default_factory=list)
    settings: dict[str, str] = field(default_factory=dict)
    """Version and parameters of the driver."""
    damage: str = ''
    """Where and why reading had to stop before the end."""

    def place(self, time: float) -> tuple[float, float] | None:
        """Return where the robot was, by its odometry."""
        at = self.odom.at(time)
        return None if at is None else (self.odom['x'][at], self.odom['y'][at])
