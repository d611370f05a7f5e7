# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Guesses about the body, as `create_sim --guess NAME=VALUE` takes them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from enum import Enum
from typing import Any

from ..number_text import number
from .config import BodyConfig, CENTRE
from .wheel_log import WheelLog

TIME_CONSTANT = {
    'time_constant': 'seconds', 'time_constant_exponent': 'exponent',
    'time_constant_slowest': 'slowest', 'time_constant_fastest': 'fastest'}
"""Names of guesses, and the fields of the time constant that they set."""
RECORDING = 'recording'
"""The name of the guess that is a file: a log of real wheels."""


def names() -> tuple[str, ...]:
    """Return the names of all guesses about the body."""
    plain = (field.name for field in fields(BodyConfig)
             if isinstance(getattr(CENTRE, field.name), (float, Enum)))
    return (*plain, *TIME_CONSTANT, RECORDING)


def parse(texts: Sequence[str], read: Callable[[str], str]) -> tuple[BodyConfig, list[str]]:
    """
    Read 'name=value' texts; return the body, and the texts that are about something else.

    `read` returns what a file contains.
    """
    config, rest, known = CENTRE, [], names()
    for text in texts:
        name, _, value = text.partition('=')
        if name not in known:
            rest.append(text)
        elif name in TIME_CONSTANT:
            constant = config.time_constant._replace(
                **{TIME_CONSTANT[name]: _number(name, value)})
            config = replace(config, time_constant=constant)
        elif name == RECORDING:
            config = replace(config, recording=_recording(value, read))
        else:
            changed: dict[str, Any] = {name: _value(name, value)}
            config = replace(config, **changed)
    return config, rest


def _value(name: str, text: str) -> float | Enum:
    default = getattr(CENTRE, name)
    return choice(name, text, type(default)) if isinstance(default, Enum) else _number(name, text)


def choice(name: str, text: str, kind: type[Enum]) -> Enum:
    """Read the value of a guess that is one of several; ValueError says which."""
    try:
        return kind(text)
    except ValueError:
        allowed = ', '.join(str(each.value) for each in kind)
        raise ValueError(f'{name}={text}: one of {allowed} is wanted') from None


def _number(name: str, text: str) -> float:
    try:
        return number(text)
    except ValueError as error:
        raise ValueError(f'{name}: {error}') from None


def _recording(text: str, read: Callable[[str], str]) -> WheelLog:
    try:
        return WheelLog.parse(read(text))
    except (OSError, KeyError) as error:
        raise ValueError(f'{RECORDING}={text}: {error}') from None
