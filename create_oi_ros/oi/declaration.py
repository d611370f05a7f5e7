# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Turns the declaration of a command into its encoder and decoder.

A subclass of `Command` states the protocol's facts on its class line and its payload as
annotated fields. No number of the manual stands here: they are all in `commands`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from inspect import Signature, signature
import re
import struct
from typing import Any, ClassVar, dataclass_transform, get_args, get_origin, NamedTuple, Self

from .codes import Mode
from .wire import BIG_ENDIAN, Counted, Wire

WORD_BEGINS = re.compile(r'(?<=[a-z])(?=[A-Z])')


class Field(NamedTuple):
    """One number of a command's payload: its name and how it travels."""

    name: str
    wire: Wire


class Tail(NamedTuple):
    """The last field of a command of varying length: its name, its count, its items' type."""

    name: str
    counted: Counted
    item: type


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Command:
    """
    A command of the Open Interface: every subclass is a frozen, keyword-only dataclass.

    A command may hold values that are out of range; `encode` raises ValueError for them.
    """

    opcode: ClassVar[int]
    title: ClassVar[str]
    """The manual's name: that of the class with spaces, unless it is given."""
    section: ClassVar[str]
    """The manual's section."""
    modes: ClassVar[frozenset[Mode]]
    """The modes in which the robot obeys it."""
    enters: ClassVar[Mode | None]
    """The mode it changes to; None for no change."""
    fields: ClassVar[tuple[Field, ...]]
    tail: ClassVar[Tail | None]
    by_opcode: ClassVar[dict[int, type['Command']]] = {}
    _head: ClassVar[struct.Struct]
    """Opcode, fields and, if there is a tail, its count."""
    __signature__: ClassVar[Signature]
    """What `help` shows: the fields."""

    def __new__(cls, *positional: object, **fields: object) -> Self:
        """Refuse values without a name: their order is easy to confuse."""
        if positional:
            example = ', '.join(f'{name}=...' for name in cls.__signature__.parameters)
            raise TypeError(f'{cls.__name__} takes its fields by name: '
                            f'{cls.__name__}({example}), not {positional!r}')
        return super().__new__(cls)

    def __init_subclass__(
        cls, *, opcode: int, section: str, modes: frozenset[Mode], enters: Mode | None = None,
        title: str = '',
    ) -> None:
        # Without slots=True, which would make a second class that lacks the facts above.
        dataclass(frozen=True, kw_only=True)(cls)
        cls.title = title or WORD_BEGINS.sub(' ', cls.__name__)
        if opcode in cls.by_opcode:
            raise TypeError(
                f'opcode {opcode} of {cls.title} is already that of {cls.by_opcode[opcode].title}')
        cls.opcode, cls.section = opcode, section
        cls.modes, cls.enters = modes, enters
        cls.fields, cls.tail = _declared(cls)
        # Else `inspect.signature` would show __new__, which takes anything.
        _, *parameters = signature(cls.__init__).parameters.values()
        cls.__signature__ = Signature(parameters)
        count = 'B' if cls.tail else ''
        formats = ''.join(field.wire.format for field in cls.fields)
        cls._head = struct.Struct(f'{BIG_ENDIAN}B{formats}{count}')
        cls.by_opcode[opcode] = cls

    def encode(self) -> bytes:
        """Return the bytes to send; ValueError names field, value and range."""
        values = []
        for name, wire in self.fields:
            value = getattr(self, name)
            if not wire.allows(value):
                raise ValueError(refusal(self.title, name, value, wire))
            values.append(value)
        if self.tail is None:
            return self._head.pack(self.opcode, *values)
        items = self._encode_tail(self.tail)
        count = len(items) // self.tail.counted.item_size
        return self._head.pack(self.opcode, *values, count) + items

    def __bytes__(self) -> bytes:
        """Return the bytes to send, as `encode` does."""
        return self.encode()

    def _encode_tail(self, tail: Tail) -> bytes:
        items = getattr(self, tail.name)
        if not isinstance(items, Sequence):
            raise ValueError(
                f'{self.title}: {tail.name} = {items!r}; allowed: {tail.counted.describe()}')
        if not tail.counted.allows(len(items)):
            raise ValueError(
                f'{self.title}: {tail.name} has {len(items)} {tail.counted.noun}; '
                f'allowed: {tail.counted.describe()}')
        encoded = bytearray()
        for place, item in enumerate(items):
            numbers = item if isinstance(item, tuple) else (item,)
            if len(numbers) != tail.counted.item_size:
                raise ValueError(
                    f'{self.title}: {tail.name}[{place}] = {item!r} needs '
                    f'{tail.counted.item_size} numbers')
            for wire, number in zip(tail.counted.item, numbers):
                if not wire.allows(number):
                    raise ValueError(refusal(self.title, f'{tail.name}[{place}]', number, wire))
                encoded.append(number)
        return bytes(encoded)

    @classmethod
    def size(cls, start: bytes | bytearray) -> int:
        """
        Return how many bytes the command has that begins with these bytes.

        While the count of a command of varying length is still missing, this is the number of
        bytes up to and including the count.
        """
        head = cls._head.size
        if cls.tail is None or len(start) < head:
            return head
        return head + start[head - 1] * cls.tail.counted.item_size

    @classmethod
    def decode(cls, encoded: bytes | bytearray) -> Self:
        """
        Return the command that these bytes encode, in range or not.

        ValueError if they belong to another command or are too few or too many.
        """
        if not encoded or encoded[0] != cls.opcode or cls.size(encoded) != len(encoded):
            raise ValueError(
                f'{bytes(encoded)!r} is not one whole {cls.title} command (opcode {cls.opcode})')
        _, *values = cls._head.unpack_from(encoded)
        arguments: dict[str, Any] = {
            field.name: field.wire.named(value) for field, value in zip(cls.fields, values)}
        if cls.tail is not None:
            arguments[cls.tail.name] = _decode_tail(cls.tail, bytes(encoded[cls._head.size:]))
        return cls(**arguments)


def refusal(title: str, name: str, value: object, wire: Wire) -> str:
    """Say what was wrong with a value and what is allowed."""
    return f'{title}: {name} = {value!r}; allowed: {wire.describe()}'


def _declared(cls: type) -> tuple[tuple[Field, ...], Tail | None]:
    """Read the annotated fields of a class: numbers first, then at most one counted tail."""
    fields: list[Field] = []
    tail: Tail | None = None
    for name, annotation in cls.__annotations__.items():
        kind, declaration = get_args(annotation)
        if tail is not None:
            raise TypeError(f'{cls.__name__}.{name} follows a counted field')
        if isinstance(declaration, Counted):
            item = get_args(kind)[0] if get_origin(kind) else kind
            tail = Tail(name, declaration, item)
        else:
            fields.append(Field(name, declaration))
    return tuple(fields), tail


def _decode_tail(tail: Tail, encoded: bytes) -> Any:
    if tail.item is bytes:
        return encoded
    size = tail.counted.item_size
    if size == 1:
        return tuple(encoded)
    return tuple(
        tail.item(*encoded[start:start + size]) for start in range(0, len(encoded), size))
