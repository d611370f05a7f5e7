# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The actions: each declared beside the function that turns its request into what the driver does.

The driver pursues goals, one at a time, and plays tunes beside them. Here they are checked, handed
over, reported on and answered. Only a malformed request is rejected, with the
reason in the log; any other is accepted, and its result says why it could not be done.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from create_oi_msgs.action import (
    AudioNoteSequence,
    Dock,
    DriveArc,
    DriveDistance,
    NavigateToPosition,
    RotateAngle,
    Undock,
)
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import Header

from ..driver import Driver, goals
from ..driver.goal_control import CANCELED, CLIENT_GONE
from ..driver.goals import Code, Goal, Phase
from ..driver.goals.goal import Over
from ..driver.songs import Tune
from ..link.session import Session
from ..oi.codes import BEAMS, FORCE_FIELD, GREEN_BUOY, RED_BUOY
from ..oi.tools.tunes import note_text, parse_tune
from .messages import of_yaw, seconds, Values, yaw_of
from .parameters import Parameters
from .publishing import StampClock
from .services import answer, future_of, QUEUE, shortened
from .topics import GOAL_POSE

FEEDBACK_EVERY = 7
"""Frames from one feedback to the next: ten a second."""
RESULT_KEPT = 60
"""Seconds for which a client can still ask for the result of a goal that has ended."""
CLIENT_LOST_CHECKS = 2
"""Checks of the graph, one a second, without a client of the goal, after which it is ended."""
PHASES: dict[Phase | None, int] = {
    Phase.TURNING_TO_PLACE: NavigateToPosition.Feedback.ROTATING_TO_GOAL_POSITION,
    Phase.DRIVING: NavigateToPosition.Feedback.DRIVING_TO_GOAL_POSITION,
    Phase.TURNING_TO_HEADING: NavigateToPosition.Feedback.ROTATING_TO_GOAL_ORIENTATION,
}


def distance_left(goal: Goal) -> Values:
    return {'remaining_travel_distance': goal.progress.distance}


def angle_left(goal: Goal) -> Values:
    return {'remaining_angle_travel': goal.progress.angle}


def phase_left(goal: Goal) -> Values:
    """Return the phase, and what is left of it."""
    return {'navigate_state': PHASES.get(goal.progress.phase, 0),
            **distance_left(goal), **angle_left(goal)}


def dock_seen(goal: Goal) -> Values:
    """Return how far the search for the dock is, and what of it is seen."""
    beams = max(0, goal.progress.infrared - BEAMS)
    return {'state': getattr(Dock.Feedback, (goal.progress.phase or Phase.LOOKING).name),
            'sees_dock': bool(beams), 'red_buoy': bool(beams & RED_BUOY),
            'green_buoy': bool(beams & GREEN_BUOY), 'force_field': bool(beams & FORCE_FIELD)}


def note_played(tune: Tune) -> Values:
    """Return the note that sounds."""
    return {'note': note_text(tune.notes[tune.note].number), 'place': tune.note,
            'iterations_played': tune.iterations_played,
            'current_runtime': Duration(seconds=tune.seconds).to_msg()}


def tune(request: Any) -> Tune:
    """Return the tune of a request; ValueError says what is wrong."""
    if request.iterations != request.INFINITE and request.iterations < 1:
        raise ValueError(f'iterations = {request.iterations}; allowed: above 0, or '
                         f'{request.INFINITE}, until it is canceled')
    return Tune(parse_tune(request.notes), request.iterations)


def goal_result(goal: Goal) -> Values:
    """Return how a goal ended; its pose gets a header yet."""
    assert goal.outcome is not None
    at = goal.estimate
    z, w = of_yaw(at.yaw)
    pose = Pose(position=Point(x=at.x, y=at.y), orientation=Quaternion(z=z, w=w))
    return {**answer(goal.outcome), 'error_code': goal.code, 'pose': PoseStamped(pose=pose)}


def tune_result(tune: Tune) -> Values:
    assert tune.outcome is not None
    return {**answer(tune.outcome), 'runtime': Duration(seconds=tune.seconds).to_msg(),
            'iterations_played': tune.iterations_played}


@dataclass(frozen=True, kw_only=True)
class Action:
    """One action; unless its row says otherwise, one that drives the robot."""

    name: str
    type: Any
    about: str
    make: Callable[[Any], Any]
    """Turns a request into what the driver does; ValueError says what is wrong with it."""
    start: Callable[[Driver, Any, float], object] = (
        lambda driver, goal, now: driver.goals.start(goal, now))
    """Hands that to the driver, with the time, s."""
    cancel: Callable[[Driver, Any, float, Over], object] = (
        lambda driver, goal, now, why: driver.goals.cancel(goal, now, why))
    """Ends it, if it has not ended, and says why."""
    feedback: Callable[[Any], Values]
    """Returns the fields of feedback."""
    news: Callable[[Any, int], object] = lambda goal, frames: frames // FEEDBACK_EVERY
    """Returns what must change for feedback to be sent, after so many frames."""
    result: Callable[[Any], Values] = goal_result
    """Returns the fields of the result."""


ACTIONS = (
    Action(
        name='drive_distance', type=DriveDistance, about='drive straight, also backwards',
        make=lambda goal: goals.DriveDistance(
            goal.distance, goal.max_translation_speed, seconds(goal.time_allowance)),
        feedback=distance_left),
    Action(
        name='rotate_angle', type=RotateAngle, about='turn in place, any number of turns',
        make=lambda goal: goals.RotateAngle(
            goal.angle, goal.max_rotation_speed, seconds(goal.time_allowance)),
        feedback=angle_left),
    Action(
        name='drive_arc', type=DriveArc, about='drive on a circle',
        make=lambda goal: goals.DriveArc(
            goal.angle, goal.radius, goal.translate_direction,
            goal.max_translation_speed, seconds(goal.time_allowance)),
        feedback=angle_left),
    Action(
        name='navigate_to_position', type=NavigateToPosition,
        about='turn to a place in `odom_frame`, drive there straight, turn to a heading',
        make=lambda goal: goals.NavigateToPosition(
            goal.goal_pose.pose.position.x, goal.goal_pose.pose.position.y,
            yaw_of(goal.goal_pose.pose.orientation) if goal.achieve_goal_heading else None,
            goal.max_translation_speed, goal.max_rotation_speed, seconds(goal.time_allowance)),
        feedback=phase_left),
    Action(
        name='dock', type=Dock, about='look for the Home Base and charge there',
        make=lambda goal: goals.Dock(seconds(goal.time_allowance)), feedback=dock_seen,
        result=lambda goal: {**goal_result(goal), 'is_docked': goal.docked}),
    Action(
        name='undock', type=Undock, about='leave the Home Base, 30 cm backwards',
        make=lambda goal: goals.Undock(seconds(goal.time_allowance)),
        feedback=distance_left),
    Action(
        name='audio_note_sequence', type=AudioNoteSequence,
        about='play a tune of any length: notes with their seconds, or a ring tone (RTTTL)',
        make=tune, start=lambda driver, tune, now: driver.songs.play_tune(tune, now),
        cancel=lambda driver, tune, _, why: driver.songs.cancel(tune, why.text),
        feedback=note_played,
        news=lambda tune, _: (tune.iterations_played, tune.note), result=tune_result),
)
ACTION_TYPES: dict[str, Any] = {action.name: action.type for action in ACTIONS}


def malformed(name: str, request: Any) -> str:
    """Say what is wrong with a goal of the action of this name; empty: nothing in itself."""
    action, = (each for each in ACTIONS if each.name == name)
    try:
        action.make(request)
    except ValueError as error:
        return shortened(str(error))
    return ''


class Pursued:
    """A request that the driver follows, and the goal of the client that waits for its end."""

    def __init__(self, action: Action, started: Any, handle: ServerGoalHandle) -> None:
        self.action, self.started, self.handle = action, started, handle
        self._frames = 0
        self._news = action.news(started, 0)
        self.unheard = 0
        """Checks of the graph in a row that showed no client."""

    def report(self) -> None:
        """Send feedback where there is news; called in every frame."""
        self._frames += 1
        before, self._news = self._news, self.action.news(self.started, self._frames)
        if self._news != before and self.started.outcome is None:
            self.handle.publish_feedback(
                self.action.type.Feedback(**self.action.feedback(self.started)))

    def cancel(self, session: Session, why: Over = CANCELED) -> None:
        """End what was started, if it has not ended."""
        with session.request() as (driver, now):
            self.action.cancel(driver, self.started, now, why)


class Actions:
    """The servers of all actions."""

    def __init__(
        self, node: Node, session: Session, parameters: Parameters, stamps: StampClock,
    ) -> None:
        """Offer all actions, each with a queue for many clients."""
        self._stamps = stamps
        self._node = node
        self._session = session
        self._odom_frame = parameters.odom_frame
        self._pursued: list[Pursued] = []
        for action in ACTIONS:
            ActionServer(
                node, action.type, action.name, partial(self._execute, action),
                callback_group=ReentrantCallbackGroup(),
                goal_callback=partial(self._check, action), cancel_callback=self._cancel,
                goal_service_qos_profile=QUEUE, result_service_qos_profile=QUEUE,
                cancel_service_qos_profile=QUEUE, result_timeout=RESULT_KEPT)
        if parameters.goal_pose:
            node.create_subscription(PoseStamped, GOAL_POSE, self._drive_to, 1)

    # On the executor's thread.

    def _check(self, action: Action, request: Any) -> GoalResponse:
        try:
            self._make(action, request)
        except ValueError as error:
            self._node.get_logger().warning(f'{action.name} rejected: {shortened(str(error))}')
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _make(self, action: Action, request: Any) -> Any:
        if action.type is NavigateToPosition:
            frame = request.goal_pose.header.frame_id
            if frame not in ('', self._odom_frame):
                raise ValueError(f'goal_pose is in frame {frame!r}; allowed: '
                                 f'{self._odom_frame!r}, odom_frame, or none')
        return action.make(request)

    async def _execute(self, action: Action, handle: ServerGoalHandle) -> Any:
        made = self._make(action, handle.request)
        with self._session.request() as (driver, now):
            action.start(driver, made, now)
            pursued = Pursued(action, made, handle)
            self._pursued.append(pursued)
            if handle.is_cancel_requested:
                pursued.cancel(self._session)
            ended = future_of(pursued.started, self._node)
        await ended
        self._pursued.remove(pursued)
        result = action.type.Result(**action.result(made))
        how = 'ended'
        if isinstance(made, Goal):
            stamp = Time(nanoseconds=self._stamps.newest or 0)  # the frame's, so that tf2 knows it
            result.pose.header = Header(frame_id=self._odom_frame, stamp=stamp.to_msg())
            how = 'succeeded' if result.success else f'ended, {Code(result.error_code).name}'
        self._node.get_logger().info(f'{action.name} {how}: {result.message}')
        if result.success:
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return result

    def _drive_to(self, pose: PoseStamped) -> None:
        """Pursue a goal of which only the place is sent; the log says how it ends."""
        action, = (each for each in ACTIONS if each.type is NavigateToPosition)
        log = self._node.get_logger()
        try:
            goal = self._make(action, NavigateToPosition.Goal(
                goal_pose=pose, achieve_goal_heading=True))
        except ValueError as error:
            log.warning(f'{GOAL_POSE} rejected: {shortened(str(error))}')
            return
        with self._session.request() as (driver, now):
            driver.goals.start(goal, now)
            goal.then(lambda outcome: log.info(f'{GOAL_POSE}: {outcome.text}'))

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        for each in self._pursued:
            if each.handle is handle:
                each.cancel(self._session)
        return CancelResponse.ACCEPT

    def check_clients(self) -> None:
        """End what nobody waits for any more; called once a second."""
        for each in self._pursued:
            service = self._node.resolve_service_name(f'{each.action.name}/_action/send_goal')
            each.unheard = 0 if self._node.count_clients(service) else each.unheard + 1
            if each.unheard >= CLIENT_LOST_CHECKS:
                each.cancel(self._session, CLIENT_GONE)

    # On the session's thread.

    def report(self) -> None:
        """Publish feedback of what is under way; called in every frame."""
        for each in tuple(self._pursued):
            each.report()
