# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Messages as bytes, of which only the numbers that change are packed anew. Pure.

rclpy converts every field of a message each time it publishes it. Most fields never change, and
the numbers that do always have the same places in the bytes, as long as strings and lengths stay.
So a message is serialized once, and the places of its numbers are calculated.
`Publisher.publish` takes such bytes.

A field is named by its path in the message: `pose.covariance[7]`.
"""

from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from operator import itemgetter
import re
import struct
from typing import Any

CODES = {
    'boolean': '?', 'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H', 'int32': 'i',
    'uint32': 'I', 'int64': 'q', 'uint64': 'Q', 'float': 'f', 'double': 'd'}
"""The code of `struct` for each type of number in a message."""
HEADER = 4
"""Bytes before the first field, which tell the encoding."""
LENGTH = 4
"""Bytes of the length before a string or sequence, aligned as a number."""
ARRAY = re.compile(r'sequence<([^,>]*).*|(.*)\[\d+\]')
"""Type of a sequence or an array; the groups are the types of an item."""


def set_fields(message: Any, values: Mapping[str, Any]) -> Any:
    """Set fields of a message, by their paths, and return it."""
    for path, value in values.items():
        *parents, last = re.findall(r'\w+', path)
        parent = message
        for name in parents:
            parent = parent[int(name)] if name.isdecimal() else getattr(parent, name)
        if last.isdecimal():
            parent[int(last)] = value
        else:
            setattr(parent, last, value)
    return message


def locate(value: Any, type_: str, path: str, offset: int,
           places: dict[str, tuple[str, int]]) -> int:
    """
    Enter each number in a value into `places`, by its path; return where the value ends.

    A place is a code of `struct` and an offset behind the header. This is CDR, as ROS's
    middlewares write it: a number is aligned to its size. ValueError: a type of another kind.
    """
    if type_ in CODES:
        size = struct.calcsize(f'={CODES[type_]}')
        offset += -offset % size
        places[path] = CODES[type_], offset
        return offset + size
    if type_ == 'string':
        return offset + -offset % LENGTH + LENGTH + len(value.encode()) + len(b'\0')
    if array := ARRAY.fullmatch(type_):
        if array[1]:
            offset += -offset % LENGTH + LENGTH
        for index, item in enumerate(value):
            offset = locate(item, array[1] or array[2], f'{path}[{index}]', offset, places)
        return offset
    if not hasattr(value, 'get_fields_and_field_types'):
        raise ValueError(f'{path} is of type {type_}')
    for name, inside in value.get_fields_and_field_types().items():
        offset = locate(getattr(value, name), inside, f'{path}.{name}'.lstrip('.'), offset, places)
    return offset


class SerializedMessage:
    """The bytes of a message; called with the values of its numbers, it returns them."""

    def __init__(self, message: Any, paths: Collection[str], serialize: Callable[[Any], bytes],
                 deserialize: Callable[[bytes, type], Any]) -> None:
        """
        Find the numbers with these paths; their values in the message are lost.

        ValueError: a field is no number, or the middleware does not serialize it as expected.
        """
        places: dict[str, tuple[str, int]] = {}
        length = locate(message, type(message).__name__, '', 0, places)
        if unknown := set(paths) - places.keys():
            raise ValueError(f'{", ".join(sorted(unknown))} is no number')
        text = serialize(message)
        header, body = text[:HEADER], text[HEADER:HEADER + length]  # rclpy may append more
        self._constants = {'header': header}
        """What stands between the numbers, by names that no path has."""
        order, layout, end = ['header'], f'={HEADER}s', 0
        numbers = {}
        for index, path in enumerate(sorted(paths, key=lambda path: places[path][1])):
            code, offset = places[path]
            gap, size = f'until {offset}', struct.calcsize(f'={code}')
            self._constants[gap] = body[end:offset]
            order += [gap, path]
            layout += f'{offset - end}s{code}'
            end = offset + size
            # Neighbours differ, and no number is the same backwards.
            pattern = bytes((index + place) % 2 for place in range(size))
            numbers[path], = struct.unpack(f'={code}', pattern)
        self._constants['the end'] = body[end:]
        self._in_order = itemgetter(*order, 'the end')
        self._pack = struct.Struct(f'{layout}{length - end}s').pack
        with suppress(RuntimeError):  # which rclpy raises for bytes that it cannot read
            if len(body) == length and (
                    deserialize(self(numbers), type(message)) == set_fields(message, numbers)):
                return
        raise ValueError('its bytes do not say what was packed')

    def __call__(self, values: Mapping[str, float]) -> bytes:
        """Return the bytes with these values, of all paths."""
        return self._pack(*self._in_order({**self._constants, **values}))
