# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Commands as text, and back: the manual's names, one command a line.

    # Drive 40 cm and stop.
    Drive velocity=300 radius=straight
    Wait Distance distance=400
    Drive velocity=0 radius=0

Every field is given by name. Case, spaces and punctuation in names do not matter: `wait_distance`
and `WaitDistance` are the same. A number is decimal, or hexadecimal with 0x. Numbers that have a
name in the manual may be given by name; they are written in lower case with underscores:

    Demo demo=cover_and_dock               Baud code=57600
    LEDs bits=play+advance color=0 intensity=128
    Wait Event event=not_bump              # or not-bump, -bump, -5
    Song number=0 notes=C#4:32,rest:16     # or 61:32; durations in 64ths of a second
    Stream packets=29,13                   # or cliff_front_left_signal,virtual_wall
    Script script={Drive velocity=300 radius=straight; Wait Time time=20; Play Script}

Commands are separated by line ends or semicolons. A comment begins with # at the start of a line
or after a space. Every command whose values are in range is the same after writing and reading.

The parser reads forward only and knows its position, so that every error names line and column.
"""

from contextlib import suppress
from enum import IntEnum, IntFlag
import re
from typing import Any, NamedTuple, NoReturn

from ..codes import BaudCode
from ..commands import COMMANDS, Note, REST, Script
from ..declaration import Command, Tail
from ..packets import PACKET_ID
from ..readings import NUMBERS, PACKETS
from ..script import build_script, commands_of, SCRIPT_LIMIT
from ..wire import Wire
from .tunes import NOTE_NUMBER, note_number, note_text

# Commands to text.

def label(member: IntEnum | IntFlag) -> str:
    """Return the text form of a named number: its lower-case name, or the rate of a baud code."""
    return str(member.rate) if isinstance(member, BaudCode) else str(member.name).lower()


def plain(name: str) -> str:
    """Return a name in lower case, without spaces and punctuation, for comparison."""
    return ''.join(filter(str.isalnum, name)).lower()


def format_command(command: Command) -> str:
    """Return a command as a line of text; its values may be out of range."""
    words = [command.title]
    for name, wire in command.fields:
        words.append(f'{name}={format_number(wire, getattr(command, name))}')
    if command.tail is not None:
        name, _, item = command.tail
        words.append(f'{name}={_format_items(item, getattr(command, name))}')
    return ' '.join(words)


def format_number(wire: Wire, value: int) -> str:
    """Return a number by its name, or its bits by theirs, where these have names."""
    if wire.names is None:
        return str(int(value))
    if wire.mask:
        bits = [label(bit) for bit in wire.names if value & bit]
        return '+'.join(bits) if bits and not value & ~wire.mask else str(int(value))
    members = {member.value: label(member) for member in wire.names}
    if wire.inverse and -value in members:
        return f'not_{members[-value]}'
    return members.get(value, str(int(value)))


def _format_items(item: type, value: Any) -> str:
    """Return a tail: of a script its commands, or its bytes if these are no commands in range."""
    if item is bytes:
        with suppress(ValueError):
            commands = commands_of(Script(script=value))
            build_script(commands)
            return '{' + '; '.join(map(format_command, commands)) + '}'
    if item is Note:
        return ','.join(f'{note_text(number)}:{duration}' for number, duration in value)
    return ','.join(str(int(number)) for number in value)


# Text to commands.

class TextError(ValueError):
    """An error in the text form: where it is, what is wrong and what is allowed."""

    def __init__(self, text: str, place: int, reason: str) -> None:
        """Take the text, the index of the error, and what is wrong."""
        before = text[:place]
        line, column = before.count('\n') + 1, place - before.rfind('\n')
        super().__init__(f'line {line}, column {column}: {reason}')


def parse_commands(text: str) -> list[Command]:
    """Return the commands in a text; TextError names line, column and what is allowed."""
    return Text(text).commands('')


def parse_script(text: str) -> Script:
    """Return the command that stores the commands in a text as a script; TextError as above."""
    if len(text) > LONGEST_TEXT:
        raise TextError(text, LONGEST_TEXT, (
            f'the text of a script has {len(text)} characters; allowed: {LONGEST_TEXT}'))
    commands = parse_commands(text)
    try:
        return build_script(commands)
    except ValueError as refused:
        raise TextError(text, len(text), str(refused)) from None


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

LONGEST_TEXT = 100 * SCRIPT_LIMIT
"""Characters of a script, comments included: the driver waits while they are read."""
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
        lacking = [field for field in kind.__signature__.parameters if field not in values]
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
        declared = {plain(name): name for name in kind.__signature__.parameters}
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
                number = int(pitch) if NOTE_NUMBER.fullmatch(pitch) else note_number(pitch)
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


def _meant(name: str) -> str:
    """Return the commands that a wrong name may mean, '' if none: Drive 200 means Drive."""
    begun = [key for key in KINDS if name.startswith(key)]
    if not begun:
        from difflib import get_close_matches  # here: few programs ever need it
        return ', '.join(KINDS[key].title for key in get_close_matches(name, KINDS))
    kind = KINDS[max(begun, key=len)]
    return ' '.join([kind.title, *(f'{field}=...' for field in kind.__signature__.parameters)])


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
