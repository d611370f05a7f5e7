# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Messages as bytes, with only the numbers that change packed anew. Pure.

rclpy converts every field of a message each time it publishes it. Most fields never change, and
the fields that do always have the same places in the bytes, as long as strings and lengths stay.
So a message is serialized once, the places of the fields are looked up, and from then on the
numbers are packed between the bytes that stay. `Publisher.publish` takes such bytes.

A field is named by its path in the message: `pose.covariance[7]`.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from operator import itemgetter
import re
import struct
from typing import Any, NamedTuple

FORMATS = {
    'boolean': '?', 'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H', 'int32': 'i',
    'uint32': 'I', 'int64': 'q', 'uint64': 'Q', 'float': 'f', 'double': 'd'}
"""The code of `struct` for each type of number in a message."""
MARKS = tuple(range(0x11, 0x19)), tuple(range(0x31, 0x39))
"""Two patterns of bytes, with no byte in common; every number can have them."""
BYTE_ORDER = 1
"""The byte of a serialized message that says the byte order of its numbers; odd: little endian."""
LONGEST_GAP = 7
"""Most bytes between two fields: numbers are aligned to their size."""
PLEASE_REPORT = ('which takes more processor time; please report it, with the versions of ROS and '
                 'of its middleware')
"""End of a warning that a message cannot be packed as bytes."""
Fill = Callable[..., Any]
"""Takes the values of all fields, in order; returns what `Publisher.publish` takes."""


class Slot(NamedTuple):
    """One field of one message, to be set."""

    parent: Any
    key: str | int
    type: str

    def set(self, value: object) -> None:
        """Give the field a value."""
        if isinstance(self.key, int):
            self.parent[self.key] = value
        else:
            setattr(self.parent, self.key, value)


class FieldPlace(NamedTuple):
    """Where a field is in a serialized message."""

    offset: int
    size: int
    format: str
    rank: int
    """Which of the fields it is, in the order of the paths."""


def slot(message: Any, path: str) -> Slot:
    """Find a field in a message."""
    parent, found, type_ = message, message, ''
    key: str | int = ''
    for name, index in re.findall(r'(\w+)|\[(\d+)\]', path):
        parent, key = found, int(index) if index else name
        if name:
            type_ = parent.get_fields_and_field_types()[name]
        found = getattr(parent, name) if name else parent[key]
    return Slot(parent, key, re.sub(r'sequence<([^,>]*).*|\[\d+\]$', r'\1', type_))


def is_number(message: Any, path: str) -> bool:
    """Tell whether a field of a message is a number, or true or false."""
    return slot(message, path).type in FORMATS


def filling(message: Any, paths: Sequence[str]) -> Fill:
    """Return a function that sets the fields of this one message, and returns it."""
    slots = [slot(message, path) for path in paths]

    def fill(*values: object) -> Any:
        for each, value in zip(slots, values, strict=True):
            each.set(value)
        return message
    return fill


class Packing:
    """One serialized message; called with the values of its fields, it returns the bytes."""

    def __init__(self, message: Any, paths: Sequence[str],
                 serialize: Callable[[Any], bytes]) -> None:
        """
        Look up where the fields are; their values in the message are lost.

        ValueError: the place of a field cannot be found.
        """
        template = serialize(message)
        order = _byte_order(template)
        places = _places(message, paths, order, serialize)
        constants: list[bytes] = []
        indices: list[int] = []
        layout = order
        for between, place in _pieces(template, places):
            kept = any(between) or not indices  # one at least: then itemgetter returns a tuple
            layout += f'{len(between)}{"s" if kept else "x"}{place.format}'
            if kept:
                indices.append(len(paths) + len(constants))
                constants.append(between)
            if place.format:
                indices.append(place.rank)
        self._constants = tuple(constants)
        self._in_order = itemgetter(*indices)
        self._pack = struct.Struct(layout).pack

    def __call__(self, *values: float) -> bytes:
        """Return the message with these values."""
        return self._pack(*self._in_order(values + self._constants))


def _byte_order(serialized: bytes) -> str:
    """Return the code of `struct` for the order of bytes in a serialized message."""
    return '<' if serialized[BYTE_ORDER] % 2 else '>'


def _places(message: Any, paths: Sequence[str], order: str,
            serialize: Callable[[Any], bytes]) -> list[FieldPlace]:
    """Find all fields, in the order of their places."""
    return sorted(_place(message, path, rank, order, serialize)
                  for rank, path in enumerate(paths))


def _pieces(template: bytes, places: list[FieldPlace]) -> Iterator[tuple[bytes, FieldPlace]]:
    """Yield each place with the bytes before it; the last one, of no field, is the end."""
    begin = 0
    for place in (*places, FieldPlace(len(template), 0, '', len(places))):
        if place.offset < begin:
            raise ValueError('two fields have the same place')
        yield template[begin:place.offset], place
        begin = place.offset + place.size


def _place(message: Any, path: str, rank: int, order: str,
           serialize: Callable[[Any], bytes]) -> FieldPlace:
    """Find a field: give it two marks in turn, and see where each comes up."""
    field = slot(message, path)
    layout = struct.Struct(order + FORMATS[field.type])
    found: set[int] | None = None
    for mark in _marks(field.type, layout):
        field.set(layout.unpack(mark)[0])
        there = set(_occurrences(mark, serialize(message)))
        found = there if found is None else found & there
    if found is None or len(found) != 1:
        raise ValueError(f'the place of {path} is not certain')
    return FieldPlace(found.pop(), layout.size, FORMATS[field.type], rank)


def _marks(type_: str, layout: struct.Struct) -> list[bytes]:
    """Return what a field is set to in turn; bytes between fields may happen to hold anything."""
    patterns = ((1,), (0,)) if type_ == 'boolean' else MARKS
    return [bytes(pattern[:layout.size]) for pattern in (*patterns, *patterns)]


def _occurrences(mark: bytes, text: bytes) -> Iterator[int]:
    """Yield all places of some bytes in others."""
    at = text.find(mark)
    while at >= 0:
        yield at
        at = text.find(mark, at + 1)


def probes(message: Any, paths: Sequence[str]) -> Iterator[tuple[Any, ...]]:
    """Yield values for all fields, no two neighbours alike; with each set, another sort."""
    types = [slot(message, path).type for path in paths]
    for odd in 0, 1:
        yield tuple(
            (index + odd) % 2 == 1 if type_ == 'boolean'
            else index % 100 + odd if type_ not in ('float', 'double')
            else (index + 0.5) * (-1) ** odd
            for index, type_ in enumerate(types))


def length(message: Any, serialize: Callable[[Any], bytes],
           deserialize: Callable[[bytes, type], Any]) -> int:
    """
    Return how many of its serialized bytes a message needs.

    rclpy may append some, such as the gap before the items of an empty list, and readers that
    are strict refuse them. A message that is published as an object has none.
    """
    whole = serialize(message)
    needed = len(whole)
    with suppress(RuntimeError):  # which rclpy raises for a message that is cut short
        while needed > len(whole) - LONGEST_GAP and deserialize(
                whole[:needed - 1], type(message)) == message:
            needed -= 1
    return needed


def packing(message: Any, paths: Sequence[str], serialize: Callable[[Any], bytes],
            deserialize: Callable[[bytes, type], Any]) -> Packing:
    """
    Return what packs the fields of a message, after a check against the middleware.

    ValueError: that cannot be done, or a packed message would not be what it has to be.
    """
    needed = length(message, serialize, deserialize)
    packed = Packing(message, paths, lambda message: serialize(message)[:needed])
    filled = filling(message, paths)
    for values in probes(message, paths):
        if deserialize(packed(*values), type(message)) != filled(*values):
            raise ValueError('its packed bytes do not say what was packed')
    return packed
