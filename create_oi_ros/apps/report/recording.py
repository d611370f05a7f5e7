# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is kept of a bag, curves and what happened, and how it is read, from front to back."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from math import nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore

from ...ros.bags import definitions, full_name
from ...ros.collector import Collector, KINDS, Span
from ...ros.messages import yaw_of
from ...ros.programs import UserError
from ...ros.topics import CMD_VEL, PUBLISHED
from ...ros.velocity import COMMANDS
from .bag_files import BagFiles, DamageError, reading, Topic

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
    _last_message: float | None = field(default=None, init=False)
    _last_odom: float | None = field(default=None, init=False)

    @property
    def damage(self) -> str:
        """A sentence about what is not whole; empty if all is."""
        return f'The bag is not whole: {"; ".join(self.faults)}.' if self.faults else ''

    def add(self, topic: str, time: float, message: Any) -> None:
        """Add a message of one of TOPICS; a long silence before it is a gap."""
        if self._last_message is not None and time - self._last_message > SILENCE:
            self._gap(self._last_message, time, 'nothing was recorded')
            self._last_odom = None
        self._last_message = time
        if self.events.take(topic, time, message) is None:
            return
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


# How it is read.

DIAGNOSTICS = 'diagnostic_msgs/msg/DiagnosticArray'
TYPES = {full_name(topic.type): topic.name for topic in PUBLISHED
         if topic.name in TOPICS} | dict.fromkeys(COMMANDS, CMD_VEL)
"""The name of the topic that has a type."""
Progress = Callable[[float], None]
"""Called with the part that is done, 0 to 1."""


def read(path: Path, robot: str | None = None,
         progress: Progress = lambda part: None) -> Recording:
    """Read a bag; UserError says why it cannot be read, or that a robot must be named."""
    with TemporaryDirectory(prefix='create_report-') as folder:
        files = BagFiles(path, Path(folder))
        topics, robot = _wanted(files, path, robot)
        recording = Recording(
            path.resolve().name, files.start / 1e9, (files.end - files.start) / 1e9,
            files.counts.total(), robot, events=Collector(robot),
            heard=set(map(base_name, topics)), faults=files.faults)
        shown = 0.0
        try:
            decoders = {topic: _decoder(topic) for topic in topics}
            for topic, stamp, raw in files.messages(topics):
                time = (stamp - files.start) / 1e9
                if time > shown:
                    progress(time / recording.seconds)
                    shown = time + recording.seconds / 100
                with reading():
                    message = decoders[topic].deserialize_cdr(raw, topic.type)
                recording.add(base_name(topic), time, message)
        except DamageError as error:
            files.faults.append(str(error))
        progress(1.0)
        recording.finish()
    if not recording.odom and not any(map(len, recording.events.spans.values())):
        raise UserError(f'{path} is damaged: {"; ".join(files.faults)}' if files.faults else
                        f'{path} holds no message of this driver')
    return recording


def _decoder(topic: Topic) -> Typestore:
    """Return the definitions that decode a topic: those of the bag, if it has them as text."""
    if topic.encoding != 'ros2msg':
        return definitions()
    with reading():
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(topic.definition, topic.type))
    return store


def base_name(topic: Topic) -> str:
    """Return the name of a topic without its namespace."""
    return topic.name.rpartition('/')[2]


def _wanted(files: BagFiles, path: Path, robot: str | None) -> tuple[set[Topic], str]:
    """Return the topics of one robot, and its namespace."""
    found: dict[str, set[Topic]] = {}
    for topic in files.counts:
        if base_name(topic) == TYPES.get(topic.type):
            found.setdefault(topic.name.rpartition('/')[0].strip('/'), set()).add(topic)
    robots = {space: topics for space, topics in found.items()
              if {'odom', 'mode'} & set(map(base_name, topics))}
    if not robots:
        names = ', '.join(sorted(topic.name for topic in files.counts)[:6])
        raise UserError(f'{path} has neither `odom` nor `mode` of this driver: its topics are '
                       f'{names}')
    if robot is None and len(robots) > 1:
        raise UserError(f'{path} holds several robots, name one with --robot: '
                       f'{_listed(robots)}')
    chosen = next(iter(robots)) if robot is None else robot.strip('/')
    if chosen not in robots:
        raise UserError(f'{path} has no robot {chosen or "/"}: it has {_listed(robots)}')
    return robots[chosen] | {topic for topic in files.counts if topic.type == DIAGNOSTICS}, chosen


def _listed(robots: Iterable[str]) -> str:
    """Return namespaces as --robot takes them; / is a robot without one."""
    return ', '.join(space or '/' for space in sorted(robots))
