# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Finds frames in the bytes from the robot, and commands in the bytes to it.

Both readers have the same interface: `feed` appends bytes; `next_event` returns one event, or
None when it needs more bytes; `for event in reader` takes all that are ready. The events do not
depend on how the bytes are split. The bytes of all events, in order, are the bytes that were fed.
No bytes raise an exception.

A header byte alone does not mark a frame: 19 is also a packet number, and values are not
escaped. Nor can the next byte be trusted as a length. But the host has requested the packets, so
it knows length and order. The reader accepts only frames with the header, that length, those
packet numbers and a correct checksum. If one of these is wrong, it searches on from the byte
after the false header.
"""

from collections.abc import Iterable, Iterator
from enum import Enum
import re
from typing import NamedTuple

from .declaration import Command
from .packets import FRAME_LIMIT, HEADER, PacketList
from .readings import Readings


class Checksum(Enum):
    """Which bytes the checksum of a stream frame covers: its convention (manual: Stream)."""

    MANUAL = 'manual'
    """Length, ids and values, as the manual says."""
    HARDWARE = 'hardware'
    """The header too, as on real robots."""


BY_TOTAL = {0: Checksum.HARDWARE, HEADER: Checksum.MANUAL}
"""Conventions by the sum of all bytes of a correct frame, modulo 256."""


class Frame(NamedTuple):
    """A stream frame whose header, length, ids and checksum are correct."""

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
        """
        The pieces of readable text in it, each on its own line; '' if there are none.

        The robot's boot banner may follow half a frame or be split over two pieces of garbage:
        join the bytes of consecutive garbage to read it.
        """
        runs = (run.decode('ascii').strip() for run in READABLE.findall(self.data))
        return '\n'.join(run for run in runs if run)


TOO_SHORT = (b'', bytes((HEADER,)))
"""Ends of the buffer that may be the start of a frame: its length is still missing."""
READABLE = re.compile(rb'[ -~\t\r\n]{6,}')
"""Text; a shorter run of readable characters is chance."""
GARBAGE_LIMIT = 256
"""Garbage is returned in pieces of at most this size, so that memory stays bounded."""
FRAMES_TO_SWITCH = 3
"""Frames in a row with the other checksum convention after which the reader changes to it."""


class StreamReader:
    """
    Turns the bytes of a stream into frames and garbage.

    When all events are taken, at most 255 bytes of garbage and one incomplete frame are stored.
    """

    def __init__(self, expected: Iterable[PacketList] = ()) -> None:
        """Expect frames of these lists; `expect` changes them."""
        self._buffer = b''
        self._begin = 0  # the bytes before this index have been returned in events
        self._start = 0  # the bytes from _begin to this index are garbage
        self._by_head: dict[bytes, list[PacketList]] = {}
        self._other_in_a_row = 0
        self._total: int | None = None  # key of BY_TOTAL: the robot's checksum convention
        self.checksum_failures = 0
        """Number of frames in which only the checksum was wrong."""
        self.expect(expected)

    @property
    def checksum(self) -> Checksum | None:
        """The checksum convention of this robot; None before the first frame."""
        return None if self._total is None else BY_TOTAL[self._total]

    def expect(self, lists: Iterable[PacketList]) -> None:
        """
        Expect frames of these lists from now on.

        After a new request, include the previous list: its frames may still be on the way.
        Bytes that were found to be garbage stay garbage. Empty lists, and lists that are too
        long for a frame, are ignored.
        """
        if isinstance(lists, PacketList):
            raise TypeError(f'expected a list of lists, not one list: write [{lists!r}]')
        self._by_head.clear()
        for packets in lists:
            if not isinstance(packets, PacketList):
                raise TypeError(f'expected lists of the class PacketList, not {packets!r}')
            if packets.ids and packets.frame_size <= FRAME_LIMIT:
                self._by_head.setdefault(bytes((HEADER, packets.length)), []).append(packets)

    def feed(self, data: bytes) -> None:
        """Append received bytes."""
        self._buffer = self._buffer[self._begin:] + data
        self._begin, self._start = 0, self._start - self._begin

    def next_event(self) -> Frame | Garbage | None:
        """Return the next frame or garbage; None when more bytes are needed."""
        buffer = self._buffer
        if self._begin == len(buffer):
            return None
        while (start := self._start) - self._begin < GARBAGE_LIMIT:
            head = buffer[start:start + 2]
            # At most one list matches a whole frame: two lists of the same length have their
            # first different packet number at the same place.
            for packets in self._by_head.get(head, ()):
                data = buffer[start:start + packets.frame_size]
                if not packets.matches(data):
                    continue
                if len(data) < packets.frame_size:
                    return self._nothing()
                total = sum(data) & 0xff
                if total == self._total or self._is_accepted(total):
                    if start > self._begin:
                        return self._take_garbage(start)
                    self._begin = self._start = start + len(data)
                    self._other_in_a_row = 0
                    return Frame(packets, data, BY_TOTAL[total])
                self.checksum_failures += 1
            if head in TOO_SHORT:
                return self._nothing()
            next_header = buffer.find(HEADER, start + 1)
            self._start = len(buffer) if next_header < 0 else next_header
        return self._take_garbage(self._begin + GARBAGE_LIMIT)

    def __iter__(self) -> Iterator[Frame | Garbage]:
        """Yield the events that are ready."""
        return iter(self.next_event, None)

    def _nothing(self) -> Frame | Garbage | None:
        """Return no event, and drop the bytes that were returned before."""
        self.feed(b'')
        return None

    def finish(self) -> list[Frame | Garbage]:
        """
        Return the last events: call this when no more bytes will come.

        Until then, frames that follow an apparently incomplete frame are held back.
        """
        last: list[Frame | Garbage] = []
        while self._start < len(self._buffer):
            event = self.next_event()
            if event is not None:
                last.append(event)
            else:
                self._start += 1  # the frame that seemed to start here is incomplete
        rest = self.flush()
        return last if rest is None else [*last, rest]

    def flush(self) -> Garbage | None:
        """Remove and return all bytes that are not part of an event yet, as garbage."""
        self._start = len(self._buffer)
        return self._take_garbage(self._start) if self._start > self._begin else None

    def _take_garbage(self, end: int) -> Garbage:
        garbage = Garbage(self._buffer[self._begin:end])
        self._begin = end
        return garbage

    def _is_accepted(self, total: int) -> bool:
        """
        Tell whether a frame with this sum is correct, and change to its checksum convention.

        The first frame decides the convention. Later, one damaged frame in 256 is correct by the
        other convention by chance: such frames are refused until several come in a row, with no
        frame between them that is correct by neither.
        """
        if total not in BY_TOTAL:
            self._other_in_a_row = 0
            return False
        self._other_in_a_row += 1
        if self._total is not None and self._other_in_a_row < FRAMES_TO_SWITCH:
            return False
        self._total = total
        return True


class UnknownOpcode(NamedTuple):
    """A byte that is not an opcode; the robot ignores it."""

    data: bytes


class CommandReader:
    """
    Turns the bytes that a host sends into commands, as the robot does.

    An incomplete command waits for its data bytes and takes them from whatever comes next
    (manual: Open Interface Command Reference).
    """

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> None:
        """Append received bytes."""
        self._buffer += data

    def next_event(self) -> Command | UnknownOpcode | None:
        """Return the next command or unknown opcode; None when more bytes are needed."""
        buffer = self._buffer
        if not buffer:
            return None
        kind = Command.by_opcode.get(buffer[0])
        size = 1 if kind is None else kind.size(buffer)
        if len(buffer) < size:
            return None
        data = bytes(buffer[:size])
        del buffer[:size]
        return UnknownOpcode(data) if kind is None else kind.decode(data)

    def __iter__(self) -> Iterator[Command | UnknownOpcode]:
        """Yield the events that are ready."""
        return iter(self.next_event, None)

    @property
    def pending(self) -> bytes:
        """The bytes of an incomplete command."""
        return bytes(self._buffer)

    def clear(self) -> bytes:
        """Remove and return the bytes of an incomplete command."""
        pending = self.pending
        self._buffer.clear()
        return pending
