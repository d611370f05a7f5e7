# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Reads a bag once, from front to back, into a `Recording`.

Only curves and changes of state are kept. A sensor topic repeats itself 20 times a second: such a
message is not decoded.
"""

from collections.abc import Callable, Collection, Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from rosbags.typesys.store import Typestore

from ...ros.bags import definitions, full_name
from ...ros.collector import Collector
from ...ros.topics import CMD_VEL, PUBLISHED
from ...ros.velocity import COMMANDS
from .bag_files import BagError, BagFiles, DamageError, reading, Topic
from .recording import Recording, TOPICS

BODY = slice(12, None)
"""Part of a serialized message after the stamp of its header."""
OURS, DIAGNOSTICS = 'create_oi_msgs/msg/', 'diagnostic_msgs/msg/DiagnosticArray'
TYPES = {full_name(topic.type): topic.name for topic in PUBLISHED
         if topic.name in TOPICS} | dict.fromkeys(COMMANDS, CMD_VEL)
"""The name of the topic that has a type."""
Progress = Callable[[float], None]
"""Called with the part that is done, 0 to 1."""


def read(path: Path, progress: Progress, robot: str | None = None) -> Recording:
    """Read a bag; BagError says why it cannot be read, or that a robot must be named."""
    with TemporaryDirectory(prefix='create_report-') as folder:
        files = BagFiles(path, Path(folder))
        topics, robot = _wanted(files, path, robot)
        recording = Recording(
            path.resolve().name, files.storage, files.start / 1e9,
            (files.end - files.start) / 1e9, files.counts.total(), robot,
            undefined=sorted(topic.name for topic in files.counts if topic.encoding == 'unknown'),
            events=Collector(robot))
        recording.heard = set(map(base_name, topics))
        try:
            _read_messages(files, topics, recording, progress)
        except DamageError as error:
            files.faults.append(str(error))
        recording.finish()
    recording.faults = files.faults
    if not recording.odom and not any(map(len, recording.events.spans.values())):
        raise BagError(f'{path} is damaged: {"; ".join(files.faults)}' if files.faults else
                       f'{path} holds no message of this driver')
    return recording


def _read_messages(
    files: BagFiles, topics: Collection[Topic], recording: Recording, progress: Progress,
) -> None:
    """Add all messages of some topics; DamageError: one cannot be read."""
    decoders = {topic: _decoder(topic) for topic in topics}
    before: dict[str, bytes] = {}
    seconds, shown = recording.seconds, 0.0
    for topic, stamp, raw in files.messages(topics):
        time = (stamp - files.start) / 1e9
        recording.note_time(time)
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
        recording.add(base_name(topic), time, message)
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
