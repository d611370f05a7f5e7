# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Scripts: commands that the robot stores and plays later (manual: Script, Wait Commands).

A script is a `Script` command whose `script` is the bytes of other commands. Its length is in
bytes: the manual calls it a number of commands, but its own examples count bytes.

The firmware compares a wait's distance or angle with the robot's own motion, with its sign
(manual: Wait Distance, Wait Angle). So a wait never ends if the wheels stand, or turn the other
way. A robot that waits ignores everything but its Power button.
"""

from collections.abc import Iterable, Iterator
from math import copysign, degrees, inf
from typing import NamedTuple

from .codes import DemoNumber, Mode
from .commands import (
    Cover,
    CoverAndDock,
    Demo,
    Drive,
    DriveDirect,
    PlayScript,
    Script,
    Spot,
    Start,
    WaitAngle,
    WaitDistance,
    WaitEvent,
    WaitTime,
    wheel_speeds,
    WheelSpeeds,
)
from .declaration import Command
from .stream import CommandReader, UnknownOpcode

assert Script.tail is not None
SCRIPT_LIMIT = Script.tail.counted.high
"""Largest number of bytes in a script (manual: Script)."""
TENTHS = 10
"""Units of Wait Time in a second."""
STANDING = WheelSpeeds(0.0, 0.0)


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


def can_end(script: Script) -> bool:
    """
    Tell whether a script can end: not if it contains Play Script, which starts it again.

    A script that can end may still wait for ever, see `open_waits`. Unknown opcodes are skipped,
    as the robot does. So is an incomplete last command, although the robot completes it with the
    next bytes that it receives. A script that stores and plays another one counts as endless.
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
    yield from (found for found in reader if isinstance(found, Command))


class EndlessWait(NamedTuple):
    """A wait that never ends, and why."""

    place: int
    """Of the command in the script; the first is 1."""
    command: Command
    why: str


def endless_wait(script: Script, mode: Mode, separation: float) -> EndlessWait | None:
    """
    Return the first wait that never ends in a script that starts at rest, in this mode.

    The separation is in mm. Of a wait while a demo moves the robot in its own way nothing is said.
    """
    for place, (command, speeds, seconds) in enumerate(_timed(script, mode, separation), 1):
        if speeds is not None and seconds == inf:
            return EndlessWait(place, command, _reason(command, speeds))
    return None


def duration(script: Script, mode: Mode, separation: float) -> float | None:
    """
    Return how many seconds a script takes if the wheels turn as requested.

    None where that is not known: it waits for an event, plays a demo, or does not end. The
    script starts at rest, in this mode; the separation is in mm.
    """
    total = 0.0
    for command, speeds, seconds in _timed(script, mode, separation):
        if speeds is None or isinstance(command, WaitEvent | PlayScript):
            return None
        total += seconds
    return total if total < inf else None


def _timed(
    script: Script, mode: Mode, separation: float,
) -> Iterator[tuple[Command, WheelSpeeds | None, float]]:
    """Yield each command, the wheel speeds at it (None: not known), and how long it takes, s."""
    speeds: WheelSpeeds | None = STANDING
    for command in commands_of(script):
        if mode in command.modes:  # else the robot ignores it
            match command:
                case Drive():
                    speeds = wheel_speeds(command.velocity, command.radius, separation)
                case DriveDirect():
                    speeds = WheelSpeeds(command.right, command.left)
                case Start() | Demo(demo=DemoNumber.ABORT):
                    speeds = STANDING
                case Demo() | Cover() | CoverAndDock() | Spot():
                    speeds = None
            mode = mode if command.enters is None else command.enters
        yield command, speeds, _wait_time(command, speeds or STANDING, separation)


def _wait_time(command: Command, speeds: WheelSpeeds, separation: float) -> float:
    """Return how many seconds a command takes at these speeds: a wait some, any other none."""
    match command:
        case WaitTime():
            return command.time / TENTHS
        case WaitDistance():
            return _time_to(command.distance, (speeds.right + speeds.left) / 2)
        case WaitAngle():
            return _time_to(command.angle, degrees((speeds.right - speeds.left) / separation))
        case _:
            return 0.0


def _time_to(goal: float, rate: float) -> float:
    """Return how many seconds it takes to the goal; infinite where it is never reached."""
    if not goal:
        return 0.0
    return goal / rate if rate and copysign(1, goal) == copysign(1, rate) else inf


def _reason(command: Command, speeds: WheelSpeeds) -> str:
    if speeds == STANDING:
        return 'the wheels stand'
    if isinstance(command, WaitAngle):
        turn = speeds.right - speeds.left
        return ('the robot does not turn' if not turn else
                'the robot turns ' + ('counter-clockwise' if turn > 0 else 'clockwise'))
    forward = speeds.right + speeds.left
    return ('the robot turns in place' if not forward else
            'the robot drives ' + ('forwards' if forward > 0 else 'backwards'))
