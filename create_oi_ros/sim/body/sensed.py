# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the firmware can ask of the body: one immutable record, and the range of every field."""

from collections.abc import Callable, Iterable
import math
from typing import Any, NamedTuple

from ...oi import ChargingState, Infrared, NUMBERS, PACKETS

NO_INFRARED = int(Infrared.NONE)
"""Packet 17 while no infrared character is received."""


class Sensed(NamedTuple):
    """
    Every sensor of the body at one moment, in the manual's units and within its ranges.

    Distance and angle are missing because reading them resets them: see `Body.take_distance`.
    """

    bump_left: bool = False
    bump_right: bool = False
    drop_left: bool = False
    drop_right: bool = False
    drop_caster: bool = False
    wall: bool = False
    wall_signal: int = 0
    cliff_left: bool = False
    cliff_front_left: bool = False
    cliff_front_right: bool = False
    cliff_right: bool = False
    cliff_left_signal: int = 0
    cliff_front_left_signal: int = 0
    cliff_front_right_signal: int = 0
    cliff_right_signal: int = 0
    virtual_wall: bool = False
    infrared: int = NO_INFRARED
    """Character, 0 to 255; 255 is none."""
    overcurrent_left_wheel: bool = False
    overcurrent_right_wheel: bool = False
    overcurrent_ld0: bool = False
    overcurrent_ld1: bool = False
    overcurrent_ld2: bool = False
    play: bool = False
    advance: bool = False
    charging_state: ChargingState = ChargingState.NOT_CHARGING
    voltage: int = 0
    """Millivolts."""
    current: int = 0
    """Milliamperes; negative while discharging."""
    temperature: int = 25
    """Degrees Celsius."""
    charge: int = 0
    """Milliampere hours."""
    capacity: int = 0
    """Milliampere hours."""
    home_base: bool = False
    """The robot touches the contacts of a Home Base that has power."""
    internal_charger: bool = False
    """The internal charger is plugged in and powered."""
    digital_input_0: bool = False
    digital_input_1: bool = False
    digital_input_2: bool = False
    digital_input_3: bool = False
    device_detect: bool = True
    """The baud rate pin: active low, high by default."""
    analog: int = 0
    """0 to 1023 for 0 to 5 V."""


PACKET_NAMES = {
    'temperature': 'battery_temperature', 'charge': 'battery_charge',
    'capacity': 'battery_capacity', 'analog': 'analog_signal',
}
"""The packets whose fields have a shorter name here; a field without a packet is one bit."""


def _range(name: str) -> tuple[int, int]:
    """Return the lowest and highest value of a field (manual: Sensor Packets)."""
    packet = NUMBERS.get(PACKET_NAMES.get(name, name))
    if packet is None:
        return 0, 1
    wire = PACKETS[packet].wire
    return wire.low, wire.high


RANGES = {name: _range(name) for name in Sensed._fields}
"""Lowest and highest value of each field of `Sensed`."""


def checked(name: str, value: int) -> int:
    """Return the value in its field's type; ValueError says which values are allowed."""
    if name not in RANGES:
        raise ValueError(f'no sensor {name!r}; allowed: {", ".join(RANGES)}')
    low, high = RANGES[name]
    if not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f'{name} is {value!r}; allowed: whole numbers from {low} to {high}')
    as_field: Callable[[int], int] = type(Sensed._field_defaults[name])
    return as_field(value)


def clamped(name: str, value: float) -> int:
    """Return the whole number nearest to value that the field can hold."""
    low, high = RANGES[name]
    return round(low if value < low else high if value > high else value)


class ForcedValues:
    """Sensor values that somebody outside holds in place of the physics, until a time, seconds."""

    def __init__(self) -> None:
        # Fields differ in type; `checked` has given each value its field's type.
        self._values: dict[str, Any] = {}
        self._ends: dict[str, float] = {}

    @property
    def deadline(self) -> float:
        """When the next value ends; inf: never."""
        return min(self._ends.values(), default=math.inf)

    def force(self, values: dict[str, int], until: float) -> None:
        """Hold all of these values, or with a ValueError none."""
        good = {name: checked(name, value) for name, value in values.items()}
        self._values.update(good)
        self._ends.update(dict.fromkeys(good, until))

    def release(self, names: Iterable[str] = ()) -> None:
        """Stop holding the named fields, or all; ValueError for a name that is no field."""
        for name in [*names] or [*self._values]:
            checked(name, 0)
            self._values.pop(name, None)
            self._ends.pop(name, None)

    def expire(self, now: float) -> None:
        """Release the values whose time is over."""
        if over := [name for name, end in self._ends.items() if end <= now]:
            self.release(over)

    def put_over(self, sensed: Sensed) -> Sensed:
        """Return the sensor values with the held ones in their place."""
        return sensed._replace(**self._values) if self._values else sensed
