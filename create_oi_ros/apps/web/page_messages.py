# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a page may send: each message, its fields, what they may be, and goals' requests. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import json
from math import isfinite, pi
from typing import Any, NamedTuple

from create_oi_msgs import action

from ...driver.goals.goal import LONGEST, MOST_TURN
from ...driver.goals.wall_following import RIGHT
from ...driver.outputs import LONGEST_NOTE
from ...oi import Mode, Song, SOUNDING
from ...robot import TOP_SPEED
from ...ros.messages import duration, of_yaw
from .driver_seat import TOP_TURN


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


# Goals.

LEAST_SPEED, LEAST_TURN, LEAST_RADIUS = 0.01, 0.05, 0.01
"""m/s, rad/s and metres: 0 would never arrive."""
LONGEST_WALL = 3600.0
"""Seconds for which a wall is followed at most."""
SPEED, TURN = number(LEAST_SPEED, TOP_SPEED), number(LEAST_TURN, TOP_TURN)
WAY, ANGLE = number(-LONGEST, LONGEST), number(-MOST_TURN, MOST_TURN)
Fields = Mapping[str, Any]


class PageGoal(NamedTuple):
    """A goal: the checks of its fields, and the function that makes a request of them."""

    checks: Mapping[str, FieldCheck]
    request: Callable[[Fields], Any]


def _drive_distance(fields: Fields) -> Any:
    return action.DriveDistance.Goal(
        distance=float(fields['distance']), max_translation_speed=float(fields['speed']))


def _rotate_angle(fields: Fields) -> Any:
    return action.RotateAngle.Goal(
        angle=float(fields['angle']), max_rotation_speed=float(fields['turn']))


def _drive_arc(fields: Fields) -> Any:
    backward = fields['backward']
    goal = action.DriveArc.Goal
    return goal(
        angle=float(fields['angle']), radius=float(fields['radius']),
        max_translation_speed=float(fields['speed']),
        translate_direction=goal.TRANSLATE_BACKWARD if backward else goal.TRANSLATE_FORWARD)


def _navigate(fields: Fields) -> Any:
    made, heading = action.NavigateToPosition.Goal(), fields['heading']
    made.max_translation_speed = float(fields['speed'])
    made.achieve_goal_heading = heading is not None
    pose = made.goal_pose.pose
    pose.position.x, pose.position.y = float(fields['x']), float(fields['y'])
    pose.orientation.z, pose.orientation.w = of_yaw(float(heading or 0.0))
    return made


def _wall_follow(fields: Fields) -> Any:
    return action.WallFollow.Goal(
        follow_side=RIGHT, max_runtime=duration(float(fields['seconds'])))


GOALS: Mapping[str, PageGoal] = {
    'drive_distance': PageGoal({'distance': WAY, 'speed': SPEED}, _drive_distance),
    'rotate_angle': PageGoal({'angle': ANGLE, 'turn': TURN}, _rotate_angle),
    'drive_arc': PageGoal({'angle': ANGLE, 'radius': number(LEAST_RADIUS, LONGEST),
                           'speed': SPEED, 'backward': FLAG}, _drive_arc),
    'navigate_to_position': PageGoal(
        {'x': WAY, 'y': WAY, 'heading': number_or_null(-2 * pi, 2 * pi), 'speed': SPEED},
        _navigate),
    'dock': PageGoal({}, lambda _: action.Dock.Goal()),
    'undock': PageGoal({}, lambda _: action.Undock.Goal()),
    'wall_follow': PageGoal({'seconds': number(1, LONGEST_WALL)}, _wall_follow),
}
"""All goals, by the names of their actions."""


def feedback_part(feedback: Any) -> dict[str, Any]:
    """Return a feedback as JSON can say it; a number that is none is left out."""
    found = {name: getattr(feedback, name) for name in feedback.get_fields_and_field_types()}
    return {name: round(value, 3) if isinstance(value, float) else value
            for name, value in found.items() if isfinite(value)}


# Messages.

assert Song.tail is not None
LONGEST_SONG = Song.tail.counted.high
"""Notes."""
LOWEST_NOTE, HIGHEST_NOTE = SOUNDING[0], SOUNDING[-1]


class MessageError(ValueError):
    """A message is wrong; the text says what is wrong and what is allowed."""


def _is_note(note: Any) -> bool:
    return (isinstance(note, list) and len(note) == 2
            and whole(LOWEST_NOTE, HIGHEST_NOTE).passes(note[0])
            and number(0, LONGEST_NOTE).passes(note[1]))


NOTES = FieldCheck(
    lambda value: isinstance(value, list) and 0 < len(value) <= LONGEST_SONG
    and all(map(_is_note, value)),
    f'1 to {LONGEST_SONG} pairs of a note from {LOWEST_NOTE} to {HIGHEST_NOTE} and its seconds')
MESSAGES: Mapping[str, Mapping[str, FieldCheck]] = {
    'drive': {'linear': number(-TOP_SPEED, TOP_SPEED), 'angular': number(-TOP_TURN, TOP_TURN),
              'seen': number(0, 1e12)},
    'release': {},
    'stop': {},
    'take_over': {},
    'leave': {},
    'mode': {'mode': one_of(*(mode.name.lower() for mode in Mode if mode is not Mode.OFF))},
    'song': {'notes': NOTES},
    'leds': {'play': FLAG, 'advance': FLAG, 'color': whole(0, 255), 'intensity': whole(0, 255)},
    'reset_odometry': {},
    'cancel': {},
    'ping': {},
    'record': {'on': FLAG},
    **{name: goal.checks for name, goal in GOALS.items()},
}
"""Each message by its `type`, with the checks of its fields."""


class PageMessage(NamedTuple):
    """A message that is as it should be."""

    type: str
    fields: Mapping[str, Any]


def read(text: str) -> PageMessage:
    """Read a message; MessageError says what is wrong."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):  # numbers of thousands of digits, lists in lists
        raise MessageError('this is no JSON') from None
    if not isinstance(found, dict):
        raise MessageError('allowed is a JSON object with a "type"')
    type_ = found.pop('type', None)
    if not isinstance(type_, str) or type_ not in MESSAGES:
        raise MessageError(f'unknown type; allowed: {", ".join(MESSAGES)}')
    checks = MESSAGES[type_]
    if found.keys() != checks.keys():
        raise MessageError(f'{type_}: allowed fields: {", ".join(checks) or "none"}')
    for name, check in checks.items():
        if not check.passes(found[name]):
            raise MessageError(f'{type_}: {name} is not allowed; allowed: {check.allowed}')
    return PageMessage(type_, found)
