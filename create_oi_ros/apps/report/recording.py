# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is kept of a bag: curves, and what happened."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from functools import partial
from math import nan
from typing import Any

from ...ros.collector import Collector, KINDS, Span
from ...ros.messages import yaw_of

GAP, SILENCE = 0.5, 2.0
"""Seconds without odometry, and without any message, that count as a gap."""
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
    _last_message: float | None = field(default=None, init=False)
    _last_odom: float | None = field(default=None, init=False)

    @property
    def damage(self) -> str:
        """A sentence about what is not whole; empty if all is."""
        return f'The bag is not whole: {"; ".join(self.faults)}.' if self.faults else ''

    def add(self, topic: str, time: float, message: Any) -> None:
        """Add a message of one of TOPICS."""
        before = self.events.newest.get(topic)
        self.events.take(topic, time, message)
        if topic in self.events.newest and self.events.newest[topic] is before:
            return  # the diagnostics of another node
        match topic:
            case 'odom':
                if self._last_odom is not None and time - self._last_odom > GAP:
                    self._gap(self._last_odom, time, 'no odometry: the robot was not heard')
                self._last_odom = time
                position, twist = message.pose.pose.position, message.twist.twist
                self.odom.add(time, position.x, position.y, yaw_of(
                    message.pose.pose.orientation), twist.linear.x, twist.angular.z)
            case 'cmd_vel':
                twist = getattr(message, 'twist', message)  # of a TwistStamped
                self.commands.add(time, twist.linear.x, twist.angular.z)
            case 'battery_state':
                self.battery.add(
                    time, message.voltage, message.current, 100 * message.percentage)
            case 'diagnostics' if link := self.events.link:
                self.link.add(time, *(_number(link.get(key)) for key in (
                    'frames per second', 'damaged frames', 'garbage bytes')))

    def note_time(self, time: float) -> None:
        """Note the time of a message; a long silence before it is a gap."""
        if self._last_message is not None and time - self._last_message > SILENCE:
            self._gap(self._last_message, time, 'nothing was recorded')
            self._last_odom = None
        self._last_message = time

    def finish(self) -> None:
        """End what lasts at the end of the bag."""
        self.events.finish(self.seconds)
        if self._last_odom is not None and self.seconds - self._last_odom > 2 * GAP:
            self._gap(self._last_odom, self.seconds, 'no odometry up to the end')

    def _gap(self, start: float, end: float, text: str) -> None:
        gap = Span('gap', start, text)
        gap.end = end
        self.gaps.append(gap)


def _number(text: str | None) -> float:
    try:
        return float(text or 'nan')
    except ValueError:
        return float('nan')
