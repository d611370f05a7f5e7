"""
Every sensor packet of the Open Interface, declared once.

A single packet is a field of `Readings`: the annotation carries its number, the manual's name,
format, range and unit. Groups are ranges of single packets; their sizes and contents are
derived. `PacketList` is what a host asks for in Stream and Query List, and how the reply is laid
out (manual: Sensor Packets; Input Commands).
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
import struct
from typing import Annotated, Any, get_args, NamedTuple

from .codes import (
    BumpsAndWheelDrops,
    Buttons,
    ChargingSources,
    ChargingState,
    DigitalInputs,
    Infrared,
    Mode,
    Overcurrents,
)
from .wire import BIG_ENDIAN, bits, choice, Wire

FLAG = Wire('B', 0, 1, boolean=True)
SIGNAL = Wire('H', 0, 4095)
SIGNED = Wire('h', -32768, 32767)
UNSIGNED_MAX = 65535


class Packet(NamedTuple):
    """Declaration of one single packet."""

    id: int
    title: str
    wire: Wire


class Readings:
    """
    Values of single packets, in the units of the manual.

    Only what has arrived is there: reading another attribute raises AttributeError. Values out
    of the manual's range are kept as they came, so that nothing is lost; `implausible` names
    them.
    """

    bumps_and_wheel_drops: Annotated[
        BumpsAndWheelDrops, Packet(7, 'Bumps and Wheel Drops', bits('B', BumpsAndWheelDrops))]
    wall: Annotated[bool, Packet(8, 'Wall', FLAG)]
    cliff_left: Annotated[bool, Packet(9, 'Cliff Left', FLAG)]
    cliff_front_left: Annotated[bool, Packet(10, 'Cliff Front Left', FLAG)]
    cliff_front_right: Annotated[bool, Packet(11, 'Cliff Front Right', FLAG)]
    cliff_right: Annotated[bool, Packet(12, 'Cliff Right', FLAG)]
    virtual_wall: Annotated[bool, Packet(13, 'Virtual Wall', FLAG)]
    overcurrents: Annotated[
        Overcurrents,
        Packet(14, 'Low Side Driver and Wheel Overcurrents', bits('B', Overcurrents))]
    unused_15: Annotated[int, Packet(15, 'Unused', Wire('B', 0, 0))]
    unused_16: Annotated[int, Packet(16, 'Unused', Wire('B', 0, 0))]
    infrared: Annotated[int, Packet(17, 'Infrared Byte', Wire('B', 0, 255, names=Infrared))]
    buttons: Annotated[Buttons, Packet(18, 'Buttons', bits('B', Buttons))]
    distance: Annotated[int, Packet(19, 'Distance', Wire('h', -32768, 32767, 'mm'))]
    angle: Annotated[int, Packet(20, 'Angle', Wire('h', -32768, 32767, 'deg'))]
    charging_state: Annotated[
        ChargingState, Packet(21, 'Charging State', choice('B', ChargingState))]
    voltage: Annotated[int, Packet(22, 'Voltage', Wire('H', 0, UNSIGNED_MAX, 'mV'))]
    current: Annotated[int, Packet(23, 'Current', Wire('h', -32768, 32767, 'mA'))]
    battery_temperature: Annotated[
        int, Packet(24, 'Battery Temperature', Wire('b', -128, 127, 'degC'))]
    battery_charge: Annotated[int, Packet(25, 'Battery Charge', Wire('H', 0, UNSIGNED_MAX, 'mAh'))]
    battery_capacity: Annotated[
        int, Packet(26, 'Battery Capacity', Wire('H', 0, UNSIGNED_MAX, 'mAh'))]
    wall_signal: Annotated[int, Packet(27, 'Wall Signal', SIGNAL)]
    cliff_left_signal: Annotated[int, Packet(28, 'Cliff Left Signal', SIGNAL)]
    cliff_front_left_signal: Annotated[int, Packet(29, 'Cliff Front Left Signal', SIGNAL)]
    cliff_front_right_signal: Annotated[int, Packet(30, 'Cliff Front Right Signal', SIGNAL)]
    cliff_right_signal: Annotated[int, Packet(31, 'Cliff Right Signal', SIGNAL)]
    digital_inputs: Annotated[
        DigitalInputs, Packet(32, 'Cargo Bay Digital Inputs', bits('B', DigitalInputs))]
    analog_signal: Annotated[
        int, Packet(33, 'Cargo Bay Analog Signal', Wire('H', 0, 1023, '5/1023 V'))]
    charging_sources: Annotated[
        ChargingSources, Packet(34, 'Charging Sources Available', bits('B', ChargingSources))]
    oi_mode: Annotated[Mode, Packet(35, 'OI Mode', choice('B', Mode))]
    song_number: Annotated[int, Packet(36, 'Song Number', Wire('B', 0, 15))]
    song_playing: Annotated[bool, Packet(37, 'Song Playing', FLAG)]
    stream_packets: Annotated[int, Packet(38, 'Number of Stream Packets', Wire('B', 0, 43))]
    requested_velocity: Annotated[
        int, Packet(39, 'Requested Velocity', Wire('h', -500, 500, 'mm/s'))]
    requested_radius: Annotated[
        int, Packet(40, 'Requested Radius', Wire('h', -32768, 32767, 'mm'))]
    requested_right_velocity: Annotated[
        int, Packet(41, 'Requested Right Velocity', Wire('h', -500, 500, 'mm/s'))]
    requested_left_velocity: Annotated[
        int, Packet(42, 'Requested Left Velocity', Wire('h', -500, 500, 'mm/s'))]

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        """Hold values by field name."""
        if values:
            self.__dict__.update(values)

    def __repr__(self) -> str:
        shown = ', '.join(f'{name}={value!r}' for name, value in self.__dict__.items())
        return f'Readings({shown})'

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Readings) and self.__dict__ == other.__dict__

    def has(self, *names: str) -> bool:
        """Tell whether all of these have arrived."""
        values = self.__dict__
        for name in names:
            if name not in values:
                return False
        return True

    def update(self, newer: 'Readings') -> None:
        """Take over all that another set of readings holds."""
        self.__dict__.update(newer.__dict__)

    def implausible(self) -> list[str]:
        """Name the readings that are out of the manual's range."""
        values = self.__dict__
        return [name for name, low, high, mask in _bounded()
                if name in values
                and (int(values[name]) & mask if mask else not low <= values[name] <= high)]


NAMES: dict[int, str] = {}
"""Field names of the single packets by number."""
PACKETS: dict[int, Packet] = {}
"""Declarations of the single packets by number."""
for _name, _annotation in Readings.__annotations__.items():
    _packet = get_args(_annotation)[1]
    NAMES[_packet.id], PACKETS[_packet.id] = _name, _packet
NUMBERS = {name: number for number, name in NAMES.items()}


@cache
def _members(wire: Wire) -> tuple[Any, ...]:
    """Return what each byte stands for."""
    return tuple(wire.named(value) for value in range(256))


@cache
def _bounded() -> tuple[tuple[str, int, int, int], ...]:
    """
    Return what the manual allows of the packets that could bring more.

    By field name: least, most, and the bits that must not be set where bits have names.
    """
    bounded = []
    for name, number in NUMBERS.items():
        wire = PACKETS[number].wire
        if wire.high - wire.low + 1 < 256 ** struct.calcsize(wire.format):
            bounded.append((name, wire.low, wire.high, 0xff & ~wire.mask if wire.mask else 0))
    return tuple(bounded)


GROUPS: dict[int, range] = {
    0: range(7, 26 + 1), 1: range(7, 16 + 1), 2: range(17, 20 + 1), 3: range(21, 26 + 1),
    4: range(27, 34 + 1), 5: range(35, 42 + 1), 6: range(7, 42 + 1),
}
"""Single packets that a group holds (manual: Group Packet Sizes and Contents)."""
PACKET_IDS = (*GROUPS, *PACKETS)
PACKET_ID = Wire('B', min(PACKET_IDS), max(PACKET_IDS))

HEADER = 19
"""First byte of a stream frame (manual: Stream)."""
FRAME_LIMIT = 3 + 255
"""Bytes of the longest frame that the length byte can tell."""
SLOT = 0.015
"""Seconds between two frames, and between two updates inside the robot (manual: Stream)."""
BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit (manual: Stream; Serial Port Settings)."""


def size_of(packet: int) -> int:
    """Return the bytes of a packet's values; KeyError where there is no such packet."""
    return struct.calcsize(BIG_ENDIAN + ''.join(PACKETS[n].wire.format for n in singles(packet)))


def singles(packet: int) -> Sequence[int]:
    """Return the single packets that a packet number stands for; KeyError where there is none."""
    return GROUPS[packet] if packet in GROUPS else (PACKETS[packet].id,)


def frame_capacity(baud: int) -> int:
    """Return how many bytes a slot holds at a baud rate: 86 at 57600, 28 at 19200 (Stream)."""
    return int(SLOT * baud / BITS_PER_BYTE)


class Budget(NamedTuple):
    """What a stream frame costs on the wire."""

    size: int
    """Bytes of the whole frame, header, length, ids and checksum included."""
    capacity: int
    """Bytes that one slot of 15 ms holds at this baud rate."""
    seconds: float
    """Time the frame takes on the wire."""

    @property
    def spare(self) -> int:
        """Bytes left in the slot; negative where the frame does not fit."""
        return self.capacity - self.size

    @property
    def fits(self) -> bool:
        """Tell whether the robot can send it in time."""
        return self.spare >= 0


class PacketList:
    """A list of packets as asked for in Stream or Query List, and the layout of the reply."""

    def __init__(self, ids: Iterable[int]) -> None:
        """Compile a list of packet numbers; ValueError names a number that is no packet."""
        self.ids = tuple(ids)
        for number in self.ids:
            if number not in PACKET_IDS:
                raise ValueError(f'packet {number!r}; allowed: {PACKET_ID.describe()}')
        self.packets = tuple(PACKETS[n] for number in self.ids for n in singles(number))
        self.names = tuple(NAMES[packet.id] for packet in self.packets)
        wires = [packet.wire for packet in self.packets]
        self._values = struct.Struct(BIG_ENDIAN + ''.join(wire.format for wire in wires))
        self._frame = struct.Struct(f'{BIG_ENDIAN}xx{self._tagged("x")}x')
        self._converted = [
            (place, _members(wire))
            for place, wire in enumerate(wires) if wire.boolean or wire.names]
        self.reply_size = self._values.size
        self.frame_size = self._frame.size
        self.length = self.frame_size - len((HEADER, 'length', 'checksum')) & 0xff
        """The length byte of a frame: how many bytes lie between it and the checksum.

        A list may be too long for one byte (a Query List of 255 groups); its low byte stands
        here then, and the list's `budget` fits at no baud rate.
        """
        self._mask, self._tags = self._fixed_bytes()

    @classmethod
    def named(cls, *names: str) -> 'PacketList':
        """Compile a list of single packets given by the field names of `Readings`."""
        unknown = [name for name in names if name not in NUMBERS]
        if unknown:
            raise ValueError(f'no packet is named {unknown[0]!r}; allowed: {", ".join(NUMBERS)}')
        return cls(NUMBERS[name] for name in names)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PacketList) and self.ids == other.ids

    def __hash__(self) -> int:
        return hash(self.ids)

    def __repr__(self) -> str:
        return f'PacketList({self.ids})'

    def _tagged(self, tag: str) -> str:
        formats = []
        for number in self.ids:
            formats.append(tag)
            formats.extend(PACKETS[n].wire.format for n in singles(number))
        return ''.join(formats)

    def _fixed_bytes(self) -> tuple[int, int]:
        """
        Return a mask over the bytes of a frame that never change, and those bytes.

        Comparing them as one large number is the fastest way there is in Python to see that a
        frame has the header, the length and the packet numbers that were asked for.
        """
        fixed = {0: HEADER, 1: self.length}
        place = len(fixed)
        for number in self.ids:
            fixed[place] = number
            place += 1 + size_of(number)
        mask = bytes(0xff if at in fixed else 0 for at in range(self.frame_size))
        tags = bytes(fixed.get(at, 0) for at in range(self.frame_size))
        return int.from_bytes(mask), int.from_bytes(tags)

    def matches(self, frame: bytes | bytearray) -> bool:
        """Tell whether the beginning of a frame may be of this list (header, length, ids)."""
        missing = 8 * (self.frame_size - len(frame))
        if not missing:
            return int.from_bytes(frame) & self._mask == self._tags
        return int.from_bytes(frame) & (self._mask >> missing) == self._tags >> missing

    def budget(self, baud: int) -> Budget:
        """Tell what a frame costs at a baud rate (manual: Stream)."""
        return Budget(self.frame_size, frame_capacity(baud), self.wire_time(baud))

    def wire_time(self, baud: int) -> float:
        """Return the seconds that a frame takes on the wire at a baud rate."""
        return self.frame_size * BITS_PER_BYTE / baud

    def unpack_reply(self, reply: bytes) -> Readings:
        """Decode the reply to Query List (or Sensors); ValueError where its length is wrong."""
        if len(reply) != self.reply_size:
            raise ValueError(
                f'{len(reply)} bytes for packets {self.ids}; expected {self.reply_size}')
        return self._readings(self._values.unpack(reply))

    def unpack_frame(self, frame: bytes) -> Readings:
        """Decode a frame of this list that has been verified."""
        return self._readings(self._frame.unpack(frame))

    def _readings(self, raw: tuple[Any, ...]) -> Readings:
        values = list(raw)
        for place, members in self._converted:
            values[place] = members[raw[place]]
        readings = object.__new__(Readings)
        readings.__dict__ = dict(zip(self.names, values))
        return readings

    def pack_reply(self, values: Sequence[int]) -> bytes:
        """Encode the reply to Query List (or Sensors), values in the order of `packets`."""
        return self._values.pack(*values)

    def pack_frame(self, values: Sequence[int], *, header_in_sum: bool = True) -> bytes:
        """
        Encode a stream frame, values in the order of `packets`.

        The manual leaves the header out of the checksum; real robots include it. ValueError
        where the list is too long for the length byte.
        """
        if self.frame_size > FRAME_LIMIT:
            raise ValueError(f'frame of {self.frame_size} bytes; allowed: up to {FRAME_LIMIT}')
        whole = int.from_bytes(self._frame.pack(*values)) | self._tags
        frame = bytearray(whole.to_bytes(self.frame_size))
        frame[-1] = (0 if header_in_sum else HEADER) - sum(frame) & 0xff
        return bytes(frame)

