# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Every single sensor packet of the Open Interface, declared once, and the values that arrive.

A packet is a field of `Readings`: the annotation carries its number, the manual's name, format,
range and unit (manual: Sensor Packets).
"""

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from functools import cache
from math import nan
from operator import itemgetter
from typing import Annotated, Any, get_args, NamedTuple

from ..robot import TOP_SPEED_MM
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
from .wire import bits, choice, Wire

FLAG = Wire('B', 0, 1, boolean=True)
SIGNAL = Wire('H', 0, 4095)
SPEED = Wire('h', -TOP_SPEED_MM, TOP_SPEED_MM, 'mm/s')
UNSIGNED_MAX = 65535
CHARGE = Wire('H', 0, UNSIGNED_MAX, 'mAh')
VOLTS_PER_STEP = 5 / 1023
"""Resolution of the analog input (manual: Cargo Bay Analog Signal)."""


class Packet(NamedTuple):
    """Declaration of one single packet."""

    id: int
    title: str
    wire: Wire


class Readings:
    """
    Values of single packets, in the units of the manual. They cannot be changed.

    Only packets that have arrived have a value: reading any other field raises AttributeError.
    Values out of the manual's range are kept unchanged; `implausible` names them. `corrected`
    makes numbers and codes among them None: not known.

    The numbers are stored as they came. A number becomes a truth value or a named member only
    when its field is read, because most values are never read.
    """

    __slots__ = ('_numbers',)

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
        ChargingState | None, Packet(21, 'Charging State', choice('B', ChargingState))]
    voltage: Annotated[int | None, Packet(22, 'Voltage', Wire('H', 0, UNSIGNED_MAX, 'mV'))]
    current: Annotated[int | None, Packet(23, 'Current', Wire('h', -32768, 32767, 'mA'))]
    battery_temperature: Annotated[
        int | None, Packet(24, 'Battery Temperature', Wire('b', -128, 127, 'degC'))]
    battery_charge: Annotated[int | None, Packet(25, 'Battery Charge', CHARGE)]
    battery_capacity: Annotated[int | None, Packet(26, 'Battery Capacity', CHARGE)]
    wall_signal: Annotated[int | None, Packet(27, 'Wall Signal', SIGNAL)]
    cliff_left_signal: Annotated[int | None, Packet(28, 'Cliff Left Signal', SIGNAL)]
    cliff_front_left_signal: Annotated[int | None, Packet(29, 'Cliff Front Left Signal', SIGNAL)]
    cliff_front_right_signal: Annotated[int | None, Packet(30, 'Cliff Front Right Signal', SIGNAL)]
    cliff_right_signal: Annotated[int | None, Packet(31, 'Cliff Right Signal', SIGNAL)]
    digital_inputs: Annotated[
        DigitalInputs, Packet(32, 'Cargo Bay Digital Inputs', bits('B', DigitalInputs))]
    analog_signal: Annotated[
        int | None, Packet(33, 'Cargo Bay Analog Signal', Wire('H', 0, 1023, '5/1023 V'))]
    charging_sources: Annotated[
        ChargingSources, Packet(34, 'Charging Sources Available', bits('B', ChargingSources))]
    oi_mode: Annotated[Mode | None, Packet(35, 'OI Mode', choice('B', Mode))]
    song_number: Annotated[int | None, Packet(36, 'Song Number', Wire('B', 0, 15))]
    song_playing: Annotated[bool, Packet(37, 'Song Playing', FLAG)]
    stream_packets: Annotated[int, Packet(38, 'Number of Stream Packets', Wire('B', 0, 43))]
    requested_velocity: Annotated[int | None, Packet(39, 'Requested Velocity', SPEED)]
    requested_radius: Annotated[
        int, Packet(40, 'Requested Radius', Wire('h', -32768, 32767, 'mm'))]
    requested_right_velocity: Annotated[int | None, Packet(41, 'Requested Right Velocity', SPEED)]
    requested_left_velocity: Annotated[int | None, Packet(42, 'Requested Left Velocity', SPEED)]

    def __init__(self, values: Mapping[str, int] | None = None) -> None:
        """Store values by field name; KeyError names a field that does not exist."""
        self._numbers: dict[str, int | None] = dict(values or {})
        for name in self._numbers:
            NUMBERS[name]  # raises KeyError

    @classmethod
    def of_fields(cls, numbers: dict[str, int | None]) -> 'Readings':
        """Store a dictionary without copying it; its keys must be field names."""
        readings = cls.__new__(cls)
        readings._numbers = numbers
        return readings

    def __repr__(self) -> str:
        return f'Readings({", ".join(f"{name}={value!r}" for name, value in self.items())})'

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Readings) and self._numbers == other._numbers

    @property
    def analog_volts(self) -> float:
        """
        Voltage at the analog input, V (packet 33); NaN if it is not known.

        AttributeError if it has not arrived.
        """
        return nan if self.analog_signal is None else self.analog_signal * VOLTS_PER_STEP

    def items(self) -> Iterator[tuple[str, Any]]:
        """Yield field names and values."""
        return ((name, getattr(self, name)) for name in self._numbers)

    def has(self, *names: str) -> bool:
        """Tell whether all of these fields have arrived."""
        return all(map(self._numbers.__contains__, names))

    def number(self, name: str, default: int) -> int:
        """Return a field as a plain number; `default` if it has not arrived or is not known."""
        number = self._numbers.get(name)
        return default if number is None else number

    @staticmethod
    def numbers(first: str, *more: str) -> Callable[['Readings'], tuple[Any, ...]]:
        """
        Return a function that looks these fields up at once, as plain numbers.

        A number that is not known is None. KeyError, from that function: one of them has not
        arrived.
        """
        if not more:
            return lambda readings: (readings._numbers[first],)
        pick: Callable[[Mapping[str, int | None]], tuple[Any, ...]] = itemgetter(first, *more)
        return lambda readings: pick(readings._numbers)

    def updated(self, newer: 'Readings') -> 'Readings':
        """Return these readings with the newer ones in their place."""
        return self.of_fields(self._numbers | newer._numbers)

    def implausible(self, allowed: Mapping[str, Container[int | None]] | None = None) -> list[str]:
        """Name the readings that are out of the manual's range, or not among those `allowed`."""
        allowed = allowed or ALLOWED
        return [name for name, number in self._numbers.items() if number not in allowed[name]]

    def corrected(self, names: Iterable[str]) -> 'Readings':
        """Return these readings with bits that mean nothing cleared, or None, in these fields."""
        return self.of_fields(self._numbers | {
            name: PACKETS[NUMBERS[name]].wire.without_spare_bits(self.number(name, 0))
            for name in names})


def _field(name: str, wire: Wire) -> property:
    """Return the property of `Readings` that looks one field up."""
    named = cache(wire.named) if wire.boolean or wire.names else None

    def look_up(readings: Readings) -> Any:
        try:
            number = readings._numbers[name]
        except KeyError:
            raise AttributeError(f'{name} has not arrived') from None
        return named(number) if named else number

    return property(look_up)


# The declarations above: packets and field names by number; numbers and allowed values by name.
PACKETS: dict[int, Packet] = {}
NAMES: dict[int, str] = {}
NUMBERS: dict[str, int] = {}
ALLOWED: dict[str, Container[int | None]] = {}
for _name, _annotation in Readings.__annotations__.items():
    _, _packet = get_args(_annotation)
    PACKETS[_packet.id], NAMES[_packet.id], NUMBERS[_name] = _packet, _name, _packet.id
    ALLOWED[_name] = _packet.wire.allowed
    setattr(Readings, _name, _field(_name, _packet.wire))


def number_of(packet: int | str) -> int:
    """Return the number of a packet that is given by number or by its field's name."""
    if not isinstance(packet, str):
        return packet
    if packet not in NUMBERS:
        raise ValueError(f'no packet is named {packet!r}; allowed: {", ".join(NUMBERS)}')
    return NUMBERS[packet]


def numbers_of(packets: Iterable[int | str]) -> tuple[int, ...]:
    """
    Return the numbers of packets; ValueError for a single name instead of a list.

    What cannot be a list is returned unchanged: a command refuses it when it is encoded.
    """
    if isinstance(packets, str):
        raise ValueError(f'packets = {packets!r}; allowed: a list, such as [{packets!r}]')
    return tuple(map(number_of, packets)) if isinstance(packets, Iterable) else packets
