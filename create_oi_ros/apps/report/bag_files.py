# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Reads the messages in the files of a bag, in whatever state its recorder left them.

A file is read from its front to its end or its first damage, never by its index. So a file that
has none (rosbag2's `fastwrite`, a recorder that was killed) is read like any other. It is read
twice: first to learn topics, times and order, then for the messages.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import closing, contextmanager
from heapq import heappop, heappush
from pathlib import Path
import re
import shutil
import sqlite3
import struct
import sys
from typing import BinaryIO, NamedTuple

from mcap.exceptions import EndOfFile, McapError, RecordLengthLimitExceeded
from mcap.records import Channel, DataEnd, McapRecord, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader
from rosbags.serde import SerdeError
from rosbags.typesys import TypesysError
import yaml
import zstandard

from ...ros.programs import UserError

MCAP, SQLITE, ZSTD = b'\x89MCAP0\r\n', b'SQLite format 3\0', b'\x28\xb5\x2f\xfd'
"""First bytes of the files, and of what is compressed."""
UNFINISHED = 'its recorder did not close it, so the last seconds may be missing'
FAULTS = (
    AssertionError, AttributeError, EOFError, LookupError, MemoryError, OSError, OverflowError,
    RuntimeError, TypeError, ValueError, struct.error,
    McapError, SerdeError, TypesysError, sqlite3.Error, yaml.YAMLError, zstandard.ZstdError)
"""What Python and the libraries raise when damaged bytes are read."""


class DamageError(Exception):
    """The content of a bag cannot be read; the message is that of the library."""


@contextmanager
def reading() -> Iterator[None]:
    """Turn what a broken file causes into DamageError."""
    try:
        yield
    except FAULTS as error:
        raise DamageError(
            ' '.join(str(error).split())[:200] or type(error).__name__) from error


class Topic(NamedTuple):
    """A topic of a bag, with the definition of its type, which may be empty."""

    name: str
    type: str
    encoding: str = ''
    definition: str = ''


Message = tuple[Topic, int, bytes]
"""A message: its topic, its time in ns, what was serialized."""


class BagFiles:
    """The messages of a bag; UserError says why it has none."""

    def __init__(self, path: Path, folder: Path) -> None:
        """Look through all files; what has to be unpacked or repaired goes into a folder."""
        self.faults: list[str] = []
        """What is not whole, each in words."""
        self._folder = folder
        self._sources = [self._readable(file) for file in self._files(path)]
        self.counts: Counter[Topic] = Counter()
        """Messages of each topic."""
        self.start, self.end, self._late = sys.maxsize, 0, 0
        for topic, time, _ in self._stored():
            self.counts[topic] += 1
            self.start, self.end = min(self.start, time), max(self.end, time)
            self._late = max(self._late, self.end - time)
        if not self.counts:
            raise UserError(
                f'{path} is empty: no message was recorded, or none was written yet when the '
                'recorder was killed' if set(self.faults) <= {UNFINISHED} else
                f'{path} cannot be read as a bag, it is damaged or something else: '
                f'{"; ".join(self.faults)}')

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """Yield the messages of some topics, in the order of their times; DamageError: no more."""
        waiting: list[tuple[int, int, Topic, bytes]] = []
        newest = 0
        for place, (topic, time, raw) in enumerate(self._stored()):
            newest = max(newest, time)
            if topic in topics:
                heappush(waiting, (time, place, topic, raw))
            while waiting and waiting[0][0] <= newest - self._late:
                yield self._whole(*heappop(waiting))
        yield from (self._whole(*each) for each in sorted(waiting))

    def _whole(self, time: int, _place: int, topic: Topic, raw: bytes) -> Message:
        with reading():
            return topic, time, zstandard.decompress(raw) if raw.startswith(ZSTD) else raw

    def _files(self, path: Path) -> list[Path]:
        """Return the files of a bag, the oldest first."""
        if not path.exists():
            raise UserError(f'there is no {path}')
        if path.is_file():
            return [path]
        found = [each for each in path.iterdir() if each.suffix in ('.mcap', '.db3', '.zstd')]
        if not found:
            raise UserError(f'{path} is no bag: it holds neither .mcap nor .db3 files')
        try:
            with reading():
                described = yaml.safe_load((path / 'metadata.yaml').read_text())
                names = {Path(name).name for name in described[
                    'rosbag2_bagfile_information']['relative_file_paths']}
            self.faults += [f'{name} is missing' for name in sorted(
                names - {each.name for each in found})]
        except DamageError:  # expected: a recorder writes it when it closes the bag
            self.faults += [UNFINISHED] if any(each.suffix == '.db3' for each in found) else []
        # A recorder that is killed while it compresses leaves both files, one in part.
        packed = {each for each in found
                  if each.suffix == '.zstd' and each.with_suffix('') in found}
        return sorted(set(found) - packed, key=lambda each: [
            int(part) if part.isdigit() else part for part in re.split(r'(\d+)', each.name)])

    def _readable(self, file: Path) -> Path:
        """Return a file without compression, or a copy with what its recorder left in a log."""
        if file.suffix == '.zstd':
            target = self._folder / file.stem
            try:
                with zstandard.open(file) as packed, target.open('wb') as copy, reading():
                    shutil.copyfileobj(packed, copy)
            except DamageError as error:
                self._note(f'{file.name}: {error}')
            return target
        logs = [each for each in (file.with_name(f'{file.name}-{kind}') for kind in (
            'wal', 'journal')) if each.exists() and each.stat().st_size]
        if not logs:
            return file
        self._note(UNFINISHED)
        for each in (file, *logs):
            shutil.copyfile(each, self._folder / each.name)
        return self._folder / file.name

    def _stored(self) -> Iterator[Message]:
        """Yield all messages, as they lie in the files."""
        for source in self._sources:
            try:
                with reading(), source.open('rb') as stream:
                    first = stream.read(len(SQLITE))
                    if first.startswith(MCAP):
                        yield from self._mcap(stream, source.stat().st_size)
                    elif first.startswith(SQLITE):
                        yield from self._sqlite(source)
                    else:
                        raise DamageError('it begins neither as an MCAP nor as an SQLite file'
                                          if first else UNFINISHED)
            except DamageError as error:
                self._note(UNFINISHED if str(error) == UNFINISHED else f'{source.name}: {error}')

    def _note(self, fault: str) -> None:
        if fault not in self.faults:
            self.faults.append(fault)

    def _mcap(self, stream: BinaryIO, size: int) -> Iterator[Message]:
        schemas = {0: ('', '', '')}
        topics: dict[int, Topic] = {}
        for record in self._records(stream, size):
            match record:
                case McapMessage() if record.channel_id in topics:  # else that was damaged
                    yield topics[record.channel_id], record.log_time, record.data
                case Schema():
                    schemas[record.id] = record.name, record.encoding, record.data.decode()
                case Channel():
                    topics[record.id] = Topic(record.topic, *schemas[record.schema_id])

    def _records(self, stream: BinaryIO, size: int) -> Iterator[McapRecord]:
        """Yield the records of an MCAP file up to its last chunk, but for damaged chunks."""
        stream.seek(len(MCAP))
        while True:
            reader = StreamReader(
                stream, skip_magic=True, validate_crcs=True, record_size_limit=size)
            try:
                for record in reader.records:
                    if isinstance(record, DataEnd):
                        return
                    yield record
            except (EndOfFile, RecordLengthLimitExceeded):
                raise DamageError(UNFINISHED) from None
            except FAULTS as error:
                if stream.tell() >= size:
                    raise DamageError(UNFINISHED) from error
                self._note(f'a chunk is damaged: {error}')  # the next record follows it

    def _sqlite(self, file: Path) -> Iterator[Message]:
        # Of a file of the user's nothing is changed, and no log is looked for.
        fixed = '' if file.parent == self._folder else '?immutable=1'
        with closing(sqlite3.connect(f'{file.resolve().as_uri()}{fixed}', uri=True)) as database:
            defined = database.execute(
                "SELECT name FROM sqlite_master WHERE name = 'message_definitions'").fetchone()
            definitions = {name: text for name, *text in database.execute(
                'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions',
            )} if defined else {}
            topics = {}
            for number, name, kind in database.execute('SELECT id, name, type FROM topics'):
                topics[number] = Topic(name, kind, *definitions.get(kind, ()))
            for number, time, raw in database.execute(
                    'SELECT topic_id, timestamp, data FROM messages'):
                if number in topics:
                    yield topics[number], time, raw
