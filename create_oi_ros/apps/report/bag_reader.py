"""
A bag, read once from front to back.

Nothing is kept but curves with a bounded number of points and the changes of state. A message is
decoded only where it may tell something new: a sensor topic repeats itself 20 times a second.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TYPE_CHECKING

from ...ros.bags import BagError, DamageError, definitions, guarded, reading
from ...ros.rotation import yaw_of
from .recording import Curve, Recording, Span, Spans
from .rescue import files_of, rescue, UNFINISHED, unfinished

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

POINTS = 20_000
"""Of a curve; more than a page can show."""
GAP, SILENCE = 0.5, 2.0
"""Seconds without odometry, and without anything, that are a gap."""
SETTLING = 1.0
"""Seconds by which the number of a song may come later than its beginning."""
BODY = slice(12, None)
"""Of a serialized message whose first field is a header: what follows its stamp."""
MODES = {0: 'Off', 1: 'Passive', 2: 'Safe', 3: 'Full', 255: 'no robot'}
CHARGING = {1: 'reconditioning', 2: 'full charging', 3: 'trickle', 4: 'waiting', 5: 'fault'}
LEVELS = {1: 'warning', 2: 'error', 3: 'stale'}
OURS = 'create_oi_msgs/msg/'
Progress = Callable[[float], None]
"""Takes the part that is done, 0 to 1."""


class Taker:
    """Takes messages in, a method for each topic."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self._heard: float | None = None
        self._odom: float | None = None
        self.takes: dict[str, Callable[[float, Any], None]] = {
            'nav_msgs/msg/Odometry': self._take_odom,
            'geometry_msgs/msg/Twist': self._take_twist,
            'geometry_msgs/msg/TwistStamped':
                lambda time, message: self._take_twist(time, message.twist),
            'sensor_msgs/msg/BatteryState': self._take_battery,
            'diagnostic_msgs/msg/DiagnosticArray': self._take_diagnostics,
            f'{OURS}Mode': self._take_mode,
            f'{OURS}Song': self._take_song,
            f'{OURS}Charging': self._take_charging,
            f'{OURS}Bumper': self._touch('bumper', 'left', 'right'),
            f'{OURS}Cliff': self._touch('cliff', 'left', 'front_left', 'front_right', 'right'),
            f'{OURS}WheelDrop': self._touch('wheel drop', 'left', 'right', 'caster'),
            f'{OURS}Buttons': self._touch('buttons', 'play', 'advance'),
            f'{OURS}Overcurrent': self._touch(
                'overcurrent', 'left_wheel', 'right_wheel', 'driver_0', 'driver_1', 'driver_2'),
        }

    def heard(self, time: float) -> None:
        """Note that the recorder was at work."""
        if self._heard is not None and time - self._heard > SILENCE:
            self._gap(self._heard, time, 'nothing was recorded')
            self._odom = None
        self._heard = time

    def wants(self, kind: str, time: float) -> bool:
        """Tell whether a message of a kind need be decoded; odometry is looked at for gaps."""
        if kind == 'nav_msgs/msg/Odometry':
            if self._odom is not None and time - self._odom > GAP:
                self._gap(self._odom, time, 'no odometry: the robot was not heard')
            self._odom = time
            return self.recording.odom.due(time)
        return not kind.startswith('geometry_msgs') or self.recording.commands.due(time)

    def finish(self) -> None:
        """End what is still open at the end of the bag."""
        recording = self.recording
        for spans in (*recording.spans.values(), *recording.complaints.values()):
            spans.close(recording.seconds)
        if self._odom is not None and recording.seconds - self._odom > 2 * GAP:
            self._gap(self._odom, recording.seconds, 'no odometry up to the end')

    def _gap(self, start: float, end: float, text: str) -> None:
        self.recording.gaps.append(Span(start, text, end))

    def _take_odom(self, time: float, message: Any) -> None:
        pose, twist = message.pose.pose, message.twist.twist
        self.recording.odom.add(
            time, pose.position.x, pose.position.y, yaw_of(pose.orientation),
            twist.linear.x, twist.angular.z)

    def _take_twist(self, time: float, message: Any) -> None:
        self.recording.commands.add(time, message.linear.x, message.angular.z)

    def _take_battery(self, time: float, message: Any) -> None:
        self.recording.battery.add(
            time, message.voltage, message.current, 100 * message.percentage)

    def _take_mode(self, time: float, message: Any) -> None:
        self.recording.spans['mode'].become(
            time, MODES.get(message.mode, str(message.mode)), message.reason)

    def _take_song(self, time: float, message: Any) -> None:
        spans = self.recording.spans['song']
        text = f'song {message.number}' if message.playing else ''
        begins = spans.all and time - spans.all[-1].start < SETTLING
        if text and begins and spans.all[-1].end == inf:
            spans.all[-1].text = text
        else:
            spans.become(time, text)

    def _take_charging(self, time: float, message: Any) -> None:
        self.recording.spans['charging'].become(time, CHARGING.get(message.state, ''))

    def _touch(self, what: str, *names: str) -> Callable[[float, Any], None]:
        spans = self.recording.spans[what]
        said = {name: name.replace('_', ' ') for name in names}
        return lambda time, message: spans.touch(
            time, [said[name] for name in names if getattr(message, name)])

    def _take_diagnostics(self, time: float, message: Any) -> None:
        prefix = f'{self.recording.robot}/'.lstrip('/')
        for status in message.status:
            node, _, subject = status.name.partition(': ')
            if node.startswith(prefix) and status.hardware_id == 'iRobot Create':
                self._take_status(time, subject, status)

    def _take_status(self, time: float, subject: str, status: Any) -> None:
        values = {each.key: each.value for each in status.values}
        if subject == 'parameters':
            self.recording.settings = values
        if subject == 'serial link':
            self.recording.link.add(time, *(
                _number(values.get(key)) for key in
                ('frames per second', 'damaged frames', 'garbage bytes')))
        level = LEVELS.get(status.level if isinstance(status.level, int) else status.level[0])
        self.recording.complaints.setdefault(subject, Spans()).become(
            time, f'{level}: {status.message}' if level else '')


def _number(text: str | None) -> float:
    try:
        return float(text or 'nan')
    except ValueError:
        return float('nan')


def read(path: Path, progress: Progress, robot: str | None = None) -> Recording:
    """Read a bag; BagError says in a sentence why that cannot be, or whose bag it is."""
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
    """Return files that can be opened, copied to a folder where that is needed, and why."""
    files, damage = files_of(path), ''
    for place, file in enumerate(files):
        if file.is_file() and unfinished(file):
            damage, files[place] = UNFINISHED, folder / f'{place}.mcap'
            rescue(file, files[place])
    return files, damage


def _opened(files: list[Path], path: Path) -> AnyReader:
    from rosbags.highlevel import AnyReader
    try:
        with reading():
            reader = AnyReader(files, default_typestore=definitions())
            reader.open()
    except DamageError as error:
        raise BagError(f'{path} cannot be read as a bag, it is damaged or is something else: '
                       f'{error}') from error
    return reader


def _read(reader: AnyReader, path: Path, progress: Progress, robot: str | None) -> Recording:
    if not reader.message_count:
        raise BagError(f'{path} is empty: nothing was recorded, or nothing was written down yet '
                       'when the recorder was killed')
    names, robot = _wanted(reader.connections, path, robot)
    recording = _blank(reader, path, robot)
    taker = Taker(recording)
    chosen = [each for each in reader.connections if each.topic in names]
    last = 0.0
    try:
        last = _take_all(reader, chosen, taker, progress)
    except DamageError as error:
        if not recording.odom and not recording.spans['mode']:
            raise BagError(f'{path} is damaged: {error}') from error
        recording.damage = str(error)
    if not chosen or (last == 0.0 and not recording.odom and not recording.spans['mode']):
        raise BagError(f'{path} holds no message of this driver')
    taker.finish()
    return recording


def _take_all(
    reader: AnyReader, chosen: list[Connection], taker: Taker, progress: Progress,
) -> float:
    """Take all messages in; return the time of the last."""
    before: dict[str, bytes] = {}
    began, seconds = reader.start_time, taker.recording.seconds
    time, shown = 0.0, 0.0
    for connection, stamp, raw in guarded(reader.messages(chosen)):
        time, kind = (stamp - began) / 1e9, connection.msgtype
        taker.heard(time)
        if time > shown:
            progress(time / seconds if seconds else 1.0)
            shown = time + seconds / 100
        if not taker.wants(kind, time):
            continue
        if kind.startswith(OURS):
            body = bytes(raw[BODY])
            if before.get(connection.topic) == body:
                continue
            before[connection.topic] = body
        with reading():
            message = reader.deserialize(raw, kind)
        taker.takes[kind](time, message)
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
        raise BagError(f'{path} tells of several robots, name one with --robot: '
                       f'{", ".join(sorted(robots))}')
    chosen = next(iter(robots)) if robot is None else robot.strip('/')
    if chosen not in robots:
        raise BagError(f'{path} has no robot {chosen}: there is {", ".join(sorted(robots))}')
    return robots[chosen] | diagnostics, chosen
