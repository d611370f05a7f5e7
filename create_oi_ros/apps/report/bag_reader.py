# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Reads a bag once, from front to back, into a `Recording`.

Only curves and changes of state are kept. A sensor topic repeats itself 20 times a second: such a
message is not decoded.
"""

from collections.abc import Callable, Collection, Iterable
from math import hypot, inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore

from ...oi import ChargingState, Mode
from ...robot import TOP_SPEED
from ...ros.bags import definitions
from ...ros.diagnostics import HARDWARE, LINK, PARAMETERS
from ...ros.messages import charging_name, mode_name, yaw_of
from ...ros.topics import CMD_VEL, PUBLISHED, type_name
from .bag_files import BagError, BagFiles, DamageError, reading, Topic
from .recording import Recording, Span, Spans, TOPICS

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
OURS, DIAGNOSTICS = 'create_oi_msgs/msg/', 'diagnostic_msgs/msg/DiagnosticArray'
TYPES = {type_name(topic.type).replace('/', '/msg/'): topic.name for topic in PUBLISHED
         if topic.name in TOPICS} | dict.fromkeys(
             ('geometry_msgs/msg/Twist', 'geometry_msgs/msg/TwistStamped'), CMD_VEL)
"""The name of the topic that has a type."""
Progress = Callable[[float], None]
"""Called with the part that is done, 0 to 1."""


class RecordingBuilder:
    """Builds a recording from messages."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self._last_message: float | None = None
        self._last_odom: float | None = None
        self._stamp = 0.0

    def add(self, topic: str, time: float, message: Any) -> None:
        """Add a message of one of TOPICS."""
        recording = self.recording
        match topic:
            case 'odom':
                self._add_odom(time, message)
            case 'cmd_vel':
                twist = getattr(message, 'twist', message)  # of a TwistStamped
                recording.commands.add(time, twist.linear.x, twist.angular.z)
            case 'battery_state':
                recording.battery.add(
                    time, message.voltage, message.current, 100 * message.percentage)
            case 'diagnostics':
                self._add_diagnostics(time, message)
            case 'mode':
                name = mode_name(message.mode, message.reason).lower()
                recording.spans['mode'].change(
                    time, MODES.get(message.mode) or name, message.reason)
            case 'song':
                self._add_song(time, message)
            case 'charging':
                recording.spans['charging'].change(time, CHARGING.get(message.state, ''))
            case _:
                recording.spans[topic.replace('_', ' ')].contact(time, [
                    name.replace('_', ' ') for name in message.__dataclass_fields__
                    if getattr(message, name) is True])

    def note_time(self, time: float) -> None:
        """Note the time of a message; a long silence before it is a gap."""
        if self._last_message is not None and time - self._last_message > SILENCE:
            self._gap(self._last_message, time, 'nothing was recorded')
            self._last_odom = None
        self._last_message = time

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
        if self._last_odom is not None and time - self._last_odom > GAP:
            self._gap(self._last_odom, time, 'no odometry: the robot was not heard')
        self._last_odom = time
        pose, twist = message.pose.pose, message.twist.twist
        x, y, yaw = pose.position.x, pose.position.y, yaw_of(pose.orientation)
        stamp = message.header.stamp
        self._look_for_jump(time, stamp.sec + stamp.nanosec / 1e9, x, y)
        self.recording.odom.add(time, x, y, yaw, twist.linear.x, twist.angular.z)

    def _look_for_jump(self, time: float, stamp: float, x: float, y: float) -> None:
        """
        Note that the odometry goes on elsewhere: farther off than the robot can drive.

        A recorder that was held up gets several messages at once: their stamps are apart.
        """
        odom, before, self._stamp = self.recording.odom, self._stamp, stamp
        if not odom:
            return
        far = hypot(x - odom['x'][-1], y - odom['y'][-1])
        anew = x == y == 0 != far
        if anew or far > NEAR + 2 * TOP_SPEED * max(time - odom.times[-1], stamp - before):
            text = ('Odometry begins anew (reset_odometry, or the driver was restarted)'
                    if hypot(x, y) < NEAR else f'Odometry jumps by {far:.2f} m (reset_pose)')
            self.recording.jumps.append(Span(time, text, time))

    def _add_song(self, time: float, message: Any) -> None:
        spans = self.recording.spans['song']
        text = f'song {message.number}' if message.playing else ''
        begins = spans.all and time - spans.all[-1].start < SETTLING
        if text and begins and spans.all[-1].end == inf:
            spans.all[-1].text = text
        else:
            spans.change(time, text)

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
        files = BagFiles(path, Path(folder))
        topics, robot = _wanted(files, path, robot)
        recording = Recording(
            path.resolve().name, files.storage, files.start / 1e9,
            (files.end - files.start) / 1e9, files.counts.total(), robot,
            undefined=sorted(topic.name for topic in files.counts if topic.encoding == 'unknown'))
        recording.heard = set(map(base_name, topics))
        builder = RecordingBuilder(recording)
        try:
            _read_messages(files, topics, builder, progress)
        except DamageError as error:
            files.faults.append(str(error))
        builder.finish()
    recording.faults = files.faults
    if not recording.odom and not any(map(len, recording.spans.values())):
        raise BagError(f'{path} is damaged: {"; ".join(files.faults)}' if files.faults else
                       f'{path} holds no message of this driver')
    return recording


def _read_messages(
    files: BagFiles, topics: Collection[Topic], builder: RecordingBuilder, progress: Progress,
) -> None:
    """Add all messages of some topics; DamageError: one cannot be read."""
    decoders = {topic: _decoder(topic) for topic in topics}
    before: dict[str, bytes] = {}
    seconds, shown = builder.recording.seconds, 0.0
    for topic, stamp, raw in files.messages(topics):
        time = (stamp - files.start) / 1e9
        builder.note_time(time)
        if time > shown:
            progress(time / seconds if seconds else 1.0)
            shown = time + seconds / 100
        if topic.type.startswith(OURS):
            body = raw[BODY]
            if before.get(topic.name) == body:
                continue
            before[topic.name] = body
        with reading():
            message = decoders[topic].deserialize_cdr(raw, topic.type)
        builder.add(base_name(topic), time, message)
    progress(1.0)


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
        raise BagError(f'{path} has neither `odom` nor `mode` of this driver: its topics are '
                       f'{names}')
    if robot is None and len(robots) > 1:
        raise BagError(f'{path} holds several robots, name one with --robot: '
                       f'{_listed(robots)}')
    chosen = next(iter(robots)) if robot is None else robot.strip('/')
    if chosen not in robots:
        raise BagError(f'{path} has no robot {chosen or "/"}: it has {_listed(robots)}')
    return robots[chosen] | {topic for topic in files.counts if topic.type == DIAGNOSTICS}, chosen


def _listed(robots: Iterable[str]) -> str:
    """Return namespaces as --robot takes them; / is a robot without one."""
    return ', '.join(space or '/' for space in sorted(robots))
