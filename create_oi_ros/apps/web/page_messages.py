# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a page may send: messages of its own, goals of actions, and requests of some services.

A goal or a request is sent as the fields that it has in ROS; what is left out has its default.
"""

from __future__ import annotations

from collections.abc import Mapping
import json
from math import isfinite
from typing import Any, NamedTuple

from ...robot import TOP_SPEED
from ...ros.actions import malformed
from ...ros.driver_client import ACTION_TYPES, SERVICE_TYPES
from ...ros.messages import filled
from .access import TOP_TURN

CALLS = ('set_mode', 'stop', 'set_leds', 'reset_odometry')
"""The services that a page can call."""


class MessageError(ValueError):
    """A message is wrong; the text says what is wrong and what is allowed."""

    def __init__(self, text: str, to: str = '') -> None:
        """Take also the message's type, as far as that is known."""
        super().__init__(text)
        self.to = to


MESSAGES: Mapping[str, Mapping[str, tuple[float, float] | list[Any]]] = {
    'drive': {'linear': (-TOP_SPEED, TOP_SPEED), 'angular': (-TOP_TURN, TOP_TURN),
              'seen': (0, 1e12)},
    'release': {},
    'take_over': {},
    'leave': {},
    'cancel': {'what': ['goal', 'tune']},
    'ping': {},
    'record': {'on': [True, False]},
}
"""Each message of a page's own by its `type`; of each field the limits, or all that is allowed."""
TYPES = (*MESSAGES, *CALLS, *ACTION_TYPES)


class PageMessage(NamedTuple):
    """A message that is as it should be."""

    type: str
    fields: Mapping[str, Any]
    request: Any = None
    """For an action or a service: what is sent to it."""


def read(text: str) -> PageMessage:
    """Read a message; MessageError says what is wrong."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):  # numbers of thousands of digits, lists in lists
        raise MessageError('this is no JSON') from None
    if not isinstance(found, dict):
        raise MessageError('allowed is a JSON object with a "type"')
    type_ = found.pop('type', None)
    if not isinstance(type_, str) or type_ not in TYPES:
        raise MessageError(f'unknown type; allowed: {", ".join(TYPES)}')
    try:
        return PageMessage(type_, found, _request(type_, found))
    except ValueError as error:
        raise MessageError(str(error), type_) from None


def _request(type_: str, found: Mapping[str, Any]) -> Any:
    """Return what is sent to an action or a service, if any; ValueError: what is wrong."""
    if type_ in MESSAGES:
        _check(type_, found)
        return None
    if type_ in CALLS:
        return filled(SERVICE_TYPES[type_].Request(check_fields=True), found, type_)
    goal = filled(ACTION_TYPES[type_].Goal(check_fields=True), found, type_)
    if why := malformed(type_, goal):
        raise ValueError(f'{type_}: {why}')
    return goal


def _check(type_: str, found: Mapping[str, Any]) -> None:
    fields = MESSAGES[type_]
    if found.keys() != fields.keys():
        raise ValueError(f'{type_}: allowed fields: {", ".join(fields) or "none"}')
    for name, allowed in fields.items():
        value = found[name]
        if isinstance(allowed, tuple):
            low, high = allowed
            words = f'{low:g} to {high:g}'
            fits = type(value) in (int, float) and low <= value <= high
        else:
            choices = [json.dumps(each) for each in allowed]
            fits, words = json.dumps(value) in choices, ' or '.join(choices)
        if not fits:
            raise ValueError(f'{type_}: {name} is not allowed; allowed: {words}')


def feedback_part(feedback: Any) -> dict[str, Any]:
    """Return a feedback as JSON can say it; a number that is none is left out."""
    found = {name: getattr(feedback, name) for name in feedback.get_fields_and_field_types()}
    return {name: round(value, 3) if isinstance(value, float) else value
            for name, value in found.items()
            if isinstance(value, str) or (isinstance(value, int | float) and isfinite(value))}
