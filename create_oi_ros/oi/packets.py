# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Groups of sensor packets, and lists of packets.

A group is a range of single packets; its size and contents are derived. A `PacketList` is what a
host requests with Stream or Query List, and the layout of the reply (manual: Sensor Packets;
Input Commands).
"""

from collections.abc import Iterable, Sequence
from operator import itemgetter
import struct
from typing import NamedTuple

from ..robot import SLOT
from .readings import NAMES, number_of, numbers_of, PACKETS, Readings
from .wire import BIG_ENDIAN, Wire

GROUPS: dict[int, range] = {
    0: range(7, 26 + 1), 1: range(7, 16 + 1), 2: range(17, 20 + 1), 3: range(21, 26 + 1),
    4: range(27, 34 + 1), 5: range(35, 42 + 1), 6: range(7, 42 + 1),
}
"""Single packets in each group (manual: Group Packet Sizes and Contents)."""
PACKET_IDS = (*GROUPS, *PACKETS)
PACKET_ID = Wire('B', min(PACKET_IDS), max(PACKET_IDS))

HEADER = 19
"""First byte of a stream frame (manual: Stream)."""
FRAME_LIMIT = 3 + 255
"""Bytes of the longest frame that the length byte can describe."""
BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit (manual: Stream; Serial Port Settings)."""


CREATE_2 = {*range(43, 58 + 1), 100, 101, 106, 107}
"""Packets and groups that only its successor has (iRobot Create 2 Open Interface)."""


def no_packet(number: object) -> str:
    """Say that the Create has no such packet, and which it has."""
    whose = f'; only a Create 2 has {number}' if number in CREATE_2 else ''
    return f'the Create has no packet {number!r}; allowed: {PACKET_ID.describe()}{whose}'


def size_of(packet: int | str) -> int:
    """
    Return the size in bytes of a packet or group.

    KeyError for a number, ValueError for a name that no packet has.
    """
    return struct.calcsize(BIG_ENDIAN + _format(number_of(packet)))


def _format(number: int) -> str:
    """Return the struct format of a packet or group."""
    return ''.join(PACKETS[n].wire.format for n in GROUPS.get(number, (number,)))


class Budget(NamedTuple):
    """What a stream frame costs on the wire."""

    size: int
    """Bytes of the whole frame, including header, length, ids and checksum."""
    baud: int
    """Bits per second."""

    @property
    def seconds(self) -> float:
        """Time that the frame takes on the wire."""
        return self.size * BITS_PER_BYTE / self.baud

    @property
    def capacity(self) -> int:
        """Bytes that fit in 15 ms at this baud rate: 86 at 57600, 28 at 19200 (manual: Stream)."""
        return int(SLOT * self.baud / BITS_PER_BYTE)

    @property
    def spare(self) -> int:
        """Bytes left in the 15 ms; negative if the frame does not fit."""
        return self.capacity - self.size

    @property
    def fits(self) -> bool:
        """Whether the robot can send the frame within 15 ms."""
        return self.size <= self.capacity


class PacketList:
    """A list of packets as requested with Stream or Query List, and the layout of the reply."""

    def __init__(self, ids: Iterable[int | str]) -> None:
        """Take packets by number or name, and groups; ValueError names one that is unknown."""
        self.ids = numbers_of(ids)
        for number in self.ids:
            if number not in PACKET_IDS:
                raise ValueError(no_packet(number))
        self.packets = tuple(
            PACKETS[n] for number in self.ids for n in GROUPS.get(number, (number,)))
        self.names = tuple(NAMES[packet.id] for packet in self.packets)
        formats = [_format(number) for number in self.ids]
        self._values = struct.Struct(BIG_ENDIAN + ''.join(formats))
        self._frame = struct.Struct(BIG_ENDIAN + 'xx' + ''.join(
            'x' + each for each in formats) + 'x')
        self.reply_size = self._values.size
        self.frame_size = self._frame.size
        self.length = self.frame_size - len((HEADER, 'length', 'checksum')) & 0xff
        """The length byte of a frame: the number of bytes between it and the checksum.

        If that number is too large for a byte (a Query List of 255 groups), this is its low
        byte. No frame of such a list exists: its `budget` does not fit at any baud rate.
        """
        # The header, the length and the ids are the same in every frame.
        fixed = {0: HEADER, 1: self.length}
        place = len(fixed)
        for number in self.ids:
            fixed[place] = number
            place += 1 + size_of(number)
        self._places, self._tags = tuple(fixed), tuple(fixed.values())
        self._tags_of = itemgetter(*self._places)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PacketList) and self.ids == other.ids

    def __hash__(self) -> int:
        return hash(self.ids)

    def __repr__(self) -> str:
        return f'PacketList({self.ids})'

    def matches(self, frame: bytes | bytearray) -> bool:
        """Tell whether a frame, or the start of one, has this list's header, length and ids."""
        if len(frame) == self.frame_size:
            return bool(self._tags_of(frame) == self._tags)
        known = zip(self._places, self._tags)
        return all(frame[place] == tag for place, tag in known if place < len(frame))

    def budget(self, baud: int) -> Budget:
        """Return what a frame costs at a baud rate (manual: Stream)."""
        return Budget(self.frame_size, baud)

    def unpack_reply(self, reply: bytes) -> Readings:
        """Decode the reply to Query List (or Sensors); ValueError if its length is wrong."""
        if len(reply) != self.reply_size:
            raise ValueError(
                f'{len(reply)} bytes for packets {self.ids}; expected {self.reply_size}')
        return Readings.of_fields(dict(zip(self.names, self._values.unpack(reply))))

    def unpack_frame(self, frame: bytes) -> Readings:
        """Decode a frame of this list; its checksum must have been verified."""
        return Readings.of_fields(dict(zip(self.names, self._frame.unpack(frame))))

    def pack_reply(self, values: Sequence[int]) -> bytes:
        """
        Encode the reply to Query List (or Sensors), values in the order of `packets`.

        ValueError if the number of values is wrong, or a value does not fit into its bytes.
        """
        try:
            return self._values.pack(*values)
        except struct.error:
            raise ValueError(self._refusal(values)) from None

    def pack_frame(self, values: Sequence[int], *, header_in_sum: bool = True) -> bytes:
        """
        Encode a stream frame, values in the order of `packets`.

        The manual leaves the header out of the checksum; real robots include it. ValueError if
        the list is too long for the length byte, the number of values is wrong, or a value does
        not fit into its bytes.
        """
        if self.frame_size > FRAME_LIMIT:
            raise ValueError(f'frame of {self.frame_size} bytes; allowed: up to {FRAME_LIMIT}')
        try:
            packed = self._frame.pack(*values)
        except struct.error:
            raise ValueError(self._refusal(values)) from None
        frame = bytearray(packed)
        for place, tag in zip(self._places, self._tags):
            frame[place] = tag
        frame[-1] = (0 if header_in_sum else HEADER) - sum(frame) & 0xff
        return bytes(frame)

    def _refusal(self, values: Sequence[object]) -> str:
        """Say why values cannot be encoded."""
        if len(values) != len(self.packets):
            return f'{len(values)} values for packets {self.ids}; expected {len(self.packets)}'
        return next(
            f'{name} (packet {packet.id}) = {value!r}; allowed: {low} to {high}'
            for packet, name, value in zip(self.packets, self.names, values)
            for low, high in [packet.wire.limits]
            if not (isinstance(value, int) and low <= value <= high))
