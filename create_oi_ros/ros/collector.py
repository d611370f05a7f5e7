# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Collects what a driver publishes, live or from a bag: the newest of each topic, and what happened.

A message may be ROS's own, or one of a library that reads bags: both have the same fields. Times
are seconds of any clock that does not stand still.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from math import degrees, hypot, inf, isfinite, remainder, tau
from typing import Any, NamedTuple

from create_oi_msgs import msg
from rclpy.node import Node
from rclpy.qos import QoSProfile

from ..robot import TOP_SPEED
from .diagnostics import LINK, of_driver, PARAMETERS
from .messages import charging_name, mode_name, yaw_of
from .topics import PUBLISHED

CONTACTS = {'bumper': 'Bump', 'cliff': 'Cliff', 'wheel drop': 'Wheel drop',
            'overcurrent': 'Too much current', 'buttons': 'Button'}
"""Kinds of events that come from flags, and how their sentences begin."""
BEGINNINGS = {**CONTACTS, 'mode': 'Mode', 'song': 'Plays', 'charging': 'Charging:',
              'jump': 'Odometry'}
"""How the sentences of all kinds begin; those of a warning begin with its status."""
HAZARDS = ('bumper', 'cliff', 'wheel drop', 'overcurrent')
KINDS = ('mode', *CONTACTS, 'song', 'charging')
NAMES = {topic.name.lstrip('/'): topic for topic in PUBLISHED}
"""The driver's topics, by their names without namespace."""
LEVELS = {1: 'warn', 2: 'error', 3: 'error'}
"""Of a status of the diagnostics: ROS has numbers."""
REPEATED = ('mode', 'safety', PARAMETERS)
"""Statuses of the diagnostics that repeat what topics say, or never change."""
FARTHEST = 1e6
"""Metres from the origin beyond which a place is wrong."""
STEP, FASTEST = 0.05, 2 * TOP_SPEED
"""Metres by which the odometry may correct itself at once, and m/s beyond that."""
TURN_STEP, FASTEST_TURN = 0.3, 2 * TOP_SPEED / 0.129
"""The same for the heading: radians and rad/s."""
SETTLING = 1.0
"""Seconds within which the number of a song that has just begun may still be corrected."""


class Span:
    """Something that lasts: a state, a contact, a warning; `end` is inf while it does."""

    def __init__(self, kind: str, start: float, text: str, reason: str = '',
                 level: str = '') -> None:
        """`level` is '', 'warn' or 'error'."""
        self.kind, self.start, self.end = kind, start, inf
        self.text, self.reason, self.level = text, reason, level

    @property
    def sentence(self) -> str:
        """What a person reads of it."""
        begin = BEGINNINGS.get(self.kind, f'{self.kind}:')
        return f'{begin} {self.text}' + (f' ({self.reason})' if self.reason else '')


class Spans:
    """The spans of a kind, one after the other."""

    def __init__(self, kind: str, most: int | None = None) -> None:
        """Keep the last `most`; None: all."""
        self.kind = kind
        self.all: deque[Span] = deque(maxlen=most)

    def __len__(self) -> int:
        return len(self.all)

    @property
    def open(self) -> Span | None:
        """The one that lasts; None: none does."""
        return self.all[-1] if self.all and self.all[-1].end == inf else None

    def change(self, time: float, text: str, reason: str = '', level: str = '') -> list[Span]:
        """Begin a new one, unless it is as the last; an empty text means none. Return the new."""
        last = self.open
        if last is not None:
            if (last.text, last.reason, last.level) == (text, reason, level):
                return []
            last.end = time
        if not text:
            return []
        self.all.append(Span(self.kind, time, text, reason, level))
        return [self.all[-1]]

    def contact(self, time: float, names: Iterable[str], level: str) -> list[Span]:
        """Note the contacts that are active; all until none is active make one span."""
        touched, last = list(names), self.open
        if last is None:
            return self.change(time, ' and '.join(touched), level=level)
        if touched:
            known = last.text.split(' and ')
            last.text = ' and '.join([*known, *(name for name in touched if name not in known)])
        else:
            last.end = time
        return []


class FlatPose(NamedTuple):
    """A pose on the floor: metres and radians."""

    x: float
    y: float
    yaw: float

    def jumped(self, last: FlatPose, seconds: float) -> str:
        """Say that no robot can come here from its last pose in this time; '': it can."""
        moved = hypot(self.x - last.x, self.y - last.y)
        turned = abs(remainder(self.yaw - last.yaw, tau))
        anew = self.x == self.y == 0 != moved
        if not anew and moved <= STEP + FASTEST * seconds and (
                turned <= TURN_STEP + FASTEST_TURN * seconds):
            return ''
        if hypot(self.x, self.y) < STEP:
            return 'begins anew (reset_odometry, or the driver was restarted)'
        return f'jumps by {moved:.2f} m, {degrees(turned):.0f} degrees (reset_pose)'


class Collector:
    """Takes the messages of one driver."""

    def __init__(self, namespace: str = '', most: int | None = None) -> None:
        """Take those of the driver in this namespace; keep the last `most` spans of a kind."""
        self._namespace, self._most = namespace.strip('/'), most
        self.newest: dict[str, Any] = {}
        """The newest message of each topic; of the diagnostics the driver's statuses, by name."""
        self.spans = {kind: Spans(kind, most) for kind in KINDS}
        self.warnings: dict[str, Spans] = {}
        """Warnings of the diagnostics, by the name of the status."""
        self.jumps = Spans('jump', most)
        """Where the odometry goes on elsewhere, without the robot's driving there."""
        self.pose: FlatPose | None = None
        """The newest pose by the odometry, if it is one."""
        self._moved_at = self._stamp = 0.0

    def take(self, name: str, time: float, message: Any) -> list[Span] | None:
        """Take a message of a topic; return what begins with it. None: it is of another node."""
        if name == 'diagnostics':
            statuses = of_driver(message, self._namespace)
            return self._diagnose(time, statuses) if statuses else None
        self.newest[name] = message
        kind = name.replace('_', ' ')
        if name == 'odom':
            return self._move(time, message)
        if kind in CONTACTS:
            touched = (flag.replace('_', ' ') for flag, on in flags(name, message).items() if on)
            return self.spans[kind].contact(time, touched, 'warn' if kind in HAZARDS else '')
        if name == 'mode':
            level = '' if message.mode == message.wanted else 'warn'
            return self.spans[kind].change(
                time, mode_name(message.mode, message.reason), message.reason, level)
        if name == 'charging':
            idle = message.state == msg.Charging.NOT_CHARGING
            return self.spans[kind].change(time, '' if idle else charging_name(message.state))
        return self._sing(time, message) if name == 'song' else []

    def _move(self, time: float, odom: Any) -> list[Span]:
        pose, stamp = odom.pose.pose, odom.header.stamp
        here = FlatPose(pose.position.x, pose.position.y, yaw_of(pose.orientation))
        if not (hypot(here.x, here.y) <= FARTHEST and isfinite(here.yaw)):  # also no number
            return []
        # Who was held up gets several messages at once: their stamps are apart.
        stamped = stamp.sec + stamp.nanosec / 1e9
        seconds = max(time - self._moved_at, stamped - self._stamp)
        last, self.pose = self.pose, here
        self._moved_at, self._stamp = time, stamped
        begun = [] if last is None else self.jumps.change(time, here.jumped(last, seconds))
        for jump in begun:
            jump.end = time
        return begun

    def _sing(self, time: float, song: Any) -> list[Span]:
        spans, text = self.spans['song'], f'song {song.number}' if song.playing else ''
        last = spans.open
        if text and last is not None and time - last.start < SETTLING:
            last.text = text
            return []
        return spans.change(time, text)

    def _diagnose(self, time: float, statuses: Mapping[str, Any]) -> list[Span]:
        self.newest['diagnostics'] = statuses
        begun: list[Span] = []
        for name, status in statuses.items():
            if name in REPEATED:
                continue
            level = LEVELS.get(level_of(status), '')
            begun += self.warnings.setdefault(name, Spans(name, self._most)).change(
                time, status.message if level else '', level=level)
        return begun

    def finish(self, time: float) -> None:
        """End what lasts."""
        for spans in (*self.spans.values(), *self.warnings.values()):
            if spans.open is not None:
                spans.open.end = time

    @property
    def settings(self) -> dict[str, str]:
        """Version and parameters of the driver, as its diagnostics say."""
        return values_of(self.newest.get('diagnostics', {}).get(PARAMETERS))

    @property
    def link(self) -> dict[str, str]:
        """What the diagnostics count of the serial line."""
        return values_of(self.newest.get('diagnostics', {}).get(LINK))


def subscribe(node: Node, names: Iterable[str], take: Callable[[str, Any], None],
              **qos: QoSProfile) -> None:
    """Let a node take messages of these topics, with their names; `qos` of some is another one."""
    for name in names:
        topic = NAMES[name]
        node.create_subscription(
            topic.type, topic.name, partial(take, name), qos.get(name, topic.subscription_qos))


def flags(name: str, message: Any) -> dict[str, bool]:
    """Return the booleans of a message of a topic."""
    type_: Any = NAMES[name].type
    return {field: bool(getattr(message, field))
            for field, kind in type_.get_fields_and_field_types().items() if kind == 'boolean'}


def level_of(status: Any) -> int:
    """Return the level of a status as a number; bags may have it as a byte."""
    return status.level if isinstance(status.level, int) else int(status.level[0])


def values_of(status: Any) -> dict[str, str]:
    """Return the values of a status by their keys; none of None."""
    return {} if status is None else {each.key: each.value for each in status.values}
