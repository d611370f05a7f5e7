"""
Bytes in flight, both ways: frames from the robot, commands to it.

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
import re
from typing import NamedTuple

from .declaration import Command
from .packets import FRAME_LIMIT, HEADER, PacketList
from .readings import Readings


class Checksum(Enum):
    """What the checksum of a stream frame sums up (manual: Stream)."""

    MANUAL = 'manual'
    """Length, ids and values, as the manual says."""
    HARDWARE = 'hardware'
    """The header too, as real robots do."""


BY_TOTAL = {0: Checksum.HARDWARE, HEADER: Checksum.MANUAL}
"""Conventions by what all bytes of a frame add up to, header and checksum included."""


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
        return readable(self.data)


BEGINNINGS = (b'', bytes((HEADER,)))
"""What is too short to tell whether a frame begins."""
READABLE = re.compile(rb'[ -~\t\r\n]{6,}')
"""Fewer readable characters than this in a row are chance, not text."""
GARBAGE_AT_ONCE = 256
"""Garbage is handed out in pieces of this size, so that memory stays bounded."""
SWITCH_AFTER = 3
"""Frames in a row that verify only by the other convention before the reader believes it."""


def readable(data: bytes) -> str:
    """
    Return the runs of text among other bytes, each on lines of its own; '' if there are none.

    The boot banner may come behind half a frame, or in two pieces of garbage: join the bytes of
    what came together, then look.
    """
    runs = (run.decode('ascii').strip() for run in READABLE.findall(data))
    return '\n'.join(run for run in runs if run)


class StreamReader:
    """
    Turns the bytes of a stream into frames and garbage.

    Once all events are taken it holds no more than 255 bytes of garbage and an unfinished frame.
    """

    def __init__(self, expected: Iterable[PacketList] = ()) -> None:
        """Expect frames of these lists; they can be changed at any time."""
        self._buffer = b''
        self._begin = 0  # what is before has been handed out
        self._start = 0  # what is between is known to be garbage
        self._by_head: dict[bytes, list[PacketList]] = {}
        self._other_in_a_row = 0
        self._total: int | None = None  # what the bytes of the robot's frames add up to
        self.checksum_failures = 0
        """Frames that were whole but for their checksum."""
        self.expect(expected)

    @property
    def checksum(self) -> Checksum | None:
        """The convention that the robot was found to follow; None before the first frame."""
        return None if self._total is None else BY_TOTAL[self._total]

    def expect(self, lists: Iterable[PacketList]) -> None:
        """
        Expect frames of these lists from now on: the new one, and the old one in flight.

        Bytes already found to be garbage stay garbage. Lists that no frame can hold, empty ones
        and those beyond what the length byte can say, are passed over.
        """
        self._by_head.clear()
        for packets in lists:
            if packets.ids and packets.frame_size <= FRAME_LIMIT:
                self._by_head.setdefault(bytes((HEADER, packets.length)), []).append(packets)

    def feed(self, data: bytes) -> None:
        """Append bytes that came in."""
        # Most often nothing is left and one frame comes; then no byte is copied, here or later.
        self._buffer = self._buffer[self._begin:] + data
        self._begin, self._start = 0, self._start - self._begin

    def next_event(self) -> Frame | Garbage | None:
        """Take out the next frame or garbage; None when more bytes are needed."""
        buffer = self._buffer
        while (start := self._start) - self._begin < GARBAGE_AT_ONCE:
            head = buffer[start:start + 2]
            # A whole frame is of one list at most: where two lists of one length first differ,
            # the number stands in the same place in both.
            for packets in self._by_head.get(head, ()):
                data = buffer[start:start + packets.frame_size]
                if not packets.matches(data):
                    continue
                if len(data) < packets.frame_size:
                    return self._nothing()
                total = sum(data) & 0xff
                if total == self._total or self._is_believed(total):
                    if start > self._begin:
                        return self._take_garbage(start)
                    self._begin = self._start = start + len(data)
                    self._other_in_a_row = 0
                    return Frame(packets, data, BY_TOTAL[total])
                self.checksum_failures += 1
            if head in BEGINNINGS:
                return self._nothing()
            next_header = buffer.find(HEADER, start + 1)
            self._start = len(buffer) if next_header < 0 else next_header
        return self._take_garbage(self._begin + GARBAGE_AT_ONCE)

    def _nothing(self) -> Frame | Garbage | None:
        """Return no event, and keep no more than what belongs to none."""
        self.feed(b'')
        return None

    def finish(self) -> list[Frame | Garbage]:
        """
        Return the last events when nothing follows, all that is left among them.

        While more may follow, frames wait behind what looks like an unfinished one; here they
        come out.
        """
        last: list[Frame | Garbage] = []
        while self._start < len(self._buffer):
            event = self.next_event()
            if event is not None:
                last.append(event)
            else:
                self._start += 1  # what seemed to begin here has no end
        rest = self.flush()
        return last if rest is None else [*last, rest]

    def flush(self) -> Garbage | None:
        """Throw away what was received and is no event yet; return it as garbage."""
        self._start = len(self._buffer)
        return self._take_garbage(self._start) if self._start > self._begin else None

    def _take_garbage(self, end: int) -> Garbage:
        garbage = Garbage(self._buffer[self._begin:end])
        self._begin = end
        return garbage

    def _is_believed(self, total: int) -> bool:
        """
        Tell whether a frame adds up right by a convention that was not the robot's so far.

        The first frame decides. From then on frames by the other convention are refused, for
        one byte in 256 is right by chance, until so many come in a row that it is no chance.
        """
        if total not in BY_TOTAL:
            return False
        self._other_in_a_row += 1
        if self._total is not None and self._other_in_a_row < SWITCH_AFTER:
            return False
        self._total = total
        return True


class UnknownOpcode(NamedTuple):
    """A byte that begins no command; the robot drops it."""

    data: bytes


class CommandReader:
    """
    Turns the bytes that a host sends into commands, as the robot reads them.

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
