# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is kept of a bag: curves, and what happened."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from functools import partial
from math import nan

from ...ros.collector import Collector, KINDS, Span

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


CURVES = {
    'odom': dict.fromkeys(('x', 'y', 'yaw', 'speed', 'turn'), 0.001),
    'commands': {'speed': 0.001, 'turn': 0.001},
    'battery': {'volts': 0.001, 'amperes': 0.001, 'charge': 0.1},
    'link': dict.fromkeys(('frames', 'damaged', 'garbage'), 0.1),
}
"""The curves of a recording: their columns, and the step of each in the page."""
TOPICS = ('odom', 'cmd_vel', 'battery_state', 'diagnostics', *(
    kind.replace(' ', '_') for kind in KINDS))
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
    events: Collector = field(default_factory=Collector)
    gaps: list[Span] = field(default_factory=list)
    heard: set[str] = field(default_factory=set)
    """Topics with messages in the bag, without the robot's namespace."""
    faults: list[str] = field(default_factory=list)
    """What of the bag is not whole, in words."""
    undefined: list[str] = field(default_factory=list)
    """Topics whose types the bag does not define."""

    @property
    def damage(self) -> str:
        """A sentence about what is not whole; empty if all is."""
        return f'The bag is not whole: {"; ".join(self.faults)}.' if self.faults else ''
