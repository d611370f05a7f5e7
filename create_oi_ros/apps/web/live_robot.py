# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the pages show of a robot: the newest of each part, and the past. Pure.

Each part is a piece of JSON with the number of its last change. A page is sent the parts that have
changed since it was sent something before.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
import json
from math import exp, hypot, inf, isfinite
from typing import Any, NamedTuple

from create_oi_msgs import msg

from ...ros.collector import Collector, flags, FlatPose, level_of, NAMES, REPEATED, values_of
from ...ros.messages import charging_name, mode_name

PARTS: Mapping[str, str] = {
    'odom': 'pose', 'battery_state': 'battery', 'mode': 'mode', 'charging': 'charging',
    'bumper': 'bump', 'cliff': 'cliff', 'wheel_drop': 'drop', 'wall': 'wall',
    'buttons': 'buttons', 'overcurrent': 'overcurrent', 'song': 'song', 'ir_omni': 'infrared',
    'diagnostics': 'diagnostics'}
"""Topics that `LiveRobot.update` takes, and the parts that are made from them."""
ON_THE_MAP = ('bumper', 'cliff', 'wheel drop')
"""Kinds of events that are shown where they happened."""
SILENT = 1.5
"""Seconds without odometry after which the driver counts as silent."""
OLD, OLDEST = 3.5, 30.0
"""Seconds after which a value is old that should come again: at least, and at most, where three
times its last interval lies between."""
SMOOTHING = 20.0
"""Seconds over which the current is averaged."""
LEAST_CURRENT = 0.02
"""Amperes below which no time is told."""
LONGEST_TIME = 24 * 60
"""Minutes; a longer time is not told."""

STEP = 0.02
"""Metres between two points of the track, at first."""
MOST_POINTS = 20_000
MOST_EVENTS, MOST_LOGGED = 500, 200
CHART_SECONDS, SAMPLE_PERIOD = 60.0, 0.2
"""Seconds that the charts show, and between two of their samples."""

def finite(value: float, digits: int) -> float | None:
    """Return a rounded number; None, which JSON can say, if it is infinite or no number."""
    return round(value, digits) if isfinite(value) else None


def _signal(strength: int) -> int | None:
    return None if strength == msg.Wall.SIGNAL_UNKNOWN else strength


class Parts:
    """Pieces of JSON by name, each with the number of its last change."""

    def __init__(self) -> None:
        self._parts: dict[str, tuple[int, str]] = {}
        self.changes = 0
        """Number of the last change."""

    def put(self, name: str, value: Any) -> bool:
        """Store a part; return whether it differs, and so counts as changed."""
        text = json.dumps(value, allow_nan=False, separators=(',', ':'))
        differs = self._parts.get(name, (0, ''))[1] != text
        if differs:
            self.changes += 1
            self._parts[name] = self.changes, text
        return differs

    def since(self, changes: int) -> dict[str, str]:
        """Return the parts that have changed since that number of changes."""
        return {name: text for name, (changed, text) in self._parts.items() if changed > changes}


class NewestLog:
    """The newest entries of a log, with running numbers: readers ask for all since theirs."""

    def __init__(self, most: int) -> None:
        """Keep this many entries."""
        self._kept: deque[Any] = deque(maxlen=most)
        self.count = 0
        """Entries that were ever added."""

    def add(self, entry: Any) -> None:
        """Add an entry; the oldest one may be dropped."""
        self._kept.append(entry)
        self.count += 1

    def since(self, count: int) -> list[Any]:
        """Return the entries that were added when there were `count` already."""
        return list(self._kept)[max(0, len(self._kept) - self.count + count):]


class TrackLog:
    """
    The robot's track: a point for each STEP.

    When there are MOST_POINTS, every second one is dropped, and from then on they are twice as far
    apart.
    """

    def __init__(self) -> None:
        self._points: list[FlatPose] = []
        self._step = STEP
        self.epoch = 0
        """Grows when the track begins anew, or has lost points."""

    def __len__(self) -> int:
        return len(self._points)

    def add(self, pose: FlatPose) -> None:
        """Add a pose, if it is a step from the last one."""
        last = self._points[-1] if self._points else None
        if last is not None and hypot(pose.x - last.x, pose.y - last.y) < self._step:
            return
        self._points.append(pose)
        if len(self._points) > MOST_POINTS:
            del self._points[1::2]
            self._step *= 2
            self.epoch += 1

    def clear(self) -> None:
        """Begin anew."""
        self._points, self._step = [], STEP
        self.epoch += 1

    def since(self, count: int) -> list[float]:
        """Return the points after so many, as x, y, x, y, ... in millimetre steps."""
        return [round(each, 3) for pose in self._points[count:] for each in pose[:2]]


class Cursor(NamedTuple):
    """How far a page has been told."""

    changes: int = 0
    epoch: int = -1
    track: int = 0
    events: int = 0
    samples: int = 0
    log: int = 0


class LiveRobot:
    """Takes the messages of a driver, and tells pages what is new."""

    def __init__(self, namespace: str = '') -> None:
        """Take those of the driver in this namespace."""
        self.collector = Collector(namespace, MOST_EVENTS)
        self.parts = Parts()
        self.track = TrackLog()
        self.events = NewestLog(MOST_EVENTS)
        self.samples = NewestLog(round(CHART_SECONDS / SAMPLE_PERIOD))
        self.log = NewestLog(MOST_LOGGED)
        """What happened: when, how bad ('', warn or error), and what."""
        self._current, self._current_at = 0.0, -inf
        """Mean current of the battery, A, and when it was taken."""
        self.resets = 0
        """How often the odometry has begun anew."""
        self._seen: dict[str, tuple[float, float]] = {}
        """When a part that comes again came last, and until when it is not old."""
        self._sampled_at = -inf

    def happened(self, level: str, text: str, now: float) -> None:
        """Add an entry to what happened."""
        self.log.add([round(now, 2), level, text])

    def update(self, name: str, message: Any, now: float) -> None:
        """Take a message of a topic of the driver."""
        collector, part = self.collector, PARTS[name]
        pose, new = collector.pose, collector.take(name, now, message)
        if new is None:
            return
        for begun in new:
            self.happened(begun.level, begun.sentence, now)
            if begun.kind == 'jump':
                self.forget()
            elif begun.kind in ON_THE_MAP and collector.pose is not None:
                x, y, _ = collector.pose
                self.events.add([begun.kind, round(x, 3), round(y, 3), begun.text])
        if not NAMES[name].latched:  # it comes again without a change
            last, _ = self._seen.get(part, (now, now))
            self._seen[part] = now, now + min(OLDEST, max(OLD, 3 * (now - last)))
        if name == 'odom':
            if collector.pose is None or collector.pose is pose:
                return  # it is no place
            self.track.add(collector.pose)
        self.parts.put(part, self._part(name, collector.newest[name], now))

    def _part(self, name: str, message: Any, now: float) -> Any:
        """Return the part that is made from a message."""
        match name:
            case 'odom' if pose := self.collector.pose:
                twist, known = message.twist.twist, message.pose.covariance
                return {
                    'x': round(pose.x, 4), 'y': round(pose.y, 4), 'yaw': round(pose.yaw, 4),
                    'speed': finite(twist.linear.x, 3), 'turn': finite(twist.angular.z, 3),
                    # Variances of x and y and what they share, and of the heading.
                    'covariance': [finite(known[place], 9) for place in (0, 1, 7, 35)]}
            case 'battery_state':
                return {
                    'part': finite(message.percentage, 3), 'voltage': finite(message.voltage, 2),
                    'current': finite(message.current, 3),
                    'minutes': self._minutes_left(message, now),
                    'temperature': finite(message.temperature, 0)}
            case 'mode':
                return {'actual': mode_name(message.mode, message.reason),
                        'wanted': mode_name(message.wanted), 'reason': message.reason}
            case 'charging':
                return {'state': charging_name(message.state), **flags(name, message)}
            case 'ir_omni':
                return {'code': message.character, 'name': message.name}
            case 'diagnostics':
                return {about: {'level': level_of(status), 'message': status.message,
                                'values': values_of(status)}
                        for about, status in message.items() if about not in REPEATED}
        return flags(name, message)

    def _minutes_left(self, battery: Any, now: float) -> int | None:
        """Return the minutes until empty, or while charging until full; None: not known."""
        charge, current = battery.charge, battery.current
        if not all(map(isfinite, (charge, battery.capacity, current))):
            return None
        # Plugged in or out: the average of both says nothing.
        kept = 0.0 if (current > 0) != (self._current > 0) else exp(
            (self._current_at - now) / SMOOTHING)
        self._current, self._current_at = kept * self._current + (1 - kept) * current, now
        if abs(self._current) < LEAST_CURRENT:
            return None
        left = battery.capacity - charge if self._current > 0 else charge
        minutes = round(60 * max(left / abs(self._current), 0.0))
        return minutes if minutes <= LONGEST_TIME else None

    def sample(self, now: float) -> None:
        """Add a sample to the charts when it is due; say what is old, and who is silent."""
        self.parts.put('old', [part for part, (_, until) in self._seen.items() if now > until])
        silent = now - self._seen.get('pose', (-inf, -inf))[0] > SILENT
        if self.parts.put('silent', silent) and self._seen:
            self.happened('error' if silent else '', 'the driver sends nothing' if silent
                          else 'the driver sends', now)
        if silent or now - self._sampled_at < SAMPLE_PERIOD:
            return
        self._sampled_at = now
        newest = self.collector.newest
        cliff, wall, battery = (newest.get(name) for name in ('cliff', 'wall', 'battery_state'))
        twist = newest['odom'].twist.twist
        self.samples.add([
            round(now, 2), finite(twist.linear.x, 3), finite(twist.angular.z, 3),
            None if battery is None else finite(battery.current, 3),
            *([None] * 4 if cliff is None else map(_signal, (
                cliff.left_signal, cliff.front_left_signal, cliff.front_right_signal,
                cliff.right_signal))),
            None if wall is None else _signal(wall.signal)])

    def forget(self) -> None:
        """Drop track and events: the odometry was reset."""
        self.resets += 1
        self.track.clear()
        self.events = NewestLog(MOST_EVENTS)

    def news(self, cursor: Cursor, now: float) -> tuple[str, Cursor]:
        """Return what a page has not been told yet, as JSON, and how far it is told then."""
        pieces = [f'"at":{now:.3f}', *(
            f'"{name}":{text}' for name, text in self.parts.since(cursor.changes).items())]
        anew = cursor.epoch != self.track.epoch
        if anew:
            pieces.append(f'"anew":{json.dumps(self.track.since(0))}')
        logs = {'events': self.events.since(0 if anew else cursor.events),
                'samples': self.samples.since(cursor.samples), 'log': self.log.since(cursor.log)}
        if not anew:
            logs['track'] = self.track.since(cursor.track)
        pieces += [f'"{name}":{json.dumps(entries)}' for name, entries in logs.items() if entries]
        told = Cursor(self.parts.changes, self.track.epoch, len(self.track), self.events.count,
                      self.samples.count, self.log.count)
        return f'{{"type":"news",{",".join(pieces)}}}', told
