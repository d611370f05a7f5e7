# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers and choices that people write: in world files, as guesses, on the control socket."""

from dataclasses import fields
from enum import Enum
import math
from typing import Any

LONGEST = 40
"""Characters of a wrong word that an error repeats: a file may hold anything."""
TOLERANCE = 1e-6
"""Seconds by which a sum of floats may fall short of the time it stands for."""


def number(text: str) -> float:
    """Return the finite number that a text is; ValueError for any other text."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f'{text[:LONGEST]!r} is not a number')
    return value


def guess_defaults(guesses: type) -> dict[str, Any]:
    """Return the fields of a dataclass that can be given as text, and their defaults."""
    return {field.name: field.default for field in fields(guesses)
            if isinstance(field.default, bool | int | float | Enum)}


def guessed(name: str, text: str, default: Any) -> Any:
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
