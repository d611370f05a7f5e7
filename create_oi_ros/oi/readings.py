"""
Every single sensor packet of the Open Interface, declared once, and the values that arrive.

A packet is a field of `Readings`: the annotation carries its number, the manual's name, format,
range and unit (manual: Sensor Packets).
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from operator import itemgetter
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
from .wire import bits, choice, Wire

FLAG = Wire('B', 0, 1, boolean=True)
SIGNAL = Wire('H', 0, 4095)
SIGNED = Wire('h', -32768, 32767)
UNSIGNED_MAX = 65535


class Packet(NamedTuple):
    """Declaration of one single packet."""

    id: int
    title: str
    wire: Wire


class Bound(NamedTuple):
    """What the manual allows of a value of which the wire could bring more."""

    name: str
    place: int
    low: int
    high: int
    unnamed: int
    """The bits that must not be set, where bits have names; else 0."""


class Readings(tuple[int, ...]):
    """
    Values of single packets, in the units of the manual.

    Only what has arrived is there: reading another attribute raises AttributeError. Values out
    of the manual's range are kept as they came, so that nothing is lost; `implausible` names
    them.

    It is a row of the numbers that were on the wire, which costs least for a frame; flags and
    names are looked up when they are read.
    """

    __slots__ = ()
    _names: tuple[str, ...] = ()
    """What stands in the row."""
    _places: Mapping[str, int] = {}
    """Where in the row a field stands; the last place where it stands twice."""
    _bounds: tuple[Bound, ...] = ()

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

    def __new__(cls, values: Mapping[str, int] | None = None) -> 'Readings':
        """Hold values by field name; KeyError where no packet has such a name."""
        values = values or {}
        return tuple.__new__(row_of(tuple(values)), values.values())

    def __reduce__(self) -> tuple[Any, ...]:
        return Readings, (dict(self.items()),)

    def __repr__(self) -> str:
        return f'Readings({", ".join(f"{name}={value!r}" for name, value in self.items())})'

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Readings) and dict(self.items()) == dict(other.items())

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash(frozenset(self.items()))

    def items(self) -> Iterator[tuple[str, Any]]:
        """Yield field names and values."""
        return ((name, getattr(self, name)) for name in self._places)

    def has(self, *names: str) -> bool:
        """Tell whether all of these have arrived."""
        places = self._places
        for name in names:
            if name not in places:
                return False
        return True

    def updated(self, newer: 'Readings') -> 'Readings':
        """Return these readings, but for those that are newer in others."""
        row, places = _union(type(self), type(newer))
        if row is type(newer):
            return newer
        return tuple.__new__(row, map((self + newer).__getitem__, places))

    def implausible(self) -> list[str]:
        """Name the readings that are out of the manual's range."""
        return [name for name, place, low, high, unnamed in self._bounds
                if (self[place] & unnamed if unnamed else not low <= self[place] <= high)]


NAMES: dict[int, str] = {}
"""Field names of the single packets by number."""
PACKETS: dict[int, Packet] = {}
"""Declarations of the single packets by number."""
for _name, _annotation in Readings.__annotations__.items():
    *_, _packet = get_args(_annotation)
    if isinstance(_packet, Packet):
        NAMES[_packet.id], PACKETS[_packet.id] = _name, _packet
NUMBERS = {name: number for number, name in NAMES.items()}


@cache
def row_of(names: tuple[str, ...]) -> type[Readings]:
    """Return the kind of readings that hold these fields in this order."""
    places = {name: place for place, name in enumerate(names)}
    wires = {name: PACKETS[NUMBERS[name]].wire for name in places}
    return type('Readings', (Readings,), {
        '__slots__': (), '_names': names, '_places': places,
        '_bounds': tuple(
            Bound(name, places[name], wire.low, wire.high, 0xff & ~wire.mask if wire.mask else 0)
            for name, wire in wires.items()
            if wire.high - wire.low + 1 < 256 ** struct.calcsize(wire.format)),
        **{name: property(_getter(wire, places[name])) for name, wire in wires.items()}})


def _getter(wire: Wire, place: int) -> Callable[[Any], Any]:
    """Return what reads a field of a row: the number, or what it stands for."""
    if not wire.boolean and wire.names is None:
        return itemgetter(place)
    members = _members(wire)
    return lambda row: members[row[place]]


@cache
def _members(wire: Wire) -> tuple[Any, ...]:
    """Return what each byte stands for."""
    return tuple(wire.named(value) for value in range(256))


@cache
def _union(old: type[Readings], new: type[Readings]) -> tuple[type[Readings], tuple[int, ...]]:
    """Return the kind of readings that hold the fields of both, and where they come from."""
    if new._places.keys() >= old._places.keys():
        return new, ()
    places = {**old._places, **{
        name: len(old._names) + place for name, place in new._places.items()}}
    return row_of(tuple(places)), tuple(places.values())
