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
from collections.abc import Callable, Collection, Iterator
from contextlib import closing
from heapq import heappop, heappush
from importlib import import_module
from io import BytesIO
from os import SEEK_END
from pathlib import Path
import re
import shutil
import sqlite3
from struct import unpack, unpack_from
import sys
from typing import Any, BinaryIO, NamedTuple

from rosbags.rosbag2.storage_mcap import decompress
import yaml

from ...ros.bags import BagError, DamageError, guarded, reading

MCAP, SQLITE, ZSTD = b'\x89MCAP0\r\n', b'SQLite format 3\0', b'\x28\xb5\x2f\xfd'
"""First bytes of the files, and of what is compressed."""
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15
"""Opcodes of MCAP records."""
UNFINISHED = 'its recorder did not close it, so the last seconds may be missing'


class Topic(NamedTuple):
    """A topic of a bag, with the definition of its type, which may be empty."""

    name: str
    type: str
    encoding: str = ''
    definition: str = ''


Message = tuple[Topic, int, bytes]
"""A message: its topic, its time in ns, what was serialized."""


class BagFiles:
    """The messages of a bag; BagError says why it has none."""

    def __init__(self, path: Path, folder: Path) -> None:
        """Look through all files; what has to be unpacked or repaired goes into a folder."""
        self.faults: list[str] = []
        """What is not whole, each in words."""
        self.storage = ''
        self._sources = [self._source(file, folder) for file in self._files(path)]
        self.counts: Counter[Topic] = Counter()
        """Messages of each topic."""
        self.start, self.end, self._late = sys.maxsize, 0, 0
        for topic, time, _ in self._stored():
            self.counts[topic] += 1
            self.start, self.end = min(self.start, time), max(self.end, time)
            self._late = max(self._late, self.end - time)
        if not self.counts:
            raise BagError(
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
            return topic, time, _zstd().decompress(raw) if raw.startswith(ZSTD) else raw

    def _files(self, path: Path) -> list[Path]:
        """Return the files of a bag, the oldest first."""
        if not path.exists():
            raise BagError(f'there is no {path}')
        if path.is_file():
            return [path]
        found = [each for each in path.iterdir() if each.suffix in ('.mcap', '.db3', '.zstd')]
        if not found:
            raise BagError(f'{path} is no bag: it holds neither .mcap nor .db3 files')
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

    def _source(self, file: Path, folder: Path) -> Callable[[], Iterator[Message]]:
        """Return a function that reads a file."""
        try:
            with reading(), file.open('rb') as stream:
                first = stream.read(len(SQLITE))
        except DamageError as error:
            self.faults.append(f'{file.name}: {error}')
            return lambda: iter(())
        if first.startswith(ZSTD):
            return self._source(self._unpacked(file, folder), folder)
        if first.startswith(MCAP):
            self.storage = 'MCAP'
            return lambda: self._mcap(file)
        if first.startswith(SQLITE):
            self.storage = 'SQLite'
            return self._sqlite(file, folder)
        self.faults.append(f'{file.name} begins neither as an MCAP nor as an SQLite file'
                           if first else UNFINISHED)
        return lambda: iter(())

    def _unpacked(self, file: Path, folder: Path) -> Path:
        target = folder / file.stem
        try:
            with _zstd().open(file) as packed, target.open('wb') as copy, reading():
                shutil.copyfileobj(packed, copy)
        except DamageError as error:
            self.faults.append(f'{file.name}: {error}')
        return target

    def _sqlite(self, file: Path, folder: Path) -> Callable[[], Iterator[Message]]:
        """Read what its recorder left in a log beside the database too, from a copy of both."""
        logs = [each for each in (file.with_name(f'{file.name}-{kind}') for kind in (
            'wal', 'journal')) if each.exists() and each.stat().st_size]
        if not logs:
            return lambda: _sqlite_messages(f'{file.resolve().as_uri()}?immutable=1')
        self.faults.append(UNFINISHED)
        for each in (file, *logs):
            shutil.copyfile(each, folder / each.name)
        return lambda: _sqlite_messages((folder / file.name).as_uri())

    def _stored(self) -> Iterator[Message]:
        """Yield all messages, as they lie in the files."""
        for source in self._sources:
            try:
                yield from guarded(source())
            except DamageError as error:
                self._note(str(error))

    def _note(self, fault: str) -> None:
        if fault not in self.faults:
            self.faults.append(fault)

    def _mcap(self, file: Path) -> Iterator[Message]:
        schemas: dict[int, list[str]] = {0: ['', '', '']}
        topics: dict[int, Topic] = {}
        with file.open('rb') as stream:
            stream.seek(len(MCAP))
            for opcode, body in self._flattened(stream):
                if opcode == MESSAGE:
                    channel, _, time = unpack_from('<HIQ', body)
                    if channel in topics:  # else the chunk with it is damaged
                        yield topics[channel], time, body[22:]
                elif opcode == SCHEMA:
                    schemas[unpack_from('<H', body)[0]] = _texts(body, 2, 3)
                elif opcode == CHANNEL:
                    channel, schema = unpack_from('<HH', body)
                    topics[channel] = Topic(*_texts(body, 4, 1), *schemas[schema])
                elif opcode == DATA_END:
                    return
        raise DamageError(UNFINISHED)

    def _flattened(self, stream: BinaryIO) -> Iterator[tuple[int, bytes]]:
        """Yield the records of an MCAP file, those inside of chunks instead of the chunks."""
        for opcode, body in _records(stream):
            if opcode != CHUNK:
                yield opcode, body
                continue
            try:
                with reading():
                    size, checksum = unpack_from('<QI', body, 16)
                    compression, = _texts(body, 28, 1)
                    content = decompress(
                        body[40 + len(compression):], compression, size, checksum)
            except DamageError as error:
                self._note(str(error))
                continue
            yield from _records(BytesIO(content))


def _records(stream: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and content of MCAP records, up to one that is cut off."""
    at = stream.tell()
    end = stream.seek(0, SEEK_END)
    stream.seek(at)
    while at + 9 <= end:
        opcode, size = unpack('<BQ', stream.read(9))
        at += 9 + size
        if at > end:
            return
        yield opcode, stream.read(size)


def _texts(body: bytes, at: int, count: int) -> list[str]:
    """Return texts that follow each other, each with its length before it."""
    found = []
    for _ in range(count):
        size, = unpack_from('<I', body, at)
        found.append(body[at + 4:at + 4 + size].decode())
        at += 4 + size
    return found


def _sqlite_messages(address: str) -> Iterator[Message]:
    with closing(sqlite3.connect(address, uri=True)) as database:
        defined = database.execute(
            "SELECT name FROM sqlite_master WHERE name = 'message_definitions'").fetchone()
        definitions = {name: text for name, *text in database.execute(
            'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions',
        )} if defined else {}
        topics = {number: Topic(name, kind, *definitions.get(kind, ()))
                  for number, name, kind in database.execute('SELECT id, name, type FROM topics')}
        for number, time, raw in database.execute(
                'SELECT topic_id, timestamp, data FROM messages'):
            if number in topics:
                yield topics[number], time, raw


def _zstd() -> Any:
    """Return the module that rosbags brings, or Python."""
    return import_module('compression.zstd' if sys.version_info >= (3, 14) else 'backports.zstd')
