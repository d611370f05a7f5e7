"""What the firmware can ask of the body: one immutable record, and the range of every field."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

NO_INFRARED = 255
"""Packet 17 when no infrared character is being received."""


class Charging(IntEnum):
    """Packet 21, with the manual's numbers."""

    NOT_CHARGING = 0
    RECONDITIONING = 1
    FULL = 2
    TRICKLE = 3
    WAITING = 4
    FAULT = 5


class Sensed(NamedTuple):
    """
    Every sensor of the body at one moment, in the manual's units and always in its ranges.

    Distance and angle are not here, since reading them resets them: see `Body.take_distance`.
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
    charging_state: Charging = Charging.NOT_CHARGING
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
    """The Home Base's contacts are touched and powered."""
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


WORD, SIGNAL = (0, 65535), (0, 4095)
WIDE = {
    'wall_signal': SIGNAL, 'cliff_left_signal': SIGNAL, 'cliff_front_left_signal': SIGNAL,
    'cliff_front_right_signal': SIGNAL, 'cliff_right_signal': SIGNAL, 'infrared': (0, 255),
    'charging_state': (0, 5), 'voltage': WORD, 'current': (-32768, 32767),
    'temperature': (-128, 127), 'charge': WORD, 'capacity': WORD, 'analog': (0, 1023),
}
RANGES: dict[str, tuple[int, int]] = {
    name: WIDE.get(name, (0, 1)) for name in Sensed._fields}
"""Lowest and highest value of each field of `Sensed`, by the manual."""


def checked(name: str, value: int) -> int:
    """Return the value as its field holds it, or raise ValueError that says what is allowed."""
    if name not in RANGES:
        raise ValueError(f'no sensor {name!r}: one of {", ".join(RANGES)}')
    low, high = RANGES[name]
    if not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f'{name} is {value!r}: a whole number within {low} to {high} is wanted')
    kind: Callable[[int], int] = type(Sensed._field_defaults[name])
    return kind(value)


def clamped(name: str, value: float) -> int:
    """Return the whole number nearest to value that the field can hold."""
    low, high = RANGES[name]
    return round(min(high, max(low, value)))
