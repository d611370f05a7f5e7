# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Recovers bags whose recorder was killed: copies the intact part of each file."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ...ros.bags import BagError, DamageError, guarded

if TYPE_CHECKING:
    from mcap.stream_reader import StreamReader
    from mcap.writer import Writer

MAGIC = b'\x89MCAP0\r\n'
"""First bytes of an MCAP file, and its last ones if it was closed."""
UNFINISHED = 'its recorder did not close it'


def files_of(path: Path) -> list[Path]:
    """
    Return what to open: the bag itself, or its files if it was never closed.

    A recorder writes `metadata.yaml`, and the end of an MCAP file, when it closes the bag.
    """
    if not path.exists():
        raise BagError(f'there is no {path}')
    files = sorted(each for each in path.iterdir() if each.suffix in ('.mcap', '.db3')) \
        if path.is_dir() else [path]
    closed = path.is_file() or (path / 'metadata.yaml').exists()
    if not closed and not files:
        raise BagError(f'{path} is no bag: it holds neither metadata.yaml nor .mcap or .db3 files')
    return files if not closed or any(map(unfinished, files)) else [path]


def unfinished(file: Path) -> bool:
    """Return whether a file is an MCAP file that was not closed."""
    with file.open('rb') as stream:
        if stream.read(len(MAGIC)) != MAGIC:
            return False
        rest = stream.seek(0, 2) - len(MAGIC)
        stream.seek(max(len(MAGIC), rest))
        return stream.read() != MAGIC


def recover(file: Path, target: Path) -> None:
    """Copy all chunks (up to a megabyte each) before the first damaged one."""
    from mcap.stream_reader import StreamReader
    from mcap.writer import CompressionType, Writer
    with file.open('rb') as source, target.open('wb') as copy:
        writer = Writer(copy, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        with suppress(DamageError):  # expected: the rest of the file is lost
            _copy(StreamReader(source, validate_crcs=True), writer)
        writer.finish()  # type: ignore[no-untyped-call]


def _copy(reader: StreamReader, writer: Writer) -> None:
    from mcap.records import Channel, Message, Schema
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    for record in guarded(reader.records):
        match record:
            case Schema() if record.id not in schemas:
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, record.data)
            case Channel() if record.id not in channels:
                channels[record.id] = writer.register_channel(
                    record.topic, record.message_encoding, schemas[record.schema_id],
                    record.metadata)
            case Message():
                writer.add_message(channels[record.channel_id], record.log_time, record.data,
                                   record.publish_time, record.sequence)
