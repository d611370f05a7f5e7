# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a field of a page's message may be. Pure."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class FieldCheck(NamedTuple):
    """What a field may be: a test and its description."""

    passes: Callable[[Any], bool]
    allowed: str


def is_number(value: Any) -> bool:
    """Return whether a value of JSON is a number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def number(low: float, high: float) -> FieldCheck:
    """Return a check for a number within limits; NaN is outside of them."""
    return FieldCheck(lambda value: is_number(value) and low <= value <= high,
                 f'a number from {low:g} to {high:g}')


def whole(low: int, high: int) -> FieldCheck:
    """Return a check for a whole number within limits."""
    return FieldCheck(lambda value: isinstance(value, int) and is_number(value)
                 and low <= value <= high, f'a whole number from {low} to {high}')


def one_of(*allowed: str) -> FieldCheck:
    """Return a check for one of some texts."""
    return FieldCheck(lambda value: isinstance(value, str) and value in allowed,
                 ', '.join(allowed))


def number_or_null(low: float, high: float) -> FieldCheck:
    """Return a check for a number within limits, or null."""
    given = number(low, high)
    return FieldCheck(lambda value: value is None or given.passes(value),
                 f'{given.allowed}, or null')


FLAG = FieldCheck(lambda value: isinstance(value, bool), 'true or false')
