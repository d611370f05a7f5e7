# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which values of a command the robot accepts; hosts may send any."""

from ...oi import Command
from ...oi.codes import Radius
from ...oi.commands import RADIUS
from ...oi.declaration import Tail
from ...oi.readings import SPEED
from .guesses import Guesses, LongRadius


def obeyable(command: Command, guesses: Guesses) -> Command | None:
    """
    Return the command with values that the robot accepts; None if it ignores the command.

    Velocities are clamped; bits without a meaning and long radii follow the guesses.
    """
    if command.tail is not None and not _tail_allowed(command, command.tail):
        return None
    changed: dict[str, int] = {}
    for field in command.fields:
        value, wire = getattr(command, field.name), field.wire
        if wire.allows(value):
            continue
        if wire is SPEED:
            changed[field.name] = max(SPEED.low, min(SPEED.high, value))
        elif wire is RADIUS and guesses.long_radius is LongRadius.CLAMP:
            changed[field.name] = max(RADIUS.low, min(RADIUS.high, value))
        elif wire is RADIUS and guesses.long_radius is LongRadius.STRAIGHT:
            changed[field.name] = Radius.STRAIGHT
        elif wire.mask and guesses.mask_bits:
            changed[field.name] = value & wire.mask
        else:
            return None
    if not changed:
        return command
    values = {field.name: getattr(command, field.name) for field in command.fields}
    return type(command)(**{**values, **changed})


def _tail_allowed(command: Command, tail: Tail) -> bool:
    items = getattr(command, tail.name)
    return tail.counted.allows(len(items)) and all(
        wire.allows(number) for item in items for wire, number in zip(
            tail.counted.item, item if isinstance(item, tuple) else (item,), strict=True))
