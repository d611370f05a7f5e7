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
from math import exp, hypot, inf, isfinite, remainder, tau
from typing import Any, NamedTuple

from create_oi_msgs import msg
from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from ...ros.diagnostics import PARAMETERS
from ...ros.messages import charging_name, mode_name, yaw_of

Json = Any
PARTS: Mapping[type, str] = {
    Odometry: 'pose', BatteryState: 'battery', msg.Mode: 'mode', msg.Charging: 'charging',
    msg.Bumper: 'bump', msg.Cliff: 'cliff', msg.WheelDrop: 'drop', msg.Wall: 'wall',
    msg.Buttons: 'buttons', msg.Overcurrent: 'overcurrent', msg.Song: 'song',
    msg.IrOmni: 'infrared'}
"""Messages that `LiveRobot.update` takes, and the parts that are made from them."""
HAZARDS = {'bump': 'bumper', 'cliff': 'cliff', 'drop': 'wheel drop'}
"""Parts whose flags are events on the map, and their names for people."""
REPEATED = ('pose', 'battery', 'wall', *HAZARDS)
"""Parts whose messages come again without a change."""
FARTHEST = 1e6
"""Metres from the origin beyond which a place is wrong and is not shown."""
SILENT = 1.5
"""Seconds without odometry after which the driver counts as silent."""
OLD, OLDEST = 3.5, 30.0
"""Seconds after which a value is old that should come again: at least, and at most, where three
times its last interval lies between."""
NO_NEWS = ('mode', 'safety', PARAMETERS)
"""Statuses that repeat what topics say, or never change."""

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

SLACK, FASTEST = 0.1, 1.0
"""Metres and m/s; a longer step means that the odometry was reset."""
TURN_SLACK, FASTEST_TURN = 0.3, 5.0
"""The same for the heading: radians and rad/s."""


def finite(value: float, digits: int) -> float | None:
    """Return a rounded number; None, which JSON can say, if it is infinite or no number."""
    return round(value, digits) if isfinite(value) else None


def _signal(strength: int) -> int | None:
    return None if strength == msg.Wall.SIGNAL_UNKNOWN else strength


def flags(message: Any) -> dict[str, bool]:
    """Return the booleans of a message."""
    return {name: getattr(message, name)
            for name, kind in message.get_fields_and_field_types().items() if kind == 'boolean'}


class Parts:
    """Pieces of JSON by name, each with the number of its last change."""

    def __init__(self) -> None:
        self._parts: dict[str, tuple[int, str]] = {}
        self.changes = 0
        """Number of the last change."""

    def put(self, name: str, value: Json) -> bool:
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


class BatteryTime:
    """Averages the current, and divides the charge by it."""

    def __init__(self) -> None:
        self._current, self._at = 0.0, -inf

    def left(self, charge: float, capacity: float, current: float, now: float) -> int | None:
        """Return the minutes until empty, or while charging until full; None: not known."""
        if not all(map(isfinite, (charge, capacity, current))):
            return None
        kept = exp(-(now - self._at) / SMOOTHING)
        # Plugged in or out: the average of both says nothing.
        if (current > 0) != (self._current > 0):
            kept = 0.0
        self._current, self._at = kept * self._current + (1 - kept) * current, now
        if abs(self._current) < LEAST_CURRENT:
            return None
        hours = (capacity - charge if self._current > 0 else charge) / abs(self._current)
        minutes = round(60 * max(hours, 0.0))
        return minutes if minutes <= LONGEST_TIME else None


class FlatPose(NamedTuple):
    """A pose on the floor: metres and radians."""

    x: float
    y: float
    yaw: float

    def follows(self, last: FlatPose, seconds: float) -> bool:
        """Return whether a robot can come here from its last pose in this time."""
        moved = hypot(self.x - last.x, self.y - last.y)
        turned = abs(remainder(self.yaw - last.yaw, tau))
        return moved <= SLACK + FASTEST * seconds and turned <= TURN_SLACK + FASTEST_TURN * seconds


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
        new = min(self.count - count, len(self._kept))
        return [self._kept[place] for place in range(len(self._kept) - new, len(self._kept))]

    def clear(self) -> None:
        """Drop all entries; their numbers are not used again."""
        self._kept.clear()


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

    def __init__(self) -> None:
        self.parts = Parts()
        self.track = TrackLog()
        self.events = NewestLog(MOST_EVENTS)
        self.samples = NewestLog(round(CHART_SECONDS / SAMPLE_PERIOD))
        self.log = NewestLog(MOST_LOGGED)
        """What happened: when, how bad ('', warn or error), and what."""
        self._battery = BatteryTime()
        self._newest: dict[str, Any] = {}
        self._touched: dict[str, bool] = {}
        self._levels: dict[str, int] = {}
        self.resets = 0
        """How often the odometry has begun anew."""
        self._seen: dict[str, tuple[float, float]] = {}
        """When a part that comes again came last, and until when it is not old."""
        self.pose: FlatPose | None = None
        """The newest pose by the odometry."""
        self._heard_at, self._moved_at, self._sampled_at = -inf, -inf, -inf

    def happened(self, level: str, text: str, now: float) -> None:
        """Add an entry to what happened."""
        self.log.add([round(now, 2), level, text])

    def _see(self, part: str, now: float) -> None:
        last, _ = self._seen.get(part, (now, now))
        self._seen[part] = now, now + min(OLDEST, max(OLD, 3 * (now - last)))

    def update(self, message: Any, now: float) -> None:
        """Take a message of the driver."""
        part = PARTS[type(message)]
        self._newest[part] = message
        if part in REPEATED:
            self._see(part, now)
        match message:
            case Odometry():
                self._heard_at = now
                self._move(message, now)
            case BatteryState():
                self.parts.put(part, {
                    'part': finite(message.percentage, 3), 'voltage': finite(message.voltage, 2),
                    'current': finite(message.current, 3),
                    'minutes': self._battery.left(
                        message.charge, message.capacity, message.current, now),
                    'temperature': finite(message.temperature, 0)})
            case msg.Mode():
                self._change_mode(message, now)
            case msg.Charging():
                self.parts.put(part, {'state': charging_name(message.state), **flags(message)})
            case msg.IrOmni():
                self.parts.put(part, {'code': message.character, 'name': message.name})
            case _:
                self.parts.put(part, flags(message))
                if part in HAZARDS:
                    self._remember(part, flags(message), now)

    def _change_mode(self, message: msg.Mode, now: float) -> None:
        actual, wanted = mode_name(message.mode, message.reason), mode_name(message.wanted)
        if self.parts.put('mode', {
                'actual': actual, 'wanted': wanted, 'reason': message.reason}):
            why = f': {message.reason}' if message.reason else ''
            self.happened('' if actual == wanted else 'warn', f'mode {actual}{why}', now)

    def diagnose(self, statuses: Mapping[str, DiagnosticStatus], now: float) -> None:
        """Take the statuses of the driver, by their names without the node's name."""
        self._see('diagnostics', now)
        part = {name: {
            'level': int.from_bytes(status.level, 'little'), 'message': status.message,
            'values': {each.key: each.value for each in status.values}}
            for name, status in statuses.items() if name not in NO_NEWS}
        for name, told in part.items():
            level = told['level']
            if level != self._levels.get(name, 0):
                self.happened(('', 'warn')[level] if level < 2 else 'error',
                              f'{name}: {told["message"]}', now)
            self._levels[name] = level
        self.parts.put('diagnostics', part)

    def _move(self, odom: Odometry, now: float) -> None:
        pose, twist, known = odom.pose.pose, odom.twist.twist, odom.pose.covariance
        x, y, yaw = pose.position.x, pose.position.y, yaw_of(pose.orientation)
        if not (hypot(x, y) <= FARTHEST and isfinite(yaw)):  # also when one is no number
            return
        last, self.pose = self.pose, FlatPose(x, y, yaw)
        if last is not None and not self.pose.follows(last, now - self._moved_at):
            self.forget()
        self._moved_at = now
        self.track.add(self.pose)
        self.parts.put('pose', {
            'x': round(x, 4), 'y': round(y, 4), 'yaw': round(yaw, 4),
            'speed': finite(twist.linear.x, 3), 'turn': finite(twist.angular.z, 3),
            # Variances of x and y and what they share, and of the heading.
            'covariance': [finite(known[place], 9) for place in (0, 1, 7, 35)]})

    def _remember(self, kind: str, sides: Mapping[str, bool], now: float) -> None:
        """Add an event where something is touched that was free before."""
        touched = ' and '.join(side for side, on in sides.items() if on).replace('_', ' ')
        if touched and not self._touched.get(kind):
            self.happened('warn', f'{HAZARDS[kind]} {touched}', now)
            if self.pose is not None:
                self.events.add([
                    HAZARDS[kind], round(self.pose.x, 3), round(self.pose.y, 3), touched])
        self._touched[kind] = bool(touched)

    def sample(self, now: float) -> None:
        """Add a sample to the charts when it is due; say what is old, and who is silent."""
        self.parts.put('old', [part for part, (_, until) in self._seen.items() if now > until])
        silent = now - self._heard_at > SILENT
        if self.parts.put('silent', silent) and self._seen:
            self.happened('error' if silent else '', 'the driver sends nothing' if silent
                          else 'the driver sends', now)
        if silent or now - self._sampled_at < SAMPLE_PERIOD:
            return
        self._sampled_at = now
        cliff, wall = self._newest.get('cliff'), self._newest.get('wall')
        twist, battery = self._newest['pose'].twist.twist, self._newest.get('battery')
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
        self.events.clear()

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
