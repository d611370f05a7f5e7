# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the manual leaves open about the firmware, each with the switch that turns the guess.

`Create(body, guesses=Guesses(boot_seconds=0.0))`, or `create_sim --guess boot_seconds=0`.
`accepted_command` says which values of a command the robot accepts; hosts may send any.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import Enum
import math
from typing import Any

from ...oi import Command
from ...oi.commands import RADIUS
from ...oi.declaration import Tail
from ...oi.readings import SPEED
from ...robot import SLOT
from .. import LONGEST, number
from ..body.config import BodyConfig, DEFAULT_BODY


@dataclass(frozen=True, slots=True, kw_only=True)
class Guesses:
    """Every undocumented choice of the firmware; the defaults are what we think most likely."""

    boot_seconds: float = 3.0
    """The boot loader runs so long after power-on: digital outputs are high (manual: Digital
    Outputs), and nothing is heard (guess)."""
    banner: bool = True
    """Some 140 bytes of ASCII are said at power-on (reported)."""
    opcode_7_resets: bool = True
    """The undocumented opcode 7 restarts the robot (reported)."""
    dock_ends_safe: bool = False
    """The Home Base counts as 'charger plugged in and powered' in Safe. If it did, no robot could
    leave its dock in Safe."""
    dock_holds_safe: bool = True
    """Docked in Safe, the wheels do not turn until the battery is full (reported)."""
    dock_charges: bool = True
    """Passive, entered on the contacts of a Home Base, begins to charge; else only a restart does
    (reported of some)."""
    passive_ends_drivers: bool = True
    """Passive switches the low side drivers off; else they run on, and obey no command there."""
    stream_while_waiting: bool = True
    """The stream goes on while a script waits."""
    wait_queue: int = 256
    """Bytes that arrive during a wait and are obeyed after it; more are lost, and 0 loses all (the
    manual: no reaction; programs of many people count on a queue, one of them on 135 bytes)."""
    wait_answers: bool = False
    """Requests for packets are answered during a wait (one report); else they wait, too."""
    loop_listens: bool = True
    """Between the rounds of a script that plays itself the host's bytes are obeyed (a library
    counts on it; a manual says the opposite)."""
    mask_bits: bool = True
    """Bits without a meaning in LEDs, Low Side Drivers and Digital Outputs are taken as 0
    (reported of LEDs: 139 25 0 128 lights them). Else the robot ignores the command."""
    overrun: bool = False
    """At 115200, bytes less than 200 microseconds apart are lost (manual: Baud, 'may'). Bytes
    received in one call count as sent back to back."""
    frame_period: float = SLOT
    """Seconds of a slot by the computer's clock (manual: 15 ms; of Create 2 0.015625 was measured,
    of Create 1 nothing was published)."""
    transmit_buffer: int = 256
    """Bytes that may wait for the wire; a stream that asks for more than a slot holds loses
    what does not fit, and so is corrupted (manual: Stream)."""

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            low, high = (0.005, 0.1) if each.name == 'frame_period' else (0.0, math.inf)
            if not (low <= value <= high and math.isfinite(value)):
                raise ValueError(f'{each.name} is {value}; allowed: {low:g} to {high:g}')


DEFAULT_GUESSES = Guesses()


TIME_CONSTANT = {
    'time_constant': 'seconds', 'time_constant_exponent': 'exponent',
    'time_constant_slowest': 'slowest', 'time_constant_fastest': 'fastest'}
"""Names of guesses, and the fields of the wheels' time constant that they set."""


def parse_guesses(texts: Sequence[str]) -> tuple[BodyConfig, Guesses]:
    """Read 'name=value' texts about body and firmware; ValueError says what is allowed."""
    of_body, of_firmware = _defaults(BodyConfig), _defaults(Guesses)
    body: dict[str, Any] = {}
    firmware: dict[str, Any] = {}
    constant = DEFAULT_BODY.time_constant
    for text in texts:
        name, _, value = text.partition('=')
        if name in of_body:
            body[name] = _guessed(name, value, of_body[name])
        elif name in of_firmware:
            firmware[name] = _guessed(name, value, of_firmware[name])
        elif name in TIME_CONSTANT:
            constant = constant._replace(**{TIME_CONSTANT[name]: _guessed(name, value, 0.0)})
        else:
            known = (*of_firmware, *of_body, *TIME_CONSTANT)
            raise ValueError(f'no guess {name!r}; allowed: {", ".join(known)}')
    return BodyConfig(time_constant=constant, **body), Guesses(**firmware)


def _defaults(guesses: type) -> dict[str, Any]:
    """Return the fields of a dataclass that can be given as text, and their defaults."""
    return {field.name: field.default for field in fields(guesses)
            if isinstance(field.default, bool | int | float | Enum)}


def _guessed(name: str, text: str, default: Any) -> Any:
    """Return the value of a guess, of its default's type; ValueError says what is allowed."""
    kind = type(default)
    allowed: dict[str, Any]
    if issubclass(kind, Enum):
        allowed = {str(each.value): each for each in kind}
    elif kind is bool:
        allowed = {'0': False, 'false': False, '1': True, 'true': True}
    else:
        try:
            return kind(number(text)) if kind is float else kind(text)
        except ValueError:
            raise ValueError(f'{name}: {text[:LONGEST]!r} is not a number') from None
    if text not in allowed:
        raise ValueError(f'{name}={text}; allowed: {", ".join(allowed)}')
    return allowed[text]


def accepted_command(command: Command, guesses: Guesses) -> Command | None:
    """
    Return the command with values that the robot accepts; None if it ignores the command.

    Velocities and radii are clamped; bits without a meaning follow the guess.
    """
    if command.tail is not None and not _tail_allowed(command, command.tail):
        return None
    changed: dict[str, int] = {}
    for field in command.fields:
        value, wire = getattr(command, field.name), field.wire
        if wire.allows(value):
            continue
        if wire in (SPEED, RADIUS):
            # A library sends radii beyond 2000 mm, and could not drive a robot that ignores them.
            changed[field.name] = max(wire.low, min(wire.high, value))
        elif wire.mask and guesses.mask_bits:
            changed[field.name] = value & wire.mask
        else:
            return None
    return type(command)(**{**vars(command), **changed}) if changed else command


def _tail_allowed(command: Command, tail: Tail) -> bool:
    items = getattr(command, tail.name)
    return tail.counted.allows(len(items)) and all(
        wire.allows(number) for item in items for wire, number in zip(
            tail.counted.item, item if isinstance(item, tuple) else (item,), strict=True))
