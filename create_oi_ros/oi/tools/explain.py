# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Explains bytes in the manual's words: one line for each command or frame, as they arrive.

A line for bytes that cannot be explained begins with #, so that all lines can be read as text.

`ListFinder` finds out from a stream itself which packets its frames carry. A frame names its
packets, and each has a known size. So a frame can be recognized without the request: its packets
fill exactly the length that it states, and its checksum is correct. A reader that knows the
request is safer: one damaged frame in some thousands looks like another list.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import takewhile
import re
from typing import Any

from ..declaration import Command
from ..packets import FRAME_LIMIT, HEADER, PACKET_IDS, PacketList, size_of
from ..readings import NUMBERS, Packet, PACKETS, Readings, VOLTS_PER_STEP
from ..stream import BY_TOTAL, Checksum, CommandReader, Frame, Garbage, StreamReader, UnknownOpcode
from .text import format_command, format_number

SEPARATORS = re.compile(r'[\s,;:|\[\](){}]+')
CONVENTIONS = {
    Checksum.MANUAL: '# checksums leave the header out, as the manual says',
    Checksum.HARDWARE: '# checksums include the header, as real robots do',
}
FOUND = '# frames of packets '
"""Begins a line that names a list which was found in the stream itself."""
ANALOG = PACKETS[NUMBERS['analog_signal']]
"""This packet is shown in volts, too."""


def understood(line: str) -> bool:
    """Tell whether a line explains bytes; False if it says that they cannot be explained."""
    return not line.startswith('#') or line in CONVENTIONS.values() or line.startswith(FOUND)


def octets(line: str, *, hexadecimal: bool = False) -> bytes:
    """
    Return the bytes in a line of text: decimal, or hexadecimal with 0x or `hexadecimal`.

    Commas, brackets and similar characters count as spaces; # begins a comment. ValueError names
    the word that is not a byte.
    """
    found = bytearray()
    for word in filter(None, SEPARATORS.split(line.partition('#')[0])):
        try:
            if hexadecimal or word[:2] in ('0x', '0X'):
                found += bytes.fromhex(word.removeprefix('0x').removeprefix('0X').zfill(2))
            else:
                found.append(int(word))
        except ValueError:
            raise ValueError(
                f'{word!r} is not a byte; allowed: 0 to 255, 0x00 to 0xff, or with --hex 00 to ff'
            ) from None
    return bytes(found)


def explain_commands(chunks: Iterable[bytes], *, at_length: bool = False) -> Iterator[str]:
    """Explain bytes that a host sent, one line for each command, as they arrive."""
    reader, commands, others = CommandReader(), 0, 0
    for chunk in chunks:
        reader.feed(chunk)
        for found in reader:
            commands += isinstance(found, Command)
            others += isinstance(found, UnknownOpcode)
            if isinstance(found, UnknownOpcode):
                yield f'# {found.data[0]} is not an opcode'
            else:
                yield explain_command(found, at_length=at_length)
    if reader.pending:
        title = Command.by_opcode[reader.pending[0]].title
        yield f'# {title} is cut short: {decimal(reader.pending)}'
    if others and not commands:
        yield '# no command: read what a robot sent with --reply or --stream'


def explain_command(command: Command, *, at_length: bool) -> str:
    """Explain one command; `at_length` adds its bytes, what it does, and when it is obeyed."""
    line = format_command(command)
    try:
        encoded = command.encode()
    except ValueError as refused:
        return f'# {line} (out of range: {refused})'
    if at_length:
        modes = ', '.join(mode.name.capitalize() for mode in sorted(command.modes))
        does = ' '.join(str(command.__doc__).split())
        line += f'  # {decimal(encoded)}. {does} Obeyed in {modes}.'
    return line


def explain_stream(
    chunks: Iterable[bytes], lists: Sequence[PacketList] = (),
) -> Iterator[str]:
    """
    Explain bytes that a robot sent, one line for each frame, as they arrive.

    Without lists, explain them by those that are found in the bytes; a line names each.
    """
    reader = StreamReader(lists)
    convention: Checksum | None = None
    named = set(lists)
    for found in _events(chunks if lists else _searched(chunks, reader), reader):
        if isinstance(found, Garbage):
            yield _garbage(found)
            continue
        if found.checksum is not convention:
            convention = found.checksum
            yield CONVENTIONS[convention]
        if found.packets not in named:
            named.add(found.packets)
            yield FOUND + ','.join(map(str, found.packets.ids))
        yield explain_readings(found.packets, found.readings)


def _searched(chunks: Iterable[bytes], reader: StreamReader) -> Iterator[bytes]:
    """Yield the bytes, each once the reader expects the lists of its frames."""
    finder = ListFinder()
    for chunk in chunks:
        ready = finder.feed(chunk)
        reader.expect(finder.lists)
        yield ready
    ready = finder.finish()
    reader.expect(finder.lists)
    yield ready


def _events(chunks: Iterable[bytes], reader: StreamReader) -> Iterator[Frame | Garbage]:
    for chunk in chunks:
        reader.feed(chunk)
        yield from reader
    yield from reader.finish()


def explain_replies(chunks: Iterable[bytes], packets: PacketList) -> Iterator[str]:
    """Explain replies to Sensors or Query List, one line for each, as they arrive."""
    rest = b''
    for chunk in chunks:
        rest += chunk
        while len(rest) >= packets.reply_size:
            yield explain_readings(packets, packets.unpack_reply(rest[:packets.reply_size]))
            rest = rest[packets.reply_size:]
    if rest:
        each = [packet.id for packet in packets.packets]
        *_, whole = takewhile(
            lambda part: part.reply_size <= len(rest),
            (PacketList(each[:count]) for count in range(len(each))))
        if whole.ids:
            yield explain_readings(whole, whole.unpack_reply(rest[:whole.reply_size]))
        yield f'# reply is cut short: {len(rest)} of {packets.reply_size} bytes'


def explain_readings(packets: PacketList, readings: Readings) -> str:
    """Explain all values of a frame or a reply."""
    values = dict(readings.items())
    return ', '.join(explain_reading(packet, values[name])
                     for packet, name in zip(packets.packets, packets.names))


def explain_reading(packet: Packet, value: Any) -> str:
    """Explain one value of a packet."""
    if packet is ANALOG:
        return f'{packet.title} = {value} ({value * VOLTS_PER_STEP:.2f} V)'
    number = format_number(packet.wire, value)
    return f'{packet.title} = {number}{packet.wire.unit and f" {packet.wire.unit}"}'


def _garbage(garbage: Garbage) -> str:
    text = garbage.text
    return f'# garbage: {decimal(garbage.data)}' + (f' {text!r}' if text else '')


def decimal(data: bytes) -> str:
    """Return bytes as decimal numbers, as in the manual."""
    return ' '.join(map(str, data))


class ListFinder:
    """Finds lists in bytes as they arrive."""

    def __init__(self) -> None:
        self.lists: dict[PacketList, None] = {}
        """The lists that were found, in order of appearance."""
        self._held = b''

    def feed(self, data: bytes) -> bytes:
        """Append received bytes; return those, in order, whose lists are all in `lists`."""
        held, at = self._held + data, 0
        while (start := held.find(HEADER, at)) >= 0:
            ids = _ids(held[start:start + FRAME_LIMIT])
            if ids is None:
                break
            at = start + 1
            if ids:
                packets = PacketList(ids)
                self.lists[packets] = None
                at = start + packets.frame_size
        done = len(held) if start < 0 else start
        self._held = held[done:]
        return held[:done]

    def finish(self) -> bytes:
        """Return the bytes that were held back: call this when no more bytes will come."""
        rest = b''
        while self._held:
            first, others, self._held = self._held[:1], self._held[1:], b''
            rest += first + self.feed(others)
        return rest


def _ids(frame: bytes) -> tuple[int, ...] | None:
    """Return the packets of a frame; () if it is none, None if more bytes are needed."""
    if len(frame) < 2:
        return None
    end = 2 + frame[1]
    ids, at = [], 2
    while at < end:
        if at >= len(frame):
            return None
        if frame[at] not in PACKET_IDS:
            return ()
        ids.append(frame[at])
        at += 1 + size_of(frame[at])
    if at > end:
        return ()
    if len(frame) <= end:
        return None
    return tuple(ids) if sum(frame[:end + 1]) & 0xff in BY_TOTAL else ()
