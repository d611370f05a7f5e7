# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Messages as bytes, of which only the numbers that change are packed anew. Pure.

rclpy converts every field of a message each time it publishes it. Most fields never change, and
the numbers that do always have the same places in the bytes, as long as strings and lengths stay.
So a message is serialized once, and the places of its numbers are looked up.
`Publisher.publish` takes such bytes.

A field is named by its path in the message: `pose.covariance[7]`.
"""

from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from operator import itemgetter
import re
import struct
from typing import Any, NamedTuple

FORMATS = {
    'boolean': '?', 'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H', 'int32': 'i',
    'uint32': 'I', 'int64': 'q', 'uint64': 'Q', 'float': 'f', 'double': 'd'}
"""The code of `struct` for each type of number in a message."""
MARKS = bytes(range(0x11, 0x19)), bytes(range(0x31, 0x39))
"""Two numbers of up to eight bytes, all of which differ."""
ATTEMPTS = 5
"""Times that a message is serialized with each mark."""
LONGEST_GAP = 7
"""Most bytes between two fields: numbers are aligned to their size."""


class MessageField(NamedTuple):
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


def field(message: Any, path: str) -> MessageField:
    """Find a field in a message."""
    parent, found, type_ = message, message, ''
    key: str | int = ''
    for name, index in re.findall(r'(\w+)|\[(\d+)\]', path):
        parent, key = found, int(index) if index else name
        if name:
            type_ = parent.get_fields_and_field_types()[name]
        found = getattr(parent, name) if name else parent[key]
    return MessageField(parent, key, re.sub(r'sequence<([^,>]*).*|\[\d+\]$', r'\1', type_))


def filled(message: Any, values: Mapping[str, Any]) -> Any:
    """Set fields of a message, by their paths, and return it."""
    for path, value in values.items():
        field(message, path).set(value)
    return message


class SerializedMessage:
    """The bytes of a message; called with the values of its numbers, it returns them."""

    def __init__(self, message: Any, paths: Collection[str], serialize: Callable[[Any], bytes],
                 deserialize: Callable[[bytes, type], Any]) -> None:
        """
        Find the numbers with these paths; their values in the message are lost.

        ValueError: a field is no number, or the middleware does not serialize it as expected.
        """
        places = {path: _place(message, path, serialize) for path in paths}
        text = _shortest(message, serialize, deserialize)
        self._constants: dict[str, bytes] = {}
        """What stands between the numbers, by names that no path has."""
        order, layout, end = [], '=', 0
        for path, (code, offset) in sorted(places.items(), key=lambda each: each[1][1]):
            gap = f'until {offset}'
            self._constants[gap] = text[end:offset]
            order += [gap, path]
            layout += f'{offset - end}s{code}'
            end = offset + struct.calcsize(f'={code}')
        self._constants['the end'] = text[end:]
        self._in_order = itemgetter(*order, 'the end')
        self._pack = struct.Struct(f'{layout}{len(text) - end}s').pack
        numbers = {path: struct.unpack(f'={code}', bytes([index % 2]) * struct.calcsize(code))[0]
                   for index, (path, (code, _)) in enumerate(places.items())}
        if deserialize(self(numbers), type(message)) != filled(message, numbers):
            raise ValueError('its bytes do not say what was packed')

    def __call__(self, values: Mapping[str, float]) -> bytes:
        """Return the bytes with these values, of all paths."""
        return self._pack(*self._in_order({**self._constants, **values}))


def _place(message: Any, path: str, serialize: Callable[[Any], bytes]) -> tuple[str, int]:
    """
    Return a number's code of `struct`, and its offset in the bytes.

    That is the only place where the bytes are those of each value that it gets.
    """
    found = field(message, path)
    if found.type not in FORMATS:
        raise ValueError(f'{path} is no number')
    layout = struct.Struct(f'={FORMATS[found.type]}')
    marks = (b'\0', b'\1') if found.type == 'boolean' else MARKS
    # The gaps between fields hold anything, which differs from time to time.
    places: set[int] | None = None
    for _ in range(ATTEMPTS):
        for mark in marks:
            found.set(layout.unpack(mark[:layout.size])[0])
            text = serialize(message)
            here = {place.start() for place in re.finditer(
                b'(?=%s)' % re.escape(mark[:layout.size]), text)}
            places = here if places is None else places & here
        if places is not None and len(places) == 1:
            return FORMATS[found.type], places.pop()
    raise ValueError(f'the place of {path} is not certain')


def _shortest(message: Any, serialize: Callable[[Any], bytes],
              deserialize: Callable[[bytes, type], Any]) -> bytes:
    """
    Return a serialized message without bytes that it does not need.

    rclpy may append some, such as the gap before the items of an empty list, and readers that
    are strict refuse them. A message that is published as an object has none.
    """
    whole = serialize(message)
    needed = len(whole)
    with suppress(RuntimeError):  # which rclpy raises for a message that is cut short
        while needed > len(whole) - LONGEST_GAP and deserialize(
                whole[:needed - 1], type(message)) == message:
            needed -= 1
    return whole[:needed]
