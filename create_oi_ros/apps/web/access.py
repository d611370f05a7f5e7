# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Who may open the page, what it may send and how much, and who drives. Pure: time is an argument.

A goal or a request is sent as the fields that it has in ROS; what is left out has its default.

One viewer at a time has the driver's seat. A command holds for a moment, and the page sends the
next one earlier. So the wheels stop soon after a page is closed, a phone sleeps, or the network
fails.
"""

from __future__ import annotations

from collections.abc import Mapping
from ipaddress import ip_address
import json
from typing import Any
from urllib.parse import urlsplit

from ...robot import TOP_SPEED, WHEEL_SEPARATION
from ...ros.actions import ACTION_TYPES, malformed
from ...ros.messages import filled
from ...ros.services import SERVICE_TYPES

MOST_VIEWERS = 8
"""Pages that are connected at once."""
LONGEST_MESSAGE = 4096
"""Bytes of one message from a page."""
RATE, BURST = 60.0, 120.0
"""Messages a second that a page may send for long, and at once."""
OLDEST_VIEW = 0.5
"""Seconds: a page whose picture is older than this may not drive. It includes the way there."""
TOP_TURN = TOP_SPEED / (WHEEL_SEPARATION / 2)
"""rad/s at which both wheels run at top speed, in opposite directions."""
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


def is_loopback(host: str) -> bool:
    """Return whether an address, or the name `localhost`, means this computer only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def names_this_computer(header: str) -> bool:
    """
    Return whether the Host header of a request is a name of this computer.

    Without a token no other name is answered: a page of another site can point a name of its own
    at 127.0.0.1, and would then count as the same site (DNS rebinding).
    """
    try:
        return is_loopback(urlsplit(f'//{header}').hostname or '')
    except ValueError:  # it cannot be read
        return False


class Refused(Exception):
    """A viewer may not do this now; the message says why and what to do."""


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


def checked(type_: str, fields: Mapping[str, Any]) -> Any:
    """Return the request or goal of these fields, or those of MESSAGES; Refused: why not."""
    if type_ in MESSAGES:
        _check(type_, fields)
        return fields
    wanted = SERVICE_TYPES[type_].Request if type_ in CALLS else ACTION_TYPES[type_].Goal
    try:
        request = filled(wanted(check_fields=True), fields, type_)
    except ValueError as error:
        raise Refused(str(error)) from None
    if type_ in ACTION_TYPES and (why := malformed(type_, request)):
        raise Refused(f'{type_}: {why}')
    return request


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


class DriverSeat:
    """The seat of the only viewer that may drive; viewers are numbers."""

    def __init__(self) -> None:
        self.viewer: int | None = None
        """Who has the seat."""
        self.driving = False
        """Whether a command holds."""
        self.latched = False
        """Whether STOP was pressed, and the stick has not been let go since."""

    def sit(self, viewer: int) -> None:
        """Take the seat if it is free; Refused: another viewer has it."""
        if self.viewer is None:
            self.viewer, self.latched = viewer, False
        if self.viewer != viewer:
            raise Refused('another page drives: press "Take over" first')

    def take_over(self, viewer: int) -> bool:
        """Take the seat, whoever has it; return whether the wheels must stop now."""
        if viewer == self.viewer:
            return False
        self.viewer = viewer
        return self._end()

    def leave(self, viewer: int) -> bool:
        """Free the seat if this viewer has it; return whether the wheels must stop now."""
        if viewer != self.viewer:
            return False
        self.viewer = None
        return self._end()

    def drive(self, viewer: int, view_age: float) -> bool:
        """
        Take a command; return whether to obey it, False: it is too old, or STOP still holds.

        `view_age` is the age, s, of the newest picture that the page had when it sent this. After
        a gap in the network, old commands arrive all at once: their pictures are old, too.
        """
        self.sit(viewer)
        if self.latched or not -OLDEST_VIEW < view_age <= OLDEST_VIEW:
            return False
        self.driving = True
        return True

    def release(self, viewer: int) -> bool:
        """Let the stick go; return whether the wheels must stop now."""
        return viewer == self.viewer and self._end()

    def stop(self) -> None:
        """Stop, whoever asks; the stick must be let go before it drives again."""
        self._end()
        self.latched = True

    def expire(self) -> bool:
        """End the command: no other one came in time; return whether one held."""
        was_driving, self.driving = self.driving, False
        return was_driving

    def _end(self) -> bool:
        self.latched = False
        return self.expire()
