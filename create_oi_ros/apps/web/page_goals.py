# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The goals that a page may send: each with its fields, and the request that it becomes. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite, pi
from typing import Any, NamedTuple

from create_oi_msgs import action

from ...driver.goals.goal import LONGEST, MOST_TURN
from ...driver.goals.wall_following import RIGHT
from ...robot import TOP_SPEED
from ...ros.messages import duration, of_yaw
from .driver_seat import TOP_TURN
from .page_checks import FieldCheck, FLAG, number, number_or_null

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
