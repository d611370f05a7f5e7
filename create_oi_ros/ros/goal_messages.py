# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Fills the feedback and the results of the actions. Pure."""

from typing import Any

from builtin_interfaces.msg import Duration
from create_oi_msgs.action import Dock, NavigateToPosition

from ..driver.goals import Code, Ending, Phase, Progress
from ..oi.codes import BEAMS, FORCE_FIELD, GREEN_BUOY, RED_BUOY
from .messages import NANOSECONDS
from .rotation import of_yaw

PHASES = {
    Phase.TURNING_TO_PLACE: NavigateToPosition.Feedback.ROTATING_TO_GOAL_POSITION,
    Phase.DRIVING: NavigateToPosition.Feedback.DRIVING_TO_GOAL_POSITION,
    Phase.TURNING_TO_HEADING: NavigateToPosition.Feedback.ROTATING_TO_GOAL_ORIENTATION,
}
SEARCH = {
    Phase.LOOKING: Dock.Feedback.LOOKING, Phase.SEES_DOCK: Dock.Feedback.SEES_DOCK,
    Phase.DOCKED: Dock.Feedback.DOCKED, Phase.CHARGING: Dock.Feedback.CHARGING,
}


def seconds(duration: Duration) -> float:
    """Return a duration in seconds."""
    return float(duration.sec + duration.nanosec / NANOSECONDS)


def duration(length: float) -> Duration:
    """Return a duration from seconds."""
    sec, nanosec = divmod(round(length * NANOSECONDS), NANOSECONDS)
    return Duration(sec=sec, nanosec=nanosec)


def distance_left(feedback: Any, progress: Progress) -> None:
    """Fill in the distance that is left."""
    feedback.remaining_travel_distance = progress.distance


def angle_left(feedback: Any, progress: Progress) -> None:
    """Fill in the angle that is left."""
    feedback.remaining_angle_travel = progress.angle


def phase_left(feedback: Any, progress: Progress) -> None:
    """Fill in the phase, and what is left of it."""
    if progress.phase is not None:
        feedback.navigate_state = PHASES[progress.phase]
    feedback.remaining_angle_travel = progress.angle
    feedback.remaining_travel_distance = progress.distance


def dock_seen(feedback: Any, progress: Progress) -> None:
    """Fill in how far the search for the dock is, and what of it is seen."""
    beams = max(0, progress.infrared - BEAMS)
    feedback.state = SEARCH.get(progress.phase or Phase.LOOKING, Dock.Feedback.LOOKING)
    feedback.sees_dock = bool(beams)
    feedback.red_buoy = bool(beams & RED_BUOY)
    feedback.green_buoy = bool(beams & GREEN_BUOY)
    feedback.force_field = bool(beams & FORCE_FIELD)


def wall_engaged(feedback: Any, progress: Progress) -> None:
    """Fill in whether a wall is followed."""
    feedback.engaged = progress.phase is Phase.ENGAGED


def fill_result(result: Any, ending: Ending) -> None:
    """Fill in how a goal ended; the header of its pose is filled already."""
    result.success = ending.code is Code.NONE
    result.error_code = ending.code
    result.message = ending.text
    position = result.pose.pose.position
    position.x, position.y = ending.estimate.x, ending.estimate.y
    turned = result.pose.pose.orientation
    turned.z, turned.w = of_yaw(ending.estimate.yaw)
    if hasattr(result, 'is_docked'):
        result.is_docked = ending.docked
    if hasattr(result, 'runtime'):
        result.runtime = duration(ending.seconds)
