"""
Scripts: commands that the robot keeps and plays later (manual: Script Commands, Wait Commands).

A script is a `Script` command whose `script` is the bytes of other commands. Its length byte
counts bytes: the manual calls it a number of commands, but its own examples count bytes.
"""

from collections.abc import Iterable, Iterator

from .commands import PlayScript, Script, WaitAngle, WaitDistance, WaitEvent
from .declaration import Command
from .stream import CommandReader, UnknownOpcode

assert Script.tail is not None
SCRIPT_LIMIT = Script.tail.counted.high
"""Bytes that a script may have (manual: Script)."""


def build_script(commands: Iterable[Command]) -> Script:
    """
    Return the command that stores a script of these commands; none of them clears the script.

    ValueError where a command may not be sent, or names the command that goes beyond the limit.
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
    """Return the commands in a script; ValueError where its bytes are not whole commands."""
    reader = CommandReader()
    reader.feed(script.script)
    commands: list[Command] = []
    while (found := reader.next_event()) is not None:
        if isinstance(found, UnknownOpcode):
            raise ValueError(f'Script: {found.data[0]} is the opcode of no command')
        commands.append(found)
    if reader.pending:
        title = Command.by_opcode[reader.pending[0]].title
        raise ValueError(f'Script: its last command, {title}, is cut short')
    return commands


def script_of_reply(reply: bytes) -> Script:
    """
    Return the script that the robot told of in its reply to Show Script: a count and the bytes.

    ValueError where the count is not that of the bytes.
    """
    return Script.decode(bytes([Script.opcode]) + reply)


def can_end(script: Script) -> bool:
    """
    Tell whether a script can end: not if it comes to a Play Script, which starts it again.

    True is no promise that it will end. While a script waits the robot hears nothing, a stop
    included, and what `open_waits` returns may be waited for without end. Bytes that are no
    command are passed over, as the robot does; so is a last command that is cut short, although
    it will take its missing bytes from what is sent to the robot next. That a script may store
    another one before it plays it is not followed up: it counts as one that cannot end.
    """
    return not any(isinstance(command, PlayScript) for command in _read(script))


def open_waits(script: Script) -> list[Command]:
    """
    Return the waits of a script whose end is not up to the script: for distance, angle, event.

    The wheels may be blocked, lifted or not driven at all, the bumper never hit: the robot
    waits on, deaf, until its power is switched off. A Wait Time always ends.
    """
    waits = (WaitDistance, WaitAngle, WaitEvent)
    return [command for command in _read(script) if isinstance(command, waits)]


def _read(script: Script) -> Iterator[Command]:
    reader = CommandReader()
    reader.feed(script.script)
    while (found := reader.next_event()) is not None:
        if isinstance(found, Command):
            yield found
