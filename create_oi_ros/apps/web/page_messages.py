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
from ...ros.actions import ACTION_TYPES, malformed
from ...ros.messages import filled
from ...ros.services import SERVICE_TYPES
from .access import Refused, TOP_TURN

CALLS = ('set_mode', 'stop', 'set_leds', 'reset_odometry')
"""The services that a page can call."""


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


def read(text: str) -> tuple[str, dict[str, Any]]:
    """Return the type of a message, and all else in it; Refused: what is wrong."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):  # numbers of thousands of digits, lists in lists
        raise Refused('this is no JSON') from None
    if not isinstance(found, dict):
        raise Refused('allowed is a JSON object with a "type"')
    type_ = found.pop('type', None)
    if not isinstance(type_, str) or type_ not in TYPES:
        raise Refused(f'unknown type; allowed: {", ".join(TYPES)}')
    return type_, found


def checked(type_: str, fields: Mapping[str, Any]) -> PageMessage:
    """Return a message whose fields are as they should be; Refused: what is wrong."""
    if type_ in MESSAGES:
        _check(type_, fields)
        return PageMessage(type_, fields)
    wanted = SERVICE_TYPES[type_].Request if type_ in CALLS else ACTION_TYPES[type_].Goal
    try:
        request = filled(wanted(check_fields=True), fields, type_)
    except ValueError as error:
        raise Refused(str(error)) from None
    if type_ in ACTION_TYPES and (why := malformed(type_, request)):
        raise Refused(f'{type_}: {why}')
    return PageMessage(type_, fields, request)


def _check(type_: str, found: Mapping[str, Any]) -> None:
    fields = MESSAGES[type_]
    if found.keys() != fields.keys():
        raise Refused(f'{type_}: allowed fields: {", ".join(fields) or "none"}')
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
            raise Refused(f'{type_}: {name} is not allowed; allowed: {words}')


def feedback_part(feedback: Any) -> dict[str, Any]:
    """Return a feedback as JSON can say it; a number that is none is left out."""
    found = {name: getattr(feedback, name) for name in feedback.get_fields_and_field_types()}
    return {name: round(value, 3) if isinstance(value, float) else value
            for name, value in found.items()
            if isinstance(value, str) or (isinstance(value, int | float) and isfinite(value))}
