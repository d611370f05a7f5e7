# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How a value travels: its format, its range, its unit.

A declaration is written once, as the annotation of a field
(`time: Annotated[int, Wire('B', 0, 255, '1/10 s')]`). Everything else is derived from it.
Ranges are checked when a value is sent, not when it arrives or is stored: a host must not send
nonsense, but a simulator must be able to receive it.
"""

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from functools import cached_property
from operator import index
from struct import calcsize
from typing import Any

BIG_ENDIAN = '>'
"""Sixteen-bit values are sent high byte first (manual: Sensor Packets; Drive)."""


@dataclass(frozen=True)
class Wire:
    """
    One number on the wire: a struct format, the range the manual allows, unit and names.

    Members of `names` outside of `low` to `high` are allowed too (the special radii of Drive).
    Where the names are flags, only their bits are allowed.
    """

    format: str
    low: int
    high: int
    unit: str = ''
    names: type[IntEnum] | type[IntFlag] | None = None
    boolean: bool = False
    inverse: bool = False
    """Whether the negative of a named number means its inverse, and 0 nothing (Wait Event)."""

    @cached_property
    def allowed(self) -> range | frozenset[int]:
        """The numbers that may be sent."""
        inside = range(self.low, self.high + 1)
        if self.mask:
            return frozenset(number for number in inside if not number & ~self.mask)
        if self.names is None:
            return inside
        return frozenset(inside).union(self._values).difference((0,) if self.inverse else ())

    @property
    def size(self) -> int:
        """Its bytes."""
        return calcsize(self.format)

    @property
    def limits(self) -> tuple[int, int]:
        """The least and the greatest number that its bytes can hold."""
        numbers = 1 << 8 * self.size
        return (-numbers // 2, numbers // 2 - 1) if self.format.islower() else (0, numbers - 1)

    def signed(self, value: int) -> int:
        """Return a named number that was written without its sign, such as hex 8000, with it."""
        return value if value <= self.high else self._values.get(
            value + 2 * self.limits[0], value)

    def allows(self, value: object) -> bool:
        """Tell whether a value may be sent; only a whole number may."""
        try:
            return index(value) in self.allowed  # type: ignore[arg-type]
        except TypeError:
            return False

    @cached_property
    def _values(self) -> dict[int, IntEnum | IntFlag]:
        """Named numbers by value."""
        return {member.value: member for member in self.names or ()}

    @cached_property
    def mask(self) -> int:
        """All bits that have a name; 0 if bits have no names."""
        if self.names is None or not issubclass(self.names, IntFlag):
            return 0
        return sum(self._values)

    def without_spare_bits(self, value: int) -> int | None:
        """Return a number without the bits that mean nothing; None where it holds no bits."""
        bits = 1 if self.boolean else self.mask
        return value & bits if bits else None

    def describe(self) -> str:
        """Say what is allowed, for an error message and for the documentation."""
        unit = f' {self.unit}' if self.unit else ''
        if self.unit[:1].isdigit():
            unit = f' ({self.unit})'
        if self.mask:
            bits = ', '.join(f'{value} {member.name}' for value, member in self._values.items())
            return f'a sum of {bits}'
        text = f'{self.low} to {self.high}{unit}'
        text += ''.join(f', {value} {member.name}' for value, member in self._values.items()
                        if not self.low <= value <= self.high)
        return text + (' (negative for the inverse), but not 0' if self.inverse else '')

    def named(self, value: int | None) -> Any:
        """Return a number as a truth value or named member; unchanged if it is neither."""
        if value is None:
            return None
        if self.boolean:
            return bool(value) if value in self.allowed else value
        if self.names is not None and self.mask:
            return self.names(value)
        return self._values.get(value, value)


@dataclass(frozen=True)
class Counted:
    """A count byte and as many items, each of one or two numbers (`item`)."""

    low: int
    high: int
    item: tuple[Wire, ...]
    noun: str

    def allows(self, count: int) -> bool:
        """Tell whether this many items may be sent."""
        return self.low <= count <= self.high

    @property
    def item_size(self) -> int:
        """Bytes of an item; every number of every item in the manual is a single byte."""
        return len(self.item)

    def describe(self) -> str:
        """Say what is allowed, for an error message and for the documentation."""
        return f'{self.low} to {self.high} {self.noun}'


def choice(code: str, names: type[IntEnum]) -> Wire:
    """Declare a number that must be a member of an enumeration."""
    values = [member.value for member in names]
    return Wire(code, min(values), max(values), names=names)


def signed_choice(code: str, names: type[IntEnum]) -> Wire:
    """Declare a number that must be a member of an enumeration, or the negative of one."""
    most = max(member.value for member in names)
    return Wire(code, -most, most, names=names, inverse=True)


def bits(code: str, names: type[IntFlag]) -> Wire:
    """Declare a number that is a sum of named bits."""
    return Wire(code, 0, sum(member.value for member in names), names=names)
