# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Actions that move no wheel: tunes. They run beside goals and velocity commands.

Like in `actions`, only a malformed goal is rejected, with the reason in the log; the result of any
other says why it could not be done.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from create_oi_msgs.action import AudioNoteSequence
from rclpy.action.server import CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.node import Node

from ..driver.outputs import Tune
from ..link.session import Session
from ..oi.tools.tunes import parse_tune, sounding_name
from . import messages
from .actions import ACTIONS, ClientWatch, DefaultStoppingModels, offer
from .services import fill, future_of


@dataclass(frozen=True, kw_only=True)
class Performance:
    """One of these actions."""

    name: str
    type: Any
    about: str
    make: Callable[[Any], Tune]
    """Turns a request into what is performed; ValueError says what is wrong."""


def tune(request: Any) -> Tune:
    """Return the tune that is asked for; ValueError says what is wrong."""
    if request.iterations != request.INFINITE and request.iterations < 1:
        raise ValueError(f'iterations = {request.iterations}; allowed: above 0, or '
                         f'{request.INFINITE}, until it is canceled')
    return Tune(parse_tune(request.notes), request.iterations)


PERFORMANCES = (
    Performance(
        name='audio_note_sequence', type=AudioNoteSequence, make=tune,
        about='play a tune of any length: notes with their seconds, or a ring tone (RTTTL)'),
)
"""All of these actions."""
ALL_ACTIONS = (*ACTIONS, *PERFORMANCES)


def malformed(name: str, request: Any) -> str:
    """Say what is wrong with a goal of the action of this name; empty: nothing in itself."""
    action, = (each for each in ALL_ACTIONS if each.name == name)
    try:
        if isinstance(action, Performance):
            action.make(request)
        else:
            action.goal(request, DefaultStoppingModels())
    except ValueError as error:
        return str(error)
    return ''


@dataclass
class Running:
    """A tune that plays, and how to report on it."""

    performance: Performance
    handle: ServerGoalHandle
    tune: Tune
    client: ClientWatch
    told: tuple[int, int] = (0, -1)
    """Iteration and place of the note in the last feedback."""


class Performances:
    """The servers of these actions."""

    def __init__(self, node: Node, session: Session) -> None:
        """Offer all of them."""
        self._node = node
        self._session = session
        self._running: Running | None = None
        for each in PERFORMANCES:
            offer(node, each, self._check(each), self._execute(each), self._cancel)

    # On the executor's thread.

    def _check(self, performance: Performance) -> Callable[[Any], GoalResponse]:
        """Return the function that rejects malformed goals."""
        def check(request: Any) -> GoalResponse:
            why = malformed(performance.name, request)
            if why:
                self._node.get_logger().warning(f'{performance.name} rejected: {why}')
            return GoalResponse.REJECT if why else GoalResponse.ACCEPT
        return check

    def _execute(self, performance: Performance) -> Callable[[ServerGoalHandle], Any]:
        """Return the coroutine that performs a goal."""
        async def execute(handle: ServerGoalHandle) -> Any:
            made = performance.make(handle.request)
            with self._session.request() as (driver, now):
                driver.outputs.play_tune(made, now)
                if made.outcome is None:
                    self._running = Running(performance, handle, made,
                                            ClientWatch(self._node, performance.name))
                if handle.is_cancel_requested:
                    driver.outputs.cancel_tune(made)
                ended = future_of(made, self._node)
            outcome = await ended
            self._node.get_logger().info(f'{performance.name}: {outcome.text}')
            if outcome.ok:
                handle.succeed()
            elif handle.is_cancel_requested:
                handle.canceled()
            else:
                handle.abort()
            result = fill(performance.type.Result(), outcome)
            result.iterations_played = made.iterations_played
            result.runtime = messages.duration(made.seconds)
            return result
        return execute

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        running = self._running
        if running is not None and running.handle is handle:
            with self._session.request() as (driver, _now):
                driver.outputs.cancel_tune(running.tune)
        return CancelResponse.ACCEPT

    def check_client(self) -> None:
        """End what nobody waits for any more; called once a second."""
        running = self._running
        if running is None or running.tune.outcome is not None:
            return
        if running.client.lost():
            with self._session.request() as (driver, _now):
                driver.outputs.cancel_tune(running.tune, 'its client has gone')

    # On the session's thread.

    def report(self) -> None:
        """Publish feedback with each new note; called in every frame."""
        running = self._running
        if running is None or running.tune.outcome is not None:
            return
        place = running.tune.note
        news = running.tune.iterations_played, place
        if place >= 0 and news != running.told:
            running.told = news
            running.handle.publish_feedback(running.performance.type.Feedback(
                note=sounding_name(running.tune.notes[place].number), place=place,
                iterations_played=running.tune.iterations_played,
                current_runtime=messages.duration(running.tune.seconds)))
