# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A capture: a file with every byte on a serial line, in both directions, with its time.

It begins with lines of text, one fact each, up to an empty line:

    create capture 1
    started 2026-01-31T09:30:00.000000+00:00
    port /dev/ttyUSB0

Then records follow. A record is two numbers and then as many bytes as the second number says.
The first number is the time since the record before, in microseconds, times eight, plus the
`RecordKind`. A number has seven bits in each byte, the low bits first; every byte but its last
has the high bit set. So a frame takes four bytes more than its own. The last record is an END;
without it the capture was cut short, and all whole records before the cut are good.
"""

from collections.abc import Iterable, Iterator, Mapping
from enum import IntEnum
import re
from typing import NamedTuple

FORMAT = 'create capture '
VERSION = '1'
FIRST_LINE = f'{FORMAT}{VERSION}\n'.encode()
BLANK = b'\n\n'
# Largest number of bytes in a head or in the data of a record.
HEAD_LIMIT = 1 << 16
RECORD_LIMIT = 1 << 16
NAME = re.compile(r'[a-z][a-z0-9_]*')
# Bits of a kind, bits in each byte of a number, bytes of the longest number.
KIND_BITS, NUMBER_BITS, NUMBER_LIMIT = 3, 7, 9
MORE = 1 << NUMBER_BITS
"""The high bit of a byte: the number has more bytes."""
MICROSECONDS = 1_000_000


class RecordKind(IntEnum):
    """What a record contains."""

    FROM_ROBOT = 0
    """Bytes from the robot."""
    TO_ROBOT = 1
    """Bytes to the robot."""
    OPENED = 2
    """The port was opened; the text says which port."""
    LOST = 3
    """The port failed; the text says why."""
    BAUD = 4
    """The host changed its baud rate; the text is the new rate."""
    NOTE = 5
    """A message of the driver to its user."""
    END = 6
    """The capture was ended properly."""


class Record(NamedTuple):
    """One event on the line; its time is in microseconds since the start of the capture."""

    time: int
    kind: RecordKind
    data: bytes = b''

    @property
    def text(self) -> str:
        """The text of a record that does not contain bytes of the line."""
        return self.data.decode('utf-8', 'replace')


class CaptureError(ValueError):
    """A file is no capture, is damaged, or was cut short."""


def encode_head(facts: Mapping[str, str]) -> bytes:
    """Return the head of a file; ValueError for a fact that is not a name and one line."""
    lines = []
    for name, value in facts.items():
        if NAME.fullmatch(name) is None or '\n' in value:
            raise ValueError(f'{name!r} = {value!r}; allowed: a name (a-z, 0-9, _) and one line')
        lines.append(f'{name} {value}\n'.encode('utf-8', 'backslashreplace'))
    return FIRST_LINE + b''.join(lines) + b'\n'


def encode_record(pause: int, kind: RecordKind, data: bytes = b'') -> bytes:
    """Return a record; `pause` is the time since the record before, in microseconds."""
    if pause < 0 or len(data) > RECORD_LIMIT:
        raise ValueError(f'record with a pause of {pause} us and {len(data)} bytes; allowed: 0 us '
                         f'or more, up to {RECORD_LIMIT} bytes')
    return _number(pause << KIND_BITS | kind) + _number(len(data)) + data


def _number(value: int) -> bytes:
    encoded = bytearray()
    while value >= MORE:
        encoded.append(value & MORE - 1 | MORE)
        value >>= NUMBER_BITS
    encoded.append(value)
    return bytes(encoded)


class CaptureReader:
    """Turns the bytes of a file, in pieces of any size, into its facts and records."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._at = 0
        self._read = 0
        self.facts: dict[str, str] | None = None
        """The facts in the head; None until it has been read."""
        self.time = 0
        """Time of the last record, in microseconds."""
        self.ended = False
        """Whether the END record has been read."""

    def feed(self, data: bytes) -> None:
        """Append bytes of the file."""
        del self._buffer[:self._at]
        self._read += self._at
        self._at = 0
        self._buffer += data

    def next_record(self) -> Record | None:
        """Return the next record; None when more bytes are needed, CaptureError if damaged."""
        if self.facts is None and not self._read_head():
            return None
        if self.ended and self._at < len(self._buffer):
            raise CaptureError(f'damaged: bytes follow its end (byte {self._place})')
        at = self._at
        pause, at = self._number(at)
        size, at = self._number(at)
        kind = pause & (1 << KIND_BITS) - 1
        if size > RECORD_LIMIT or kind > RecordKind.END:
            raise CaptureError(f'damaged at byte {self._place}')
        if at < 0 or len(self._buffer) < at + size:
            return None
        self.time += pause >> KIND_BITS
        self.ended = kind == RecordKind.END
        self._at = at + size
        return Record(self.time, RecordKind(kind), bytes(self._buffer[at:at + size]))

    @property
    def _place(self) -> int:
        return self._read + self._at

    def _number(self, at: int) -> tuple[int, int]:
        """Return a number and the index after it; 0 and -1 when more bytes are needed."""
        value = 0
        if at < 0:
            return 0, -1
        for shift, byte in enumerate(self._buffer[at:at + NUMBER_LIMIT]):
            value |= (byte & MORE - 1) << shift * NUMBER_BITS
            if byte < MORE:
                return value, at + shift + 1
        if len(self._buffer) >= at + NUMBER_LIMIT:
            raise CaptureError(f'damaged at byte {self._place}')
        return 0, -1

    def _read_head(self) -> bool:
        start = bytes(self._buffer[:HEAD_LIMIT])
        if not FIRST_LINE.startswith(start[:len(FIRST_LINE)]):
            raise CaptureError(_wrong_start(start))
        head, blank, _ = start.partition(BLANK)
        if not blank:
            if len(head) == HEAD_LIMIT:
                raise CaptureError('damaged: its head has no end')
            return False
        lines = head.decode('utf-8', 'replace').split('\n')[1:]
        self.facts = {name: value for name, _, value in (line.partition(' ') for line in lines)}
        self._at = len(head) + len(blank)
        return True

    def finish(self) -> None:
        """Call this after the last bytes of the file; CaptureError if it has no END record."""
        if self.facts is None and not self._buffer:
            raise CaptureError('empty')
        if not self.ended:
            raise CaptureError(
                f'cut short at {self.time / MICROSECONDS:.3f} s (byte {self._place}): the driver '
                'was killed or is still writing, or the disk was full; all before is good')


def _wrong_start(head: bytes) -> str:
    """Say what is wrong with a file that does not begin like a capture."""
    first, _, _ = head.decode('utf-8', 'replace').partition('\n')
    if first.startswith(FORMAT):
        return (f'a capture of version {first.removeprefix(FORMAT)[:20]}; this program reads '
                f'version {VERSION}')
    return f'no capture: a capture begins with the line {FIRST_LINE.decode().strip()!r}'


def records_of(chunks: Iterable[bytes], reader: CaptureReader) -> Iterator[Record]:
    """Yield all whole records of a file; then CaptureError if it is damaged or cut short."""
    for chunk in chunks:
        reader.feed(chunk)
        while (record := reader.next_record()) is not None:
            yield record
    reader.finish()
