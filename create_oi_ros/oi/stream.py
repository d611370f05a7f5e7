"""Bytes in flight, both ways: frames from the robot, commands to it.

Both readers work alike: `feed` only appends bytes, `next_event` takes one event out, or returns
None when more bytes are needed. However the bytes are cut, the same events come out; the bytes
of all events, in order, are the bytes that went in; no bytes raise.

The stream reader does not hunt for the header 19 and believe what follows: 19 is a packet number
too, frames are not escaped, and the length is not protected. The host has asked for the packets,
so it knows length and order: a frame is only what has the header, that length, those numbers and
the checksum. After a failure it looks again from the byte after the false header.
"""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple
from zlib import adler32

from .command import Command
from .packets import HEADER, PacketList, Readings


class Checksum(Enum):
    """What the checksum of a stream frame sums up (manual: Stream)."""

    MANUAL = 'manual'
    """Length, ids and values, as the manual says."""
    HARDWARE = 'hardware'
    """The header too, as real robots do."""


class Frame(NamedTuple):
    """A stream frame whose header, length, ids and checksum are right."""

    packets: PacketList
    data: bytes
    checksum: Checksum

    @property
    def readings(self) -> Readings:
        """The values, decoded."""
        return self.packets.unpack_frame(self.data)


class Garbage(NamedTuple):
    """Bytes that belong to no frame: noise, a damaged frame, or the boot banner."""

    data: bytes

    @property
    def text(self) -> str:
        """What is readable in it (the robot says who it is when it boots), else ''."""
        shown = ''.join(chr(byte) for byte in self.data if 32 <= byte < 127 or byte in b'\r\n')
        return shown.strip() if len(shown) * 5 >= len(self.data) * 4 else ''


GARBAGE_AT_ONCE = 256
"""Garbage is handed out in pieces of this size, so that memory stays bounded."""
SWITCH_AFTER = 3
"""Frames in a row that verify only by the other convention before the reader believes it."""


class StreamReader:
    """Turns the bytes of a stream into frames and garbage."""

    def __init__(self, expected: Iterable[PacketList] = ()) -> None:
        """Expect frames of these lists; they can be changed at any time."""
        self._buffer = bytearray()
        self._start = 0
        self._by_length: dict[int, tuple[PacketList, ...]] = {}
        self._other_in_a_row = 0
        self.checksum: Checksum | None = None
        """The convention that the robot was found to follow; None before the first frame."""
        self.checksum_failures = 0
        """Frames that were whole but for their checksum."""
        self.expect(expected)

    def expect(self, lists: Iterable[PacketList]) -> None:
        """Expect frames of these lists from now on: the new one, and the old one in flight."""
        by_length: dict[int, tuple[PacketList, ...]] = {}
        for packets in lists:
            if packets.ids:
                same = by_length.get(packets.length, ())
                by_length[packets.length] = (*same, packets)
        self._by_length = by_length

    def feed(self, data: bytes) -> None:
        """Append bytes that came in."""
        self._buffer += data

    def next_event(self) -> Frame | Garbage | None:
        """Take out the next frame or garbage; None when more bytes are needed."""
        buffer = self._buffer
        while self._start < len(buffer):
            if self._start >= GARBAGE_AT_ONCE:
                return self._take_garbage(GARBAGE_AT_ONCE)
            if buffer[self._start] != HEADER:
                next_header = buffer.find(HEADER, self._start)
                self._start = len(buffer) if next_header < 0 else next_header
                continue
            found = self._frame_at(self._start)
            if found is None:
                return None
            if found is not False:
                if self._start:
                    return self._take_garbage(self._start)
                del buffer[:found.packets.frame_size]
                return found
            self._start += 1
        if self._start >= GARBAGE_AT_ONCE:
            return self._take_garbage(GARBAGE_AT_ONCE)
        return None

    def flush(self) -> Garbage | None:
        """Give up on what was received and not recognised, when nothing follows it."""
        self._start = len(self._buffer)
        return self._take_garbage(self._start) if self._start else None

    def _take_garbage(self, size: int) -> Garbage:
        garbage = Garbage(bytes(self._buffer[:size]))
        del self._buffer[:size]
        self._start -= size
        return garbage

    def _frame_at(self, start: int) -> 'Frame | None | bool':
        """Return the frame that begins here, None while it may yet become one, else False."""
        buffer = self._buffer
        if len(buffer) < start + 2:
            return None
        for packets in self._by_length.get(buffer[start + 1], ()):
            data = bytes(buffer[start:start + packets.frame_size])
            if not packets.matches(data):
                continue
            if len(data) < packets.frame_size:
                return None
            checksum = self._verify(data)
            if checksum is not None:
                return Frame(packets, data, checksum)
        return False

    def _verify(self, data: bytes) -> Checksum | None:
        """Return the convention under which the checksum is right, if it may be believed."""
        # The low half of Adler-32 is one more than the sum of the bytes, computed in C.
        total = (adler32(data) & 0xffff) - 1 & 0xff
        if total == 0:
            found = Checksum.HARDWARE
        elif total == HEADER:
            found = Checksum.MANUAL
        else:
            self.checksum_failures += 1
            return None
        if self.checksum in (None, found):
            self.checksum = found
            self._other_in_a_row = 0
            return found
        self._other_in_a_row += 1
        if self._other_in_a_row < SWITCH_AFTER:
            self.checksum_failures += 1
            return None
        self.checksum = found
        return found


class UnknownOpcode(NamedTuple):
    """A byte that begins no command; the robot drops it."""

    data: bytes


class CommandReader:
    """Turns the bytes that a host sends into commands, as the robot reads them.

    A command that is cut short waits for its data bytes and swallows what comes next (manual:
    Open Interface Command Reference).
    """

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> None:
        """Append bytes that came in."""
        self._buffer += data

    def next_event(self) -> Command | UnknownOpcode | None:
        """Take out the next command or unknown opcode; None when more bytes are needed."""
        buffer = self._buffer
        if not buffer:
            return None
        kind = Command.by_opcode.get(buffer[0])
        size = 1 if kind is None else kind.size(buffer)
        if len(buffer) < size:
            return None
        # A count that has just arrived makes the command longer.
        if kind is not None and len(buffer) < (size := kind.size(buffer)):
            return None
        data = bytes(buffer[:size])
        del buffer[:size]
        return UnknownOpcode(data) if kind is None else kind.decode(data)

    @property
    def pending(self) -> bytes:
        """Bytes received that are not yet a whole command."""
        return bytes(self._buffer)

    def clear(self) -> bytes:
        """Forget and return the bytes that are not yet a whole command."""
        pending = self.pending
        self._buffer.clear()
        return pending
