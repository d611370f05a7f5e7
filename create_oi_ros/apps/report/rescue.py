"""A bag whose recorder was killed: what is whole of its files, as files that can be read."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ...ros.bags import BagError, DamageError, guarded

if TYPE_CHECKING:
    from mcap.stream_reader import StreamReader
    from mcap.writer import Writer

MAGIC = b'\x89MCAP0\r\n'
"""With which an MCAP file begins, and ends when it was closed."""
UNFINISHED = 'its recorder did not close it'


def files_of(path: Path) -> list[Path]:
    """
    Return what to open: the bag as it is, or its files where it was never closed.

    A recorder writes `metadata.yaml`, and the end of an MCAP file, when it ends.
    """
    if not path.exists():
        raise BagError(f'there is no {path}')
    files = sorted(each for each in path.iterdir() if each.suffix in ('.mcap', '.db3')) \
        if path.is_dir() else [path]
    closed = path.is_file() or (path / 'metadata.yaml').exists()
    if not closed and not files:
        raise BagError(f'{path} is no bag: there is neither metadata.yaml nor a file of messages '
                       'in it')
    return files if not closed or any(map(unfinished, files)) else [path]


def unfinished(file: Path) -> bool:
    """Tell whether a file is an MCAP file without its end."""
    with file.open('rb') as stream:
        if stream.read(len(MAGIC)) != MAGIC:
            return False
        rest = stream.seek(0, 2) - len(MAGIC)
        stream.seek(max(len(MAGIC), rest))
        return stream.read() != MAGIC


def rescue(file: Path, target: Path) -> None:
    """Copy what comes before the first damage; a chunk of up to a megabyte is whole or lost."""
    from mcap.stream_reader import StreamReader
    from mcap.writer import CompressionType, Writer
    with file.open('rb') as source, target.open('wb') as copy:
        writer = Writer(copy, compression=CompressionType.NONE)
        writer.start(profile='ros2')
        with suppress(DamageError):  # it is why this is done
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
