# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Scripts: commands that the robot stores and plays later (manual: Script, Wait Commands).

A script is a `Script` command whose `script` is the bytes of other commands. Its length is in
bytes: the manual calls it a number of commands, but its own examples count bytes.
"""

from collections.abc import Iterable, Iterator

from .commands import PlayScript, Script, WaitAngle, WaitDistance, WaitEvent
from .declaration import Command
from .stream import CommandReader, UnknownOpcode

assert Script.tail is not None
SCRIPT_LIMIT = Script.tail.counted.high
"""Largest number of bytes in a script (manual: Script)."""


def build_script(commands: Iterable[Command]) -> Script:
    """
    Return the command that stores these commands as a script; an empty list clears the script.

    ValueError if a command has a value out of range or the script becomes too long.
    """
    script = b''
    for place, command in enumerate(commands, 1):
        script += command.encode()
        if len(script) > SCRIPT_LIMIT:
            raise ValueError(
                f'Script: command {place} ({command.title}) brings it to {len(script)} bytes; '
                f'allowed: {SCRIPT_LIMIT} bytes')
    return Script(script=script)


def commands_of(script: Script) -> list[Command]:
    """Return the commands in a script; ValueError if its bytes are not whole commands."""
    reader = CommandReader()
    reader.feed(script.script)
    commands: list[Command] = []
    for found in reader:
        if isinstance(found, UnknownOpcode):
            raise ValueError(f'Script: {found.data[0]} is not an opcode')
        commands.append(found)
    if reader.pending:
        title = Command.by_opcode[reader.pending[0]].title
        raise ValueError(f'Script: its last command, {title}, is cut short')
    return commands


def script_of_reply(reply: bytes) -> Script:
    """
    Return the script in a reply to Show Script, which is a count and the bytes.

    ValueError if the count does not match the number of bytes.
    """
    return Script.decode(bytes([Script.opcode]) + reply)


def can_end(script: Script) -> bool:
    """
    Tell whether a script can end: not if it contains Play Script, which starts it again.

    A script that can end may still wait for ever, see `open_waits`; while it waits, the robot
    ignores all input, a stop included. Unknown opcodes are skipped, as the robot does. So is an
    incomplete last command, although the robot completes it with the next bytes that it
    receives. A script that stores and plays another script counts as one that cannot end.
    """
    return not any(isinstance(command, PlayScript) for command in _read(script))


def open_waits(script: Script) -> list[Command]:
    """
    Return the waits of a script that may never end: those for a distance, an angle, an event.

    If the wheels are blocked, lifted or not driven, or if the event never happens, the robot
    waits and ignores all input until its power is switched off. Wait Time always ends.
    """
    waits = (WaitDistance, WaitAngle, WaitEvent)
    return [command for command in _read(script) if isinstance(command, waits)]


def _read(script: Script) -> Iterator[Command]:
    reader = CommandReader()
    reader.feed(script.script)
    for found in reader:
        if isinstance(found, Command):
            yield found
