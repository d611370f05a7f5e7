"""
How a value travels: its format, its range, its unit.

A declaration is written once, as the annotation of a field
(``velocity: Annotated[int, Wire('h', -500, 500, 'mm/s')]``), and everything else is derived
from it. Ranges are checked when a value is about to leave, never when it arrives or is held:
a host must not send nonsense, but a simulator must be able to receive it.
"""

from enum import IntEnum, IntFlag
from operator import index
from typing import Any, NamedTuple

BIG_ENDIAN = '>'
"""Sixteen-bit values are sent high byte first (manual: Sensor Packets; Drive)."""


class Wire(NamedTuple):
    """
    One number on the wire: a struct format, the range the manual allows, unit and names.

    Members of ``names`` outside of ``low`` to ``high`` are allowed too (the special radii of
    Drive); values in ``but`` are not (there is no event 0). A set of flags allows its bits only.
    """

    format: str
    low: int
    high: int
    unit: str = ''
    names: type[IntEnum] | type[IntFlag] | None = None
    but: tuple[int, ...] = ()
    boolean: bool = False
    inverse: bool = False
    """The negative of a named number stands for its inverse (Wait Event)."""

    @property
    def plain(self) -> tuple[int, int]:
        """Between which a number is allowed without a closer look; where names matter, nothing."""
        return (0, -1) if self.names is not None or self.but else (self.low, self.high)

    def allows(self, value: object) -> bool:
        """Tell whether a value may be sent; anything but a whole number may not."""
        try:
            number = index(value)  # type: ignore[arg-type]
        except TypeError:
            return False
        if self.names is None:
            return self.low <= number <= self.high
        if issubclass(self.names, IntFlag):
            return number >= 0 and not number & ~self.mask
        inside = self.low <= number <= self.high or number in self.names._value2member_map_
        return inside and number not in self.but

    @property
    def mask(self) -> int:
        """All bits that have a name; 0 where bits have none."""
        if self.names is None or not issubclass(self.names, IntFlag):
            return 0
        return sum(member.value for member in self.names)

    def describe(self) -> str:
        """Say what is allowed, for an error message and for the documentation."""
        unit = f' {self.unit}' if self.unit else ''
        if self.unit[:1].isdigit():
            unit = f' ({self.unit})'
        if self.mask:
            assert self.names is not None
            bits = ', '.join(f'{member.value} {member.name}' for member in self.names)
            return f'a sum of {bits}'
        text = f'{self.low} to {self.high}{unit}'
        if self.names is not None:
            outside = [m for m in self.names if not self.low <= m.value <= self.high]
            text += ''.join(f', {member.value} {member.name}' for member in outside)
            if self.inverse:
                text += ' (negative for the inverse)'
        return text + ''.join(f', but not {value}' for value in self.but)

    def named(self, value: int) -> Any:
        """Return the truth value or named member that a value is, or the value as it came."""
        if self.boolean:
            return bool(value) if self.low <= value <= self.high else value
        if self.names is None:
            return value
        if issubclass(self.names, IntFlag):
            return self.names(value)
        return self.names._value2member_map_.get(value, value)


class Counted(NamedTuple):
    """A count byte and that many items, each of one or two numbers (``item``)."""

    low: int
    high: int
    item: tuple[Wire, ...]
    noun: str

    def allows(self, count: int) -> bool:
        """Tell whether so many items may be sent."""
        return self.low <= count <= self.high

    @property
    def item_size(self) -> int:
        """Bytes an item takes; every item of the manual is made of single bytes."""
        return len(self.item)

    def describe(self) -> str:
        """Say what is allowed, for an error message and for the documentation."""
        return f'{self.low} to {self.high} {self.noun}'


def choice(code: str, names: type[IntEnum]) -> Wire:
    """Declare a number that must be one of an enumeration's."""
    values = [member.value for member in names]
    return Wire(code, min(values), max(values), names=names)


def signed_choice(code: str, names: type[IntEnum]) -> Wire:
    """Declare a number that must be one of an enumeration's, or the negative of one."""
    most = max(member.value for member in names)
    return Wire(code, -most, most, names=names, but=(0,), inverse=True)


def bits(code: str, names: type[IntFlag]) -> Wire:
    """Declare a number that is a sum of named bits."""
    return Wire(code, 0, sum(member.value for member in names), names=names)
