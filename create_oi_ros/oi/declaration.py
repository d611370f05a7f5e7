"""
The machinery that turns a declaration of a command into its encoder and decoder.

A subclass of `Command` states the protocol's facts on its class line and its payload as
annotated fields. No number of the manual stands here: they are all in `commands`.
"""

from collections.abc import Sequence
import struct
from typing import (
    Any,
    ClassVar,
    dataclass_transform,
    get_args,
    get_origin,
    NamedTuple,
    NoReturn,
    Self,
)

from .codes import Mode
from .wire import BIG_ENDIAN, Counted, Wire


class Field(NamedTuple):
    """One field of a command's payload: its name and how it travels."""

    name: str
    wire: Wire


class Tail(NamedTuple):
    """The last field of a command whose length varies: its name, its count, its items' type."""

    name: str
    counted: Counted
    item: type


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Command:
    """
    A command of the Open Interface, an immutable value with keyword-only fields.

    Holding a value out of range is allowed, sending it is not: `encode` raises ValueError.
    Type checkers take subclasses for frozen dataclasses. They are not made by `dataclasses`,
    which would take longer to load than all the rest of this package.
    """

    opcode: ClassVar[int]
    title: ClassVar[str]
    """The manual's name."""
    section: ClassVar[str]
    """The manual's section."""
    modes: ClassVar[frozenset[Mode]]
    """The modes in which the robot obeys it."""
    enters: ClassVar[Mode | None]
    """The mode it changes to; None for no change."""
    fields: ClassVar[tuple[Field, ...]]
    tail: ClassVar[Tail | None]
    by_opcode: ClassVar[dict[int, type['Command']]] = {}
    _names: ClassVar[dict[str, None]]
    _checks: ClassVar[tuple[tuple[str, int, int, Wire], ...]]
    """Name, between which a plain number is right, and what tells of all others."""
    _head: ClassVar[struct.Struct]

    def __init_subclass__(
        cls, *, opcode: int, title: str, section: str,
        modes: frozenset[Mode], enters: Mode | None = None,
    ) -> None:
        if opcode in cls.by_opcode:
            raise TypeError(
                f'opcode {opcode} of {title} is already that of {cls.by_opcode[opcode].title}')
        cls.opcode, cls.title, cls.section = opcode, title, section
        cls.modes, cls.enters = modes, enters
        cls.fields, cls.tail = _declared(cls)
        cls._names = dict.fromkeys(cls.__annotations__)
        cls._checks = tuple((name, *wire.plain, wire) for name, wire in cls.fields)
        count = 'B' if cls.tail else ''
        formats = ''.join(field.wire.format for field in cls.fields)
        cls._head = struct.Struct(f'{BIG_ENDIAN}B{formats}{count}')
        cls.by_opcode[opcode] = cls

    def __init__(self, **values: Any) -> None:
        if values.keys() != self._names.keys():
            wanted = ', '.join(self._names) or 'no fields'
            raise TypeError(f'{self.title} has {", ".join(values) or "no fields"}; needs {wanted}')
        self.__dict__.update(values)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f'{self.title} cannot be changed; make a new one')

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other.__dict__ == self.__dict__

    def __hash__(self) -> int:
        return hash((self.opcode, *(getattr(self, name) for name in self._names)))

    def __repr__(self) -> str:
        values = ', '.join(f'{name}={getattr(self, name)!r}' for name in self._names)
        return f'{type(self).__name__}({values})'

    def encode(self) -> bytes:
        """Return the bytes to send; ValueError names field, value and range."""
        held, values = self.__dict__, []
        for name, low, high, wire in self._checks:
            value = held[name]
            # Most often it is a plain number in its range, and needs no closer look.
            if not (type(value) is int and low <= value <= high) and not wire.allows(value):
                raise ValueError(refusal(self.title, name, value, wire))
            values.append(value)
        if self.tail is None:
            return self._head.pack(self.opcode, *values)
        items = self._encode_tail(self.tail)
        count = len(items) // self.tail.counted.item_size
        return self._head.pack(self.opcode, *values, count) + items

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
        Tell how many bytes a command that begins so takes, as far as they can tell.

        While the count of a command of varying length has not arrived, that is the number of
        bytes up to and with the count.
        """
        head = cls._head.size
        if cls.tail is None or len(start) < head:
            return head
        return head + start[head - 1] * cls.tail.counted.item_size

    @classmethod
    def decode(cls, encoded: bytes | bytearray) -> Self:
        """
        Return the command that whole bytes stand for, whatever their values.

        Raises ValueError where the bytes are of another command, too few or too many.
        """
        if not encoded or encoded[0] != cls.opcode or cls.size(encoded) != len(encoded):
            raise ValueError(f'{bytes(encoded)!r} is no whole {cls.title} ({cls.opcode})')
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
