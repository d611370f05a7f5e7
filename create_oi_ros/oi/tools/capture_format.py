"""
A capture: every byte of a line, both ways, with its time, in one file.

It begins with text, the fact of a line each, up to an empty line:

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
HEAD_LIMIT = 1 << 16
RECORD_LIMIT = 1 << 16
"""Bytes that a head or a record may have: more of them is no capture."""
NAME = re.compile(r'[a-z][a-z0-9_]*')
KIND_BITS, NUMBER_BITS, NUMBER_LIMIT = 3, 7, 9
"""Bits of a kind, bits in a byte of a number, bytes of a number."""
MORE = 1 << NUMBER_BITS
MICROSECONDS = 1_000_000


class RecordKind(IntEnum):
    """What a record tells."""

    FROM_ROBOT = 0
    TO_ROBOT = 1
    OPENED = 2
    """The port was opened; the text says which."""
    LOST = 3
    """The port is gone; the text says why."""
    BAUD = 4
    """The host speaks at another rate from now on; the text is the rate."""
    NOTE = 5
    """What the driver said to its user."""
    END = 6
    """The capture was ended in order."""


BYTES = (RecordKind.FROM_ROBOT, RecordKind.TO_ROBOT)


class Record(NamedTuple):
    """Something that happened on the line, microseconds after the capture was started."""

    time: int
    kind: RecordKind
    data: bytes = b''

    @property
    def text(self) -> str:
        """What a record says that is not bytes of the line."""
        return self.data.decode('utf-8', 'replace')


class CaptureError(ValueError):
    """No capture, a damaged one, or one that was cut short."""


def encode_head(facts: Mapping[str, str]) -> bytes:
    """Return the head of a file; ValueError for a fact that is no name and one line of text."""
    lines = []
    for name, value in facts.items():
        if NAME.fullmatch(name) is None or '\n' in value:
            raise ValueError(f'{name!r} = {value!r}: a name (a-z, 0-9, _) and one line are wanted')
        lines.append(f'{name} {value}\n'.encode('utf-8', 'backslashreplace'))
    return FIRST_LINE + b''.join(lines) + b'\n'


def encode_record(pause: int, kind: RecordKind, data: bytes = b'') -> bytes:
    """Return a record that comes so many microseconds after the one before it."""
    if pause < 0 or len(data) > RECORD_LIMIT:
        raise ValueError(f'a pause of {pause} us and {len(data)} bytes: 0 or more and at most '
                         f'{RECORD_LIMIT} are allowed')
    return _number(pause << KIND_BITS | kind) + _number(len(data)) + data


def _number(value: int) -> bytes:
    encoded = bytearray()
    while value >= MORE:
        encoded.append(value & MORE - 1 | MORE)
        value >>= NUMBER_BITS
    encoded.append(value)
    return bytes(encoded)


class CaptureReader:
    """Turns the bytes of a file into its facts and records, however the bytes are cut."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._at = 0
        self._read = 0
        self.facts: dict[str, str] | None = None
        """What the head says; None until it has been read."""
        self.time = 0
        """Of the last record, in microseconds."""
        self.ended = False
        """Whether the capture's end has been read."""

    def feed(self, data: bytes) -> None:
        """Append bytes of the file."""
        del self._buffer[:self._at]
        self._read += self._at
        self._at = 0
        self._buffer += data

    def next_record(self) -> Record | None:
        """Take out the next record; None when more bytes are needed, CaptureError if damaged."""
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
        """Return a number and where it ends; 0 and a place before all where it does not."""
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
            raise CaptureError(_stranger(start))
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
        """CaptureError where the file has no end, though all of it has been fed."""
        if self.facts is None and not self._buffer:
            raise CaptureError('empty')
        if not self.ended:
            raise CaptureError(
                f'cut short at {self.time / MICROSECONDS:.3f} s (byte {self._place}): its driver '
                'was killed or still writes it, or the disk was full; what is before is good')


def _stranger(head: bytes) -> str:
    """Say what is wrong with a file that does not begin as it should."""
    first, _, _ = head.decode('utf-8', 'replace').partition('\n')
    if first.startswith(FORMAT):
        return (f'a capture of version {first.removeprefix(FORMAT)[:20]}; this program reads '
                f'version {VERSION}')
    return f'no capture: one begins with the line {FIRST_LINE.decode().strip()!r}'


def records_of(chunks: Iterable[bytes], reader: CaptureReader) -> Iterator[Record]:
    """Yield all whole records of a file; then CaptureError, if it was cut short or is none."""
    for chunk in chunks:
        reader.feed(chunk)
        while (record := reader.next_record()) is not None:
            yield record
    reader.finish()
