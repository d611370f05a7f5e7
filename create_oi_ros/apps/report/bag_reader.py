# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Reads a bag once, from front to back, into a `Recording`.

Only thinned curves and changes of state are kept. A message is decoded only if it may hold
something new: a sensor topic repeats itself 20 times a second.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import hypot, inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TYPE_CHECKING

from ...oi import ChargingState, Mode
from ...robot import TOP_SPEED
from ...ros.bags import BagError, DamageError, definitions, guarded, reading
from ...ros.diagnostics import HARDWARE, LINK, PARAMETERS
from ...ros.messages import charging_name, mode_name
from ...ros.rotation import yaw_of
from .recording import Curve, Recording, Span, Spans
from .recovery import files_of, recover, UNFINISHED, unfinished

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

POINTS = 300_000
"""Points of a curve at most: all frames of an hour."""
GAP, SILENCE = 0.5, 2.0
"""Seconds without odometry, and without any message, that count as a gap."""
NEAR = 0.05
"""Metres by which the odometry may correct itself."""
SETTLING = 1.0
"""Seconds within which the number of a song that has just begun may still be corrected."""
BODY = slice(12, None)
"""Part of a serialized message after the stamp of its header."""
MODES = {mode.value: mode.name.capitalize() for mode in Mode}
CHARGING = {state.value: charging_name(state) for state in ChargingState
            if state is not ChargingState.NOT_CHARGING}
LEVELS = {1: 'warning', 2: 'error', 3: 'stale'}
OURS = 'create_oi_msgs/msg/'
Progress = Callable[[float], None]
"""Called with the part that is done, 0 to 1."""


class RecordingBuilder:
    """Builds a recording from messages, with a method for each type."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self._last_message: float | None = None
        self._last_odom: float | None = None
        self.adders: dict[str, Callable[[float, Any], None]] = {
            'nav_msgs/msg/Odometry': self._add_odom,
            'geometry_msgs/msg/Twist': self._add_twist,
            'geometry_msgs/msg/TwistStamped':
                lambda time, message: self._add_twist(time, message.twist),
            'sensor_msgs/msg/BatteryState': self._add_battery,
            'diagnostic_msgs/msg/DiagnosticArray': self._add_diagnostics,
            f'{OURS}Mode': self._add_mode,
            f'{OURS}Song': self._add_song,
            f'{OURS}Charging': self._add_charging,
            f'{OURS}Bumper': self._contacts('bumper', 'left', 'right'),
            f'{OURS}Cliff': self._contacts('cliff', 'left', 'front_left', 'front_right', 'right'),
            f'{OURS}WheelDrop': self._contacts('wheel drop', 'left', 'right', 'caster'),
            f'{OURS}Buttons': self._contacts('buttons', 'play', 'advance'),
            f'{OURS}Overcurrent': self._contacts(
                'overcurrent', 'left_wheel', 'right_wheel', 'driver_0', 'driver_1', 'driver_2'),
        }

    def note_time(self, time: float) -> None:
        """Note the time of a message; a long silence before it is a gap."""
        if self._last_message is not None and time - self._last_message > SILENCE:
            self._gap(self._last_message, time, 'nothing was recorded')
            self._last_odom = None
        self._last_message = time

    def needs_decoding(self, kind: str, time: float) -> bool:
        """Return whether to decode a message of this type; note gaps of the odometry."""
        if kind == 'nav_msgs/msg/Odometry':
            if self._last_odom is not None and time - self._last_odom > GAP:
                self._gap(self._last_odom, time, 'no odometry: the robot was not heard')
            self._last_odom = time
            return self.recording.odom.due(time)
        return not kind.startswith('geometry_msgs') or self.recording.commands.due(time)

    def finish(self) -> None:
        """Close all spans that are open at the end of the bag."""
        recording = self.recording
        for spans in (*recording.spans.values(), *recording.warnings.values()):
            spans.close(recording.seconds)
        if self._last_odom is not None and recording.seconds - self._last_odom > 2 * GAP:
            self._gap(self._last_odom, recording.seconds, 'no odometry up to the end')

    def _gap(self, start: float, end: float, text: str) -> None:
        self.recording.gaps.append(Span(start, text, end))

    def _add_odom(self, time: float, message: Any) -> None:
        pose, twist = message.pose.pose, message.twist.twist
        x, y, yaw = pose.position.x, pose.position.y, yaw_of(pose.orientation)
        self._look_for_jump(time, x, y)
        self.recording.odom.add(time, x, y, yaw, twist.linear.x, twist.angular.z)

    def _look_for_jump(self, time: float, x: float, y: float) -> None:
        """Note that the odometry goes on elsewhere: farther off than the robot can drive."""
        odom = self.recording.odom
        if not odom:
            return
        far = hypot(x - odom['x'][-1], y - odom['y'][-1])
        anew = x == y == 0 != far
        if anew or far > NEAR + 2 * TOP_SPEED * (time - odom.times[-1]):
            text = ('Odometry begins anew (reset_odometry, or the driver was restarted)'
                    if hypot(x, y) < NEAR else f'Odometry jumps by {far:.2f} m (reset_pose)')
            self.recording.jumps.append(Span(time, text, time))

    def _add_twist(self, time: float, message: Any) -> None:
        self.recording.commands.add(time, message.linear.x, message.angular.z)

    def _add_battery(self, time: float, message: Any) -> None:
        self.recording.battery.add(
            time, message.voltage, message.current, 100 * message.percentage)

    def _add_mode(self, time: float, message: Any) -> None:
        self.recording.spans['mode'].change(
            time, MODES.get(message.mode) or mode_name(message.mode, message.reason).lower(),
            message.reason)

    def _add_song(self, time: float, message: Any) -> None:
        spans = self.recording.spans['song']
        text = f'song {message.number}' if message.playing else ''
        begins = spans.all and time - spans.all[-1].start < SETTLING
        if text and begins and spans.all[-1].end == inf:
            spans.all[-1].text = text
        else:
            spans.change(time, text)

    def _add_charging(self, time: float, message: Any) -> None:
        self.recording.spans['charging'].change(time, CHARGING.get(message.state, ''))

    def _contacts(self, what: str, *names: str) -> Callable[[float, Any], None]:
        """Return a method for messages with these boolean fields."""
        spans = self.recording.spans[what]
        words = {name: name.replace('_', ' ') for name in names}
        return lambda time, message: spans.contact(
            time, [words[name] for name in names if getattr(message, name)])

    def _add_diagnostics(self, time: float, message: Any) -> None:
        prefix = f'{self.recording.robot}/'.lstrip('/')
        for status in message.status:
            node, _, subject = status.name.partition(': ')
            if node.startswith(prefix) and status.hardware_id.startswith(HARDWARE):
                self._add_status(time, subject, status)

    def _add_status(self, time: float, subject: str, status: Any) -> None:
        values = {each.key: each.value for each in status.values}
        if subject == PARAMETERS:
            self.recording.settings = values
        if subject == LINK:
            self.recording.link.add(time, *(
                _number(values.get(key)) for key in
                ('frames per second', 'damaged frames', 'garbage bytes')))
        level = LEVELS.get(status.level if isinstance(status.level, int) else status.level[0])
        self.recording.warnings.setdefault(subject, Spans()).change(
            time, f'{level}: {status.message}' if level else '')


def _number(text: str | None) -> float:
    try:
        return float(text or 'nan')
    except ValueError:
        return float('nan')


def read(path: Path, progress: Progress, robot: str | None = None) -> Recording:
    """Read a bag; BagError says why it cannot be read, or that a robot must be named."""
    with TemporaryDirectory(prefix='create_report-') as folder:
        files, damage = _readable(path, Path(folder))
        reader = _opened(files, path)
        try:
            recording = _read(reader, path, progress, robot)
        finally:
            reader.close()
    recording.damage = recording.damage or damage
    return recording


def _readable(path: Path, folder: Path) -> tuple[list[Path], str]:
    """Return files to open, unfinished ones recovered to a folder, and what is damaged."""
    files, damage = files_of(path), ''
    for place, file in enumerate(files):
        if file.is_file() and unfinished(file):
            damage, files[place] = UNFINISHED, folder / f'{place}.mcap'
            recover(file, files[place])
    return files, damage


def _opened(files: list[Path], path: Path) -> AnyReader:
    from rosbags.highlevel import AnyReader
    try:
        with reading():
            reader = AnyReader(files, default_typestore=definitions())
            reader.open()
    except DamageError as error:
        raise BagError(f'{path} cannot be read as a bag, it is damaged or something else: '
                       f'{error}') from error
    return reader


def _read(reader: AnyReader, path: Path, progress: Progress, robot: str | None) -> Recording:
    if not reader.message_count:
        raise BagError(f'{path} is empty: no message was recorded, or none was written yet '
                       'when the recorder was killed')
    names, robot = _wanted(reader.connections, path, robot)
    recording = _blank(reader, path, robot)
    builder = RecordingBuilder(recording)
    chosen = [each for each in _as_stored(reader) if each.topic in names]
    last = 0.0
    try:
        last = _read_messages(reader, chosen, builder, progress)
    except DamageError as error:
        if not recording.odom and not recording.spans['mode']:
            raise BagError(f'{path} is damaged: {error}') from error
        recording.damage = str(error)
    if not chosen or (last == 0.0 and not recording.odom and not recording.spans['mode']):
        raise BagError(f'{path} holds no message of this driver')
    builder.finish()
    return recording


def _as_stored(reader: AnyReader) -> list[Connection]:
    """
    Return the connections with the quality of service that stands in the files.

    rosbags yields the messages of connections that are equal to those of the files. In
    metadata.yaml `ros2 bag reindex` writes another depth, so that none is.
    """
    found = []
    for each in reader.connections:
        storages = getattr(each.owner, 'storages', ())  # only a folder has some
        kinds = [own.ext for storage in storages for own in storage.connections
                 if (own.topic, own.msgtype) == (each.topic, each.msgtype)]
        found += [each._replace(ext=ext) for place, ext in enumerate(kinds)
                  if ext not in kinds[:place]] or [each]
    return found


def _read_messages(
    reader: AnyReader, chosen: list[Connection], builder: RecordingBuilder, progress: Progress,
) -> float:
    """Add all messages; return the time of the last one."""
    before: dict[str, bytes] = {}
    began, seconds = reader.start_time, builder.recording.seconds
    time, shown = 0.0, 0.0
    for connection, stamp, raw in guarded(reader.messages(chosen)):
        time, kind = (stamp - began) / 1e9, connection.msgtype
        builder.note_time(time)
        builder.recording.heard.add(TOPICS.get(kind, 'diagnostics'))
        if time > shown:
            progress(time / seconds if seconds else 1.0)
            shown = time + seconds / 100
        if not builder.needs_decoding(kind, time):
            continue
        if kind.startswith(OURS):
            body = bytes(raw[BODY])
            if before.get(connection.topic) == body:
                continue
            before[connection.topic] = body
        with reading():
            message = reader.deserialize(raw, kind)
        builder.adders[kind](time, message)
    progress(1.0)
    return time


def _blank(reader: AnyReader, path: Path, robot: str) -> Recording:
    seconds = max(0.0, (reader.end_time - reader.start_time) / 1e9)
    spacing = seconds / POINTS
    storage = 'MCAP' if next(path.glob('*.mcap'), path).suffix == '.mcap' else 'SQLite'
    return Recording(
        path.resolve().name, storage, reader.start_time / 1e9, seconds, reader.message_count,
        odom=Curve('x', 'y', 'yaw', 'speed', 'turn', spacing=spacing),
        commands=Curve('speed', 'turn', spacing=spacing),
        battery=Curve('volts', 'amperes', 'charge', spacing=spacing),
        link=Curve('frames', 'damaged', 'garbage'), robot=robot)


TOPICS = {
    'nav_msgs/msg/Odometry': 'odom', 'geometry_msgs/msg/Twist': 'cmd_vel',
    'geometry_msgs/msg/TwistStamped': 'cmd_vel', 'sensor_msgs/msg/BatteryState': 'battery_state',
    **{f'{OURS}{kind}': name for kind, name in {
        'Mode': 'mode', 'Song': 'song', 'Charging': 'charging', 'Bumper': 'bumper',
        'Cliff': 'cliff', 'WheelDrop': 'wheel_drop', 'Buttons': 'buttons',
        'Overcurrent': 'overcurrent'}.items()}}


def _wanted(
    connections: list[Connection], path: Path, robot: str | None,
) -> tuple[set[str], str]:
    """Return the topics of one robot, and its namespace."""
    found: dict[str, set[str]] = {}
    diagnostics = {each.topic for each in connections
                   if each.msgtype == 'diagnostic_msgs/msg/DiagnosticArray'}
    for each in connections:
        space, _, name = each.topic.rpartition('/')
        if TOPICS.get(each.msgtype) == name:
            found.setdefault(space.strip('/'), set()).add(each.topic)
    robots = {space: topics for space, topics in found.items()
              if {'odom', 'mode'} & {topic.rpartition('/')[2] for topic in topics}}
    if not robots:
        topics = ', '.join(sorted(each.topic for each in connections)[:6]) or 'none'
        raise BagError(f'{path} has neither `odom` nor `mode` of this driver: its topics are '
                       f'{topics}')
    if robot is None and len(robots) > 1:
        raise BagError(f'{path} holds several robots, name one with --robot: '
                       f'{_listed(robots)}')
    chosen = next(iter(robots)) if robot is None else robot.strip('/')
    if chosen not in robots:
        raise BagError(f'{path} has no robot {chosen or "/"}: it has {_listed(robots)}')
    return robots[chosen] | diagnostics, chosen


def _listed(robots: Iterable[str]) -> str:
    """Return namespaces as --robot takes them; / is a robot without one."""
    return ', '.join(space or '/' for space in sorted(robots))
