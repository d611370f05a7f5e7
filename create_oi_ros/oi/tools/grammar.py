# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Parses the text form of commands, as `text` writes it and in the variants that people write.

A command is its name and its fields: `name=value`. The parser reads forward only and knows its
position, so that every error names line and column.
"""

from enum import IntEnum, IntFlag
import re
from typing import Any, NamedTuple, NoReturn

from ..codes import BaudCode
from ..commands import COMMANDS, Note, REST, Script
from ..declaration import Command, Tail
from ..packets import PACKET_ID
from ..readings import NUMBERS, PACKETS
from ..script import build_script, SCRIPT_LIMIT
from ..wire import Wire
from .notes import note_number


class TextError(ValueError):
    """An error in the text form: where it is, what is wrong and what is allowed."""

    def __init__(self, text: str, place: int, reason: str) -> None:
        """Take the text, the index of the error, and what is wrong."""
        before = text[:place]
        self.line = before.count('\n') + 1
        """Line of the error, from 1."""
        self.column = place - before.rfind('\n')
        """Column of the error, from 1."""
        self.reason = reason
        super().__init__(f'line {self.line}, column {self.column}: {reason}')


def label(member: IntEnum | IntFlag) -> str:
    """Return the text form of a named number: its lower-case name, or the rate of a baud code."""
    return str(member.rate) if isinstance(member, BaudCode) else str(member.name).lower()


def plain(name: str) -> str:
    """Return a name in lower case, without spaces and punctuation, for comparison."""
    return ''.join(filter(str.isalnum, name)).lower()


BLANK = re.compile(r'(?:[\s;]|#[^\n]*)*')
NAME = re.compile(r'[^\n;{}=#]*')
FIELD = re.compile(r'[ \t]*([^\W\d][\w-]*)[ \t]*=[ \t]*')
ITEM = re.compile(r'[^\s,;{}=#][^\s,;{}=]*')
EQUALS = re.compile(r'[ \t]*=')
COMMA = re.compile(r'\s*,\s*')
SPACES = re.compile(r'[ \t]*')
END = re.compile(r'[ \t\r]*(?=[\n;}#]|\Z)')
NUMBER = re.compile(r'[+-]?(?:0x[0-9a-f]{1,8}|[0-9]{1,9})', re.IGNORECASE)
NOT = re.compile(r'not[-_ ]?|[-!]', re.IGNORECASE)

DEPTH = SCRIPT_LIMIT // len(Script(script=b'').encode())
"""Largest depth of nested scripts: each takes two bytes of the script around it."""

KINDS = {plain(kind.title): kind for kind in COMMANDS}
PACKET_NAMES = {
    plain(name): number for name, number in NUMBERS.items()} | {
    plain(packet.title): number for number, packet in PACKETS.items() if packet.title != 'Unused'}


class Item(NamedTuple):
    """A word of a value, and its index in the text."""

    place: int
    word: str


class Text:
    """A text, and the position of the parser in it."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._depth = 0

    def commands(self, closing: str = '') -> list[Command]:
        """Parse all commands up to the end of the text, or to the closing brace."""
        opened = self._at - len(closing)
        found: list[Command] = []
        while True:
            self._take(BLANK)
            if self._next() == closing:
                self._at += len(closing)
                return found
            if not self._next():
                self._refuse(opened, 'this { is never closed')
            found.append(self._command())

    def _command(self) -> Command:
        start = self._at
        name = self._take(NAME).rstrip()
        if self._next() == '=' and name:
            name = name[:len(name) - len(name.split()[-1])]
            self._at = start + len(name)
        kind = self._kind(start, name.strip())
        values = self._fields(kind)
        if END.match(self._text, self._at) is None:
            self._take(SPACES)
            self._refuse(self._at, f'{kind.title}: expected name=value or line end')
        lacking = [field for field in _declared(kind) if field not in values]
        if lacking:
            self._refuse(start, f'{kind.title} lacks {", ".join(lacking)}')
        command = kind(**values)
        try:
            command.encode()
        except ValueError as refused:
            self._refuse(start, str(refused))
        return command

    def _kind(self, start: int, name: str) -> type[Command]:
        kind = KINDS.get(plain(name))
        if kind is None:
            known = _meant(plain(name))
            self._refuse(start, f'{name or self._next()!r} is not a command; ' + (
                f'did you mean {known}?' if known else
                f'allowed: {", ".join(each.title for each in KINDS.values())}'))
        return kind

    def _fields(self, kind: type[Command]) -> dict[str, Any]:
        declared = {plain(name): name for name in _declared(kind)}
        values: dict[str, Any] = {}
        while (match := FIELD.match(self._text, self._at)) is not None:
            name = declared.get(plain(match[1]))
            if name is None:
                allowed = ', '.join(declared.values()) or 'none'
                self._refuse(
                    match.start(1), f'{kind.title} has no field {match[1]}; allowed: {allowed}')
            if name in values:
                self._refuse(match.start(1), f'{kind.title}: {name} is given twice')
            self._at = match.end()
            values[name] = self._value(kind, name)
        return values

    def _value(self, kind: type[Command], name: str) -> Any:
        if kind.tail is not None and kind.tail.name == name:
            return self._tail(kind, kind.tail)
        wire = dict(kind.fields)[name]
        place = self._at
        items = self._items()
        if len(items) != 1:
            self._refuse(place, f'{kind.title}: {name} needs one value; allowed: {_allowed(wire)}')
        return self._number(f'{kind.title}: {name}', wire, items[0])

    def _tail(self, kind: type[Command], tail: Tail) -> Any:
        if tail.item is bytes and self._next() == '{':
            return self._script()
        name = f'{kind.title}: {tail.name}'
        if tail.item is Note:
            return tuple(self._note(name, tail, item) for item in self._items())
        wire, = tail.counted.item
        numbers = [
            self._number(f'{name}[{at}]', wire, item) for at, item in enumerate(self._items())]
        return bytes(numbers) if tail.item is bytes else tuple(numbers)

    def _script(self) -> bytes:
        opened = self._at
        if self._depth == DEPTH:
            self._refuse(opened, f'Script: scripts are nested more than {DEPTH} deep')
        self._at += 1
        self._depth += 1
        commands = self.commands('}')
        self._depth -= 1
        try:
            return build_script(commands).script
        except ValueError as refused:
            self._refuse(opened, str(refused))

    def _items(self) -> list[Item]:
        items: list[Item] = []
        while (match := ITEM.match(self._text, self._at)) is not None:
            if EQUALS.match(self._text, match.end()):
                break
            items.append(Item(self._at, match[0]))
            self._at = match.end()
            comma = COMMA.match(self._text, self._at)
            if comma is None:
                break
            self._at = comma.end()
        return items

    def _number(self, name: str, wire: Wire, item: Item) -> int:
        number = _number_of(wire, item.word)
        if number is None or not wire.allows(number):
            self._refuse(item.place, f'{name} = {item.word}; allowed: {_allowed(wire)}')
        return number

    def _note(self, name: str, tail: Tail, item: Item) -> Note:
        pitch, colon, duration = item.word.partition(':')
        try:
            if plain(pitch) == 'rest':
                number = REST
            else:
                number = int(pitch) if pitch.isdecimal() else note_number(pitch)
        except ValueError as refused:
            self._refuse(item.place, f'{name}: {refused}')
        if not colon:
            self._refuse(item.place, f'{name} = {item.word}; allowed: note:duration')
        low, high = tail.counted.item
        self._number(f'{name}, note', low, Item(item.place, str(number)))
        place = item.place + len(pitch) + len(colon)
        return Note(number, self._number(f'{name}, duration', high, Item(place, duration)))

    def _next(self) -> str:
        return self._text[self._at:self._at + 1]

    def _take(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self._text, self._at)
        assert match is not None, 'these patterns also match an empty string'
        self._at = match.end()
        return match[0]

    def _refuse(self, place: int, reason: str) -> NoReturn:
        raise TextError(self._text, place, reason)


def _declared(kind: type[Command]) -> list[str]:
    names = [field.name for field in kind.fields]
    return [*names, kind.tail.name] if kind.tail is not None else names


def _meant(name: str) -> str:
    """Return the commands that a wrong name may mean, '' if none: Drive 200 means Drive."""
    begun = [key for key in KINDS if name.startswith(key)]
    if not begun:
        from difflib import get_close_matches  # here: few programs ever need it
        return ', '.join(KINDS[key].title for key in get_close_matches(name, KINDS))
    kind = KINDS[max(begun, key=len)]
    return ' '.join([kind.title, *(f'{field}=...' for field in _declared(kind))])


def _allowed(wire: Wire) -> str:
    """Say what is allowed, with the names of the numbers."""
    if wire is PACKET_ID:
        return f'{wire.describe()} or a name such as {next(iter(NUMBERS))}'
    if wire.names is None or wire.mask:
        return wire.describe()
    return f'{wire.describe()}; or {", ".join(map(label, wire.names))}'


def _number_of(wire: Wire, word: str) -> int | None:
    """Return the number that a word means; None if it is neither a number nor a name."""
    if wire.mask:
        bits = [_named(wire, part) for part in re.split('[+|]', word)]
        return None if None in bits else sum(set(filter(None, bits)))
    named = _named(wire, word)
    if named is None and wire.inverse and (match := NOT.match(word)) is not None:
        positive = _named(wire, word[match.end():])
        return None if positive is None else -positive
    return named


def _named(wire: Wire, word: str) -> int | None:
    if word[:1].isalnum():
        if wire is PACKET_ID and plain(word) in PACKET_NAMES:
            return PACKET_NAMES[plain(word)]
        for member in wire.names or ():
            if plain(label(member)) == plain(word):
                return int(member)
    if NUMBER.fullmatch(word):
        return wire.signed(int(word, 16 if 'x' in word.lower() else 10))
    return None
