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
"""

from collections.abc import Iterable
from typing import Any

from ..commands import Note, REST, Script, SOUNDING
from ..declaration import Command
from ..script import build_script, commands_of
from ..wire import Wire
from .grammar import label, Text, TextError
from .notes import note_name


def format_command(command: Command) -> str:
    """Return a command as a line of text; its values may be out of range."""
    words = [command.title]
    for name, wire in command.fields:
        words.append(f'{name}={_format_number(wire, getattr(command, name))}')
    if command.tail is not None:
        name, _, item = command.tail
        words.append(f'{name}={_format_items(item, getattr(command, name))}')
    return ' '.join(words)


def format_commands(commands: Iterable[Command]) -> str:
    """Return commands as text, one line each."""
    return ''.join(f'{format_command(command)}\n' for command in commands)


def _format_number(wire: Wire, value: int) -> str:
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
    if item is bytes:
        return _format_script(value)
    if item is Note:
        return ','.join(f'{_format_note(number)}:{duration}' for number, duration in value)
    return ','.join(str(int(number)) for number in value)


def _format_note(number: int) -> str:
    if number in SOUNDING:
        return note_name(number)
    return 'rest' if number == REST else str(number)


def _format_script(script: bytes) -> str:
    """Return the commands of a script, or its bytes if they are not commands in range."""
    try:
        commands = commands_of(Script(script=script))
        build_script(commands)
    except ValueError:
        return ','.join(map(str, script))
    return '{' + '; '.join(map(format_command, commands)) + '}'


def parse_commands(text: str) -> list[Command]:
    """Return the commands in a text; TextError names line, column and what is allowed."""
    return Text(text).commands('')


def parse_command(text: str) -> Command:
    """Return the command in a text; TextError also if there is none or more than one."""
    commands = parse_commands(text)
    if len(commands) != 1:
        raise TextError(text, 0, f'{len(commands)} commands; expected one')
    return commands[0]


def parse_script(text: str) -> Script:
    """Return the command that stores the commands in a text as a script; TextError as above."""
    commands = parse_commands(text)
    try:
        return build_script(commands)
    except ValueError as refused:
        raise TextError(text, len(text), str(refused)) from None
