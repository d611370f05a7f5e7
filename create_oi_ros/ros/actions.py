# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The actions: each declared beside the function that turns its request into a goal.

The driver pursues the goals. Here they are checked, handed over, reported on and answered. Only a
malformed goal is rejected, with the reason in the log; any other is accepted, and its result says
why it could not be reached.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from create_oi_msgs.action import (
    Dock,
    DriveArc,
    DriveDistance,
    NavigateToPosition,
    RotateAngle,
    Undock,
    WallFollow,
)
from geometry_msgs.msg import PoseStamped
from rclpy.action.server import (
    ActionServer,
    CancelResponse,
    GoalResponse,
    ServerGoalHandle,
)
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from ..driver import goals
from ..driver.goal_control import CLIENT_GONE
from ..driver.goals import Code, Ending, Goal, Malformed, Phase, Progress, Running
from ..driver.goals.legs import StoppingModel
from ..driver.goals.motions import Circle, TargetPose
from ..link.session import Session
from ..oi.codes import BEAMS, FORCE_FIELD, GREEN_BUOY, RED_BUOY
from . import messages
from .messages import of_yaw, yaw_of
from .parameters import Parameters
from .publishing import StampClock
from .services import future_of, QUEUE
from .topics import GOAL_POSE

FEEDBACK_EVERY = 7
"""Frames from one feedback to the next: ten a second."""
RESULT_KEPT = 60
"""Seconds for which a client can still ask for the result of a goal that has ended."""
CLIENT_LOST_CHECKS = 2
"""Checks of the graph, one a second, without a client of the goal, after which it is ended."""
PHASES = {
    Phase.TURNING_TO_PLACE: NavigateToPosition.Feedback.ROTATING_TO_GOAL_POSITION,
    Phase.DRIVING: NavigateToPosition.Feedback.DRIVING_TO_GOAL_POSITION,
    Phase.TURNING_TO_HEADING: NavigateToPosition.Feedback.ROTATING_TO_GOAL_ORIENTATION,
}
SEARCH = {
    Phase.LOOKING: Dock.Feedback.LOOKING, Phase.SEES_DOCK: Dock.Feedback.SEES_DOCK,
    Phase.DOCKED: Dock.Feedback.DOCKED, Phase.CHARGING: Dock.Feedback.CHARGING,
}


class StoppingModels(Protocol):
    """How far a robot coasts, as goals learn it."""

    straight: StoppingModel
    turning: StoppingModel


class DefaultStoppingModels:
    """Those of a robot of which nothing is learned yet."""

    def __init__(self) -> None:
        self.straight, self.turning = StoppingModel(), StoppingModel()


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


@dataclass(frozen=True, kw_only=True)
class Action:
    """One action."""

    name: str
    type: Any
    about: str
    goal: Callable[[Any, StoppingModels], Goal]
    """Turns a request into a goal; Malformed says what is wrong."""
    feedback: Callable[[Any, Progress], None]
    """Fills the feedback."""


ACTIONS = (
    Action(
        name='drive_distance', type=DriveDistance, about='drive straight, also backwards',
        goal=lambda goal, stopping: goals.DriveDistance(
            goal.distance, goal.max_translation_speed, allowance(goal), stopping.straight),
        feedback=distance_left),
    Action(
        name='rotate_angle', type=RotateAngle, about='turn in place, any number of turns',
        goal=lambda goal, stopping: goals.RotateAngle(
            goal.angle, goal.max_rotation_speed, allowance(goal), stopping.turning),
        feedback=angle_left),
    Action(
        name='drive_arc', type=DriveArc, about='drive on a circle',
        goal=lambda goal, stopping: goals.DriveArc(
            Circle(goal.angle, goal.radius, goal.translate_direction),
            goal.max_translation_speed, allowance(goal), stopping.turning),
        feedback=angle_left),
    Action(
        name='navigate_to_position', type=NavigateToPosition,
        about='turn to a place in `odom_frame`, drive there straight, turn to a heading',
        goal=lambda goal, stopping: goals.NavigateToPosition(
            place(goal), goal.max_translation_speed, goal.max_rotation_speed, allowance(goal),
            stopping.straight, stopping.turning),
        feedback=phase_left),
    Action(
        name='dock', type=Dock, about='look for the Home Base and charge there; '
        'the service `dock` only starts to',
        goal=lambda goal, stopping: goals.Dock(allowance(goal)),
        feedback=dock_seen),
    Action(
        name='undock', type=Undock, about='leave the Home Base, 30 cm backwards',
        goal=lambda goal, stopping: goals.Undock(allowance(goal), stopping.straight),
        feedback=distance_left),
    Action(
        name='wall_follow', type=WallFollow, about='follow a wall on the right for a while',
        goal=lambda goal, stopping: goals.WallFollow(
            goal.follow_side, messages.seconds(goal.max_runtime), allowance(goal)),
        feedback=wall_engaged),
)
"""All actions."""


def allowance(goal: Any) -> float:
    """Return the seconds that a goal may take; 0 leaves that to the goal."""
    return messages.seconds(goal.time_allowance)


def place(goal: Any) -> TargetPose:
    """Return where a goal leads to."""
    pose = goal.goal_pose.pose
    heading = yaw_of(pose.orientation) if goal.achieve_goal_heading else None
    return TargetPose(pose.position.x, pose.position.y, heading)


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
        result.runtime = messages.duration(ending.seconds)


def offer(node: Node, action: Any, check: Callable[[Any], GoalResponse],
          execute: Callable[[ServerGoalHandle], Any],
          cancel: Callable[[ServerGoalHandle], CancelResponse]) -> None:
    """Offer an action, with a queue for many clients."""
    ActionServer(
        node, action.type, action.name, execute, callback_group=ReentrantCallbackGroup(),
        goal_callback=check, cancel_callback=cancel, goal_service_qos_profile=QUEUE,
        result_service_qos_profile=QUEUE, cancel_service_qos_profile=QUEUE,
        result_timeout=RESULT_KEPT)


class ClientWatch:
    """Notices that nobody is left who could wait for the goal of an action."""

    def __init__(self, node: Node, action: str) -> None:
        self._node = node
        self._service = f'{node.resolve_service_name(action)}/_action/send_goal'
        self._checks = 0
        """Checks of the graph in a row that showed no client."""

    def lost(self) -> bool:
        """Check the graph, once a second; return whether the client has gone."""
        self._checks = 0 if self._node.count_clients(self._service) else self._checks + 1
        return self._checks >= CLIENT_LOST_CHECKS


@dataclass
class Pursued:
    """A goal that runs, and how to report on it."""

    action: Action
    handle: ServerGoalHandle
    running: Running
    feedback: Any
    client: ClientWatch
    frames: int = 0


class Actions:
    """The servers of all actions; the driver runs one goal at a time."""

    def __init__(
        self, node: Node, session: Session, parameters: Parameters, stamps: StampClock,
    ) -> None:
        """Offer all actions."""
        self._stamps = stamps
        self._node = node
        self._session = session
        self._odom_frame = parameters.odom_frame
        self._pursued: Pursued | None = None
        for action in ACTIONS:
            offer(node, action, self._check(action), self._execute(action), self._cancel)
        if parameters.goal_pose:
            node.create_subscription(PoseStamped, GOAL_POSE, self._drive_to, 1)

    # On the executor's thread.

    def _check(self, action: Action) -> Callable[[Any], GoalResponse]:
        """Return the function that rejects malformed goals of an action."""
        def check(request: Any) -> GoalResponse:
            try:
                self._goal(action, request, self._session.driver.goals)
            except Malformed as error:
                self._node.get_logger().warning(f'{action.name} rejected: {error}')
                return GoalResponse.REJECT
            return GoalResponse.ACCEPT
        return check

    def _goal(self, action: Action, request: Any, stopping: StoppingModels) -> Goal:
        if action.type is NavigateToPosition:
            frame = request.goal_pose.header.frame_id
            if frame not in ('', self._odom_frame):
                raise Malformed(f'goal_pose is in frame {frame!r}; allowed: {self._odom_frame!r}, '
                                'odom_frame, or none')
        return action.goal(request, stopping)

    def _execute(self, action: Action) -> Callable[[ServerGoalHandle], Any]:
        """Return the coroutine that pursues a goal of an action."""
        async def execute(handle: ServerGoalHandle) -> Any:
            with self._session.request() as (driver, now):
                running = driver.goals.start(
                    self._goal(action, handle.request, driver.goals), now)
                self._pursued = Pursued(action, handle, running, action.type.Feedback(),
                                        ClientWatch(self._node, action.name))
                if handle.is_cancel_requested:
                    driver.goals.cancel(running, now)
                ended = future_of(running, self._node)
            return self._result(action, handle, await ended)
        return execute

    def _drive_to(self, pose: PoseStamped) -> None:
        """Pursue a goal of which only the place is sent; the log says how it ends."""
        action, = (each for each in ACTIONS if each.type is NavigateToPosition)
        log = self._node.get_logger()
        try:
            goal = self._goal(action, NavigateToPosition.Goal(
                goal_pose=pose, achieve_goal_heading=True), self._session.driver.goals)
        except Malformed as error:
            log.warning(f'{GOAL_POSE} rejected: {error}')
            return
        with self._session.request() as (driver, now):
            running = driver.goals.start(goal, now)
        running.then(lambda ending: log.info(f'{GOAL_POSE}: {ending.text}'))

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        pursued = self._pursued
        if pursued is not None and pursued.handle is handle:
            with self._session.request() as (driver, now):
                driver.goals.cancel(pursued.running, now)
        return CancelResponse.ACCEPT

    def _result(self, action: Action, handle: ServerGoalHandle, ending: Ending) -> Any:
        if self._pursued is not None and self._pursued.handle is handle:
            self._pursued = None
        how = 'succeeded' if ending.code is Code.NONE else f'ended, {ending.code.name}'
        self._node.get_logger().info(f'{action.name} {how}: {ending.text}')
        if ending.code is Code.NONE:
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        result = action.type.Result()
        stamp = messages.time(self._stamps.newest or 0)  # the frame's, so that tf2 knows it
        result.pose = PoseStamped(header=messages.header(self._odom_frame, stamp))
        fill_result(result, ending)
        return result

    def check_client(self) -> None:
        """End the goal whose client has gone; called once a second."""
        pursued = self._pursued
        if pursued is None:
            return
        if pursued.client.lost():
            with self._session.request() as (driver, now):
                driver.goals.cancel(pursued.running, now, CLIENT_GONE)

    # On the session's thread.

    def report(self) -> None:
        """Publish feedback of the goal that runs; called in every frame."""
        pursued = self._pursued
        if pursued is None or pursued.running.ending is not None:
            return
        pursued.frames += 1
        if pursued.frames % FEEDBACK_EVERY == 0:
            pursued.action.feedback(pursued.feedback, pursued.running.progress)
            pursued.handle.publish_feedback(pursued.feedback)
