# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The actions: each declared beside the function that turns its request into what the driver does.

The driver pursues goals, one at a time, and plays tunes and animates LEDs beside them. Here they
are checked, handed over, reported on and answered. Only a malformed request is rejected, with the
reason in the log; any other is accepted, and its result says why it could not be done.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, Protocol, TypeVar

from create_oi_msgs.action import (
    AudioNoteSequence,
    Dock,
    DriveArc,
    DriveDistance,
    LedAnimation,
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

from ..driver import Driver, goals
from ..driver.goal_control import CANCELED, CLIENT_GONE
from ..driver.goals import Code, Goal, Malformed, Phase, Progress, Running
from ..driver.goals.goal import check_range
from ..driver.goals.legs import StoppingModel
from ..driver.goals.motions import Circle, TargetPose
from ..driver.goals.wall_following import MINUTE
from ..driver.outbox import Awaited
from ..driver.outputs import Animation, blink, MIN_PERIOD, spin, Tune, USUAL_PERIOD
from ..link.session import Session
from ..oi.codes import BEAMS, FORCE_FIELD, GREEN_BUOY, RED_BUOY
from ..oi.tools.tunes import note_text, parse_tune
from . import messages
from .messages import of_yaw, yaw_of
from .parameters import Parameters
from .publishing import StampClock
from .services import fill, future_of, QUEUE
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
class Action(ABC):
    """One action."""

    name: str
    type: Any
    about: str

    @abstractmethod
    def make(self, request: Any, stopping: StoppingModels) -> Any:
        """Turn a request into what the driver does; ValueError says what is wrong with it."""

    @abstractmethod
    def start(self, driver: Driver, made: Any, now: float) -> 'Pursuit':
        """Hand it to the driver."""


class Pursuit(ABC):
    """What the driver does for a request, until it ends."""

    awaited: Awaited[Any]
    """How it ends."""

    @abstractmethod
    def cancel(self, driver: Driver, now: float, *, gone: bool = False) -> None:
        """End it, if it has not ended; `gone`: because its client has gone."""

    @abstractmethod
    def news(self) -> Any:
        """Return feedback, or None where there is none to give; called in every frame."""

    @abstractmethod
    def fill(self, result: Any) -> tuple[bool, str]:
        """Fill in how it ended; return whether it succeeded, and a line for the log."""


@dataclass(frozen=True, kw_only=True)
class GoalAction(Action):
    """An action that drives the robot."""

    goal: Callable[[Any, StoppingModels], Goal]
    """Turns a request into a goal; Malformed says what is wrong."""
    feedback: Callable[[Any, Progress], None]
    """Fills the feedback."""

    def make(self, request: Any, stopping: StoppingModels) -> Goal:
        """Return the goal."""
        return self.goal(request, stopping)

    def start(self, driver: Driver, made: Goal, now: float) -> Pursuit:
        """Pursue it."""
        return GoalPursuit(self, driver.goals.start(made, now))


class GoalPursuit(Pursuit):
    """A goal that the driver pursues."""

    def __init__(self, action: GoalAction, running: Running) -> None:
        """Report on a goal that was handed over."""
        self._action, self._running = action, running
        self.awaited = running
        self._feedback = action.type.Feedback()
        self._frames = 0

    def cancel(self, driver: Driver, now: float, *, gone: bool = False) -> None:
        """End the goal, if it has not ended."""
        driver.goals.cancel(self._running, now, CLIENT_GONE if gone else CANCELED)

    def news(self) -> Any:
        """Return feedback ten times a second."""
        self._frames += 1
        if self._frames % FEEDBACK_EVERY:
            return None
        self._action.feedback(self._feedback, self._running.progress)
        return self._feedback

    def fill(self, result: Any) -> tuple[bool, str]:
        """Fill in how it ended; the header of the pose is filled already."""
        ending = self._running.ending
        assert ending is not None
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
        how = 'succeeded' if result.success else f'ended, {ending.code.name}'
        return result.success, f'{self._action.name} {how}: {ending.text}'


class TuneAction(Action):
    """An action that plays a tune; it moves no wheel."""

    def make(self, request: Any, stopping: StoppingModels) -> Tune:
        """Return the tune; ValueError says what is wrong."""
        if request.iterations != request.INFINITE and request.iterations < 1:
            raise ValueError(f'iterations = {request.iterations}; allowed: above 0, or '
                             f'{request.INFINITE}, until it is canceled')
        return Tune(parse_tune(request.notes), request.iterations)

    def start(self, driver: Driver, made: Tune, now: float) -> Pursuit:
        """Play it."""
        driver.outputs.play_tune(made, now)
        return TunePursuit(self, made)


Shown = TypeVar('Shown', Tune, Animation)


class ShowPursuit(Pursuit, Generic[Shown]):
    """A tune or an animation that the robot shows."""

    awaited: Shown

    def __init__(self, action: Action, shown: Shown) -> None:
        """Report on what was handed over."""
        self._action = action
        self.awaited = shown

    def cancel(self, driver: Driver, now: float, *, gone: bool = False) -> None:
        """End it, if it has not ended."""
        driver.outputs.cancel(self.awaited, 'its client has gone' if gone else 'canceled')

    def fill(self, result: Any) -> tuple[bool, str]:
        """Fill in how it ended."""
        outcome = self.awaited.outcome
        assert outcome is not None
        fill(result, outcome)
        result.runtime = messages.duration(self.awaited.seconds)
        return outcome.ok, f'{self._action.name}: {outcome.text}'


class TunePursuit(ShowPursuit[Tune]):
    """A tune that the robot plays."""

    _told = 0, -1
    """Iteration and place of the note in the last feedback."""

    def news(self) -> Any:
        """Return feedback with each new note."""
        tune = self.awaited
        place = tune.iterations_played, tune.note
        if tune.note < 0 or place == self._told:
            return None
        self._told = place
        return self._action.type.Feedback(
            note=note_text(tune.notes[tune.note].number), place=tune.note,
            iterations_played=tune.iterations_played,
            current_runtime=messages.duration(tune.seconds))

    def fill(self, result: Any) -> tuple[bool, str]:
        """Fill in how it ended."""
        result.iterations_played = self.awaited.iterations_played
        return super().fill(result)


class AnimationAction(Action):
    """An action that animates the LEDs; it moves no wheel."""

    def make(self, request: Any, stopping: StoppingModels) -> Animation:
        """Return the animation; ValueError says what is wrong."""
        steps = {request.BLINK_LIGHTS: blink, request.SPIN_LIGHTS: spin}.get(
            request.animation_type)
        if steps is None:
            raise ValueError(f'animation_type = {request.animation_type}; allowed: '
                             f'{request.BLINK_LIGHTS} (blink), {request.SPIN_LIGHTS} (spin)')
        if not (request.play or request.advance or request.power_intensity):
            raise ValueError('no LED is chosen: set play, advance or power_intensity')
        period = messages.seconds(request.period) or USUAL_PERIOD
        check_range('period', period, 's', MIN_PERIOD)
        runtime = messages.seconds(request.max_runtime)
        check_range('max_runtime', runtime, 's', 0.0)
        return Animation(steps(messages.leds(request)), period, runtime or MINUTE)

    def start(self, driver: Driver, made: Animation, now: float) -> Pursuit:
        """Show it."""
        driver.outputs.animate(made, now)
        return AnimationPursuit(self, made)


class AnimationPursuit(ShowPursuit[Animation]):
    """An animation of the LEDs."""

    _frames = 0

    def news(self) -> Any:
        """Return feedback ten times a second."""
        self._frames += 1
        if self._frames % FEEDBACK_EVERY:
            return None
        return self._action.type.Feedback(remaining_runtime=messages.duration(
            self.awaited.max_seconds - self.awaited.seconds))


ACTIONS = (
    GoalAction(
        name='drive_distance', type=DriveDistance, about='drive straight, also backwards',
        goal=lambda goal, stopping: goals.DriveDistance(
            goal.distance, goal.max_translation_speed, allowance(goal), stopping.straight),
        feedback=distance_left),
    GoalAction(
        name='rotate_angle', type=RotateAngle, about='turn in place, any number of turns',
        goal=lambda goal, stopping: goals.RotateAngle(
            goal.angle, goal.max_rotation_speed, allowance(goal), stopping.turning),
        feedback=angle_left),
    GoalAction(
        name='drive_arc', type=DriveArc, about='drive on a circle',
        goal=lambda goal, stopping: goals.DriveArc(
            Circle(goal.angle, goal.radius, goal.translate_direction),
            goal.max_translation_speed, allowance(goal), stopping.turning),
        feedback=angle_left),
    GoalAction(
        name='navigate_to_position', type=NavigateToPosition,
        about='turn to a place in `odom_frame`, drive there straight, turn to a heading',
        goal=lambda goal, stopping: goals.NavigateToPosition(
            place(goal), goal.max_translation_speed, goal.max_rotation_speed, allowance(goal),
            stopping.straight, stopping.turning),
        feedback=phase_left),
    GoalAction(
        name='dock', type=Dock, about='look for the Home Base and charge there; '
        'the service `dock` only starts to',
        goal=lambda goal, stopping: goals.Dock(allowance(goal)),
        feedback=dock_seen),
    GoalAction(
        name='undock', type=Undock, about='leave the Home Base, 30 cm backwards',
        goal=lambda goal, stopping: goals.Undock(allowance(goal), stopping.straight),
        feedback=distance_left),
    GoalAction(
        name='wall_follow', type=WallFollow, about='follow a wall on the right for a while',
        goal=lambda goal, stopping: goals.WallFollow(
            goal.follow_side, messages.seconds(goal.max_runtime), allowance(goal)),
        feedback=wall_engaged),
)
"""The actions that drive the robot."""
ALL_ACTIONS: tuple[Action, ...] = (*ACTIONS, TuneAction(
    name='audio_note_sequence', type=AudioNoteSequence,
    about='play a tune of any length: notes with their seconds, or a ring tone (RTTTL)'),
    AnimationAction(
        name='led_animation', type=LedAnimation, about='blink LEDs, or light them in turn'))


def malformed(name: str, request: Any) -> str:
    """Say what is wrong with a goal of the action of this name; empty: nothing in itself."""
    action, = (each for each in ALL_ACTIONS if each.name == name)
    try:
        action.make(request, DefaultStoppingModels())
    except ValueError as error:
        return str(error)
    return ''


def allowance(goal: Any) -> float:
    """Return the seconds that a goal may take; 0 leaves that to the goal."""
    return messages.seconds(goal.time_allowance)


def place(goal: Any) -> TargetPose:
    """Return where a goal leads to."""
    pose = goal.goal_pose.pose
    heading = yaw_of(pose.orientation) if goal.achieve_goal_heading else None
    return TargetPose(pose.position.x, pose.position.y, heading)


@dataclass
class Pursued:
    """A request that the driver follows, and who waits for its end."""

    handle: ServerGoalHandle
    pursuit: Pursuit
    service: str
    """The service by which its client sent it."""
    unheard: int = 0
    """Checks of the graph in a row that showed no client."""


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
        for action in ALL_ACTIONS:
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
        """Reject malformed goals of an action."""
        try:
            self._make(action, request)
        except ValueError as error:
            self._node.get_logger().warning(f'{action.name} rejected: {error}')
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _make(self, action: Action, request: Any) -> Any:
        if action.type is NavigateToPosition:
            frame = request.goal_pose.header.frame_id
            if frame not in ('', self._odom_frame):
                raise Malformed(f'goal_pose is in frame {frame!r}; allowed: {self._odom_frame!r}, '
                                'odom_frame, or none')
        return action.make(request, self._session.driver.goals)

    async def _execute(self, action: Action, handle: ServerGoalHandle) -> Any:
        """Pursue a goal of an action."""
        made = self._make(action, handle.request)
        with self._session.request() as (driver, now):
            pursuit = action.start(driver, made, now)
            pursued = Pursued(handle, pursuit, self._node.resolve_service_name(
                f'{action.name}/_action/send_goal'))
            self._pursued.append(pursued)
            if handle.is_cancel_requested:
                pursuit.cancel(driver, now)
            ended = future_of(pursuit.awaited, self._node)
        await ended
        self._pursued.remove(pursued)
        result = action.type.Result()
        if hasattr(result, 'pose'):
            stamp = messages.time(self._stamps.newest or 0)  # the frame's, so that tf2 knows it
            result.pose.header = messages.header(self._odom_frame, stamp)
        succeeded, line = pursuit.fill(result)
        self._node.get_logger().info(line)
        if succeeded:
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
        except Malformed as error:
            log.warning(f'{GOAL_POSE} rejected: {error}')
            return
        with self._session.request() as (driver, now):
            running = driver.goals.start(goal, now)
        running.then(lambda ending: log.info(f'{GOAL_POSE}: {ending.text}'))

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        for each in self._pursued:
            if each.handle is handle:
                with self._session.request() as (driver, now):
                    each.pursuit.cancel(driver, now)
        return CancelResponse.ACCEPT

    def check_clients(self) -> None:
        """End what nobody waits for any more; called once a second."""
        for each in self._pursued:
            each.unheard = 0 if self._node.count_clients(each.service) else each.unheard + 1
            if each.unheard >= CLIENT_LOST_CHECKS:
                with self._session.request() as (driver, now):
                    each.pursuit.cancel(driver, now, gone=True)

    # On the session's thread.

    def report(self) -> None:
        """Publish feedback of what is under way; called in every frame."""
        for each in tuple(self._pursued):
            feedback = each.pursuit.news() if each.pursuit.awaited.outcome is None else None
            if feedback is not None:
                each.handle.publish_feedback(feedback)
