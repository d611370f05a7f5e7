# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Goals: started, pursued frame by frame, and ended for whatever reason.

One goal runs at a time; a new one takes over. Whether one runs is the driver's activity, GOAL or
DOCKING: an event that leads out of these ends the goal, with the code that belongs to the event.
"""

from collections.abc import Container

from .. import oi
from ..odometry import Estimate
from .core import Core
from .events import Cause, Moved, Severity
from .goals import Code, Goal
from .goals.goal import Enter, Instruction, Order, Over, StoppingModel, View
from .goals.motions import AGAIN, CLIFFS, DROPS, FROM_CLIFF, TO_FLOOR
from .mode import docked, Modes
from .motion import Motion, Velocity
from .outbox import END_DEMO, HALT
from .state import Activity, REFUSALS, StateEvent
from .tracking import Tracking

MODE_WAIT = 1.0
"""Seconds that the robot may take to enter its mode before a goal begins."""
TAKEN_OVER = {
    StateEvent.STOPPED: (Code.STOPPED, 'the service stop was called'),
    StateEvent.RESTED: (
        Code.STOPPED, 'the battery is nearly empty (low_battery_action): charge it'),
    StateEvent.DEMO_STARTED: (Code.SUPERSEDED, 'a demo took over'),
    StateEvent.DEMO_ENDED: (Code.SUPERSEDED, 'the service stop_demo was called'),
    StateEvent.MODE_SET: (Code.SUPERSEDED, 'another mode was set'),
    StateEvent.PASSIVE_SET: (
        Code.MODE, 'PASSIVE was set: call set_mode with SAFE, then send the goal again'),
    StateEvent.CALLED: (
        Code.LINK, 'the robot no longer answers: check cable and power, the driver keeps trying'),
    StateEvent.PORT_CLOSED: (
        Code.LINK, 'the port is gone: check the cable, the driver keeps trying'),
}
"""What an event means for the goal that it ends."""
CANCELED = Over(Code.CANCELED, 'canceled')
CLIENT_GONE = Over(Code.STOPPED, 'its client has gone')
DRIVER_ENDS = Over(Code.LINK, 'the driver ends: start it again')
MAY_MOVE = (Code.SUPERSEDED, Code.LINK)
"""Endings after which the robot may still move."""
ANOTHER_GOAL = Over(
    Code.SUPERSEDED, 'another goal took over: wait for the first result if both are to be reached')
COMMANDED = Over(
    Code.SUPERSEDED, 'a velocity command took over: set the parameter cmd_vel_interrupts to false '
    'if goals are to win')


class GoalControl:
    """Pursues the goal that was started last."""

    def __init__(self, core: Core, motion: Motion, modes: Modes, tracking: Tracking) -> None:
        self._core = core
        self._odometry = tracking.odometry
        self._motion = motion
        self._modes = modes
        self._straight, self._turning = StoppingModel(), StoppingModel()
        self._goal: Goal | None = None
        """The goal that runs, or has ended last."""

    def start(self, goal: Goal, now: float) -> Goal:
        """Pursue a goal from the next frame on; one that runs is superseded."""
        why = self._refusal(goal, now)
        if why is not None:
            self._end(goal, why)
            return goal
        self.finish(ANOTHER_GOAL, now)
        if self._core.state.activity is Activity.HOLDING:
            # A goal is as good as a pause of commands.
            self._core.handle(StateEvent.HALTED)
        self._goal = goal
        self._core.handle(StateEvent.GOAL_STARTED)
        if goal.hint:
            self._core.notice(Severity.WARNING, goal.hint)
        return goal

    def cancel(self, goal: Goal, now: float, why: Over = CANCELED) -> None:
        """End this goal, if it still runs."""
        if goal is self._goal:
            self.finish(why, now)

    def driver_ends(self) -> None:
        if self._goal is not None:
            self._end(self._goal, DRIVER_ENDS)

    def taken_over(self, event: StateEvent) -> None:
        """End the goal that runs, if any, after an event that has led out of its activities."""
        if self._goal is None:
            return
        over = Over(*TAKEN_OVER[event]) if event in TAKEN_OVER else Over(
            Code.CLIFF if self._blames(CLIFFS) else Code.MODE,
            f'robot left {self._core.status.wanted.name} ({self._core.status.reason}): '
            f'{self._advice()}')
        self._end(self._goal, over)

    def see(self, moved: Moved, now: float) -> None:
        """Pursue the goal that runs in a new frame."""
        goal = self._goal
        assert goal is not None
        if goal.begun_at is None and self._modes.entering:
            return
        if goal.needs_driving and not self._core.status.can_drive:
            if goal.begun_at is not None and not self._modes.entering_since(goal.begun_at):
                self.finish(self._wrong_mode(), now)
            return
        estimate = moved.estimate
        if goal.begun_at is None:  # a goal measures from where it begins
            self._odometry.start_trip()
            estimate = self._odometry.estimate
        order = goal.step(self._view(
            now, moved.dt, estimate, measured=moved.brought.has('distance'), lost=moved.lost))
        if goal.begun_at is None and not isinstance(order, Over):
            goal.begun_at = now
        self._obey(order, now)

    def poll(self, now: float) -> None:
        """End the goal that runs if its time is over."""
        goal = self._goal
        assert goal is not None
        if goal.begun_at is None:
            if now - goal.view.now > MODE_WAIT:
                self.finish(self._wrong_mode(), now)
        elif now - goal.begun_at > goal.allowance:
            self.finish(goal.timed_out(), now)

    def _view(self, now: float, dt: float, estimate: Estimate, *, measured: bool = False,
              lost: bool = False) -> View:
        return View(now, dt, estimate, self._core.readings, measured, lost, self._core.limits,
                    self._straight, self._turning)

    # How a goal begins.

    def _refusal(self, goal: Goal, now: float) -> Over | None:
        """Say why a goal cannot be pursued now; None where it can. It changes nothing."""
        state, own = self._core.state, self._modes.own
        if not state.answered:
            return Over(Code.NO_ROBOT, REFUSALS[state.activity])
        if state.pursues:
            why = None
            if goal.needs_driving and own not in oi.ACTUATE:
                why = (f'another goal runs, and the robot was in {own.name} before: cancel it, or '
                       'call set_mode with SAFE, then send the goal again')
        elif goal.needs_driving:
            why = state.drive_refusal or self._modes.allow_driving(now)
            why = why and (state.drive_refusal or f'{why}: {self._advice()}')
        else:
            why = state.refusal
        if why:
            return Over(Code.MODE, why)
        goal.view = self._view(now, 0.0, self._odometry.estimate)
        return goal.hazard()

    def _wrong_mode(self) -> Over:
        name = self._core.status.name
        return Over(Code.MODE, f'robot is in {name}: {self._advice()}')

    def _blames(self, causes: Container[Cause]) -> bool:
        """Tell whether one of these took the robot out of its mode."""
        return any(cause in causes for cause in self._core.status.causes)

    def _advice(self) -> str:
        """Say how a robot that is in no mode to drive is brought to pursue a goal."""
        if self._blames(DROPS):
            return TO_FLOOR
        return FROM_CLIFF if self._blames(CLIFFS) else self._modes.advice(AGAIN)

    # What a goal orders.

    def _obey(self, order: Order, now: float) -> None:
        match order:
            case Velocity(linear, angular):
                self._motion.follow(linear, angular, now)
            case Over():
                self.finish(order, now)
            case Enter(mode, why):
                if why:
                    self._core.notice(Severity.WARNING, why)
                self._motion.follow(0.0, 0.0, now)
                self._modes.borrow(mode)
                self._modes.enter(now)
            case Instruction.SEEK_DOCK:
                self._modes.borrow(oi.Mode.PASSIVE)
                self._modes.play_demo(
                    oi.DemoNumber.COVER_AND_DOCK, StateEvent.DOCKING_STARTED)
            case Instruction.MEASURE:
                self._motion.follow(0.0, 0.0, now)
                self._odometry.hurry()

    # How a goal ends.

    def finish(self, over: Over, now: float) -> None:
        """End the goal that runs, if any, and stop what it set in motion."""
        if self._goal is None or not self._core.state.pursues:
            return
        if self._core.listening.may_stop:
            self._core.outbox.send_at_once(HALT, now)
            self._core.listening.stop_sent = True
        if over.code is Code.NONE:
            # And no longer that from before.
            self._modes.want(self._goal.leaves_in or self._core.status.wanted)
        elif self._core.state.activity is Activity.DOCKING:
            self._core.outbox.send_at_once(END_DEMO, now)
        self._end(self._goal, over)
        self._core.handle(StateEvent.GOAL_ENDED)

    def _end(self, goal: Goal, over: Over) -> None:
        """Tell who waits how a goal ended, and how far it got; the first ending counts."""
        if goal.outcome is not None:
            return
        text, how = over.text, 'not started'
        if goal.hint and goal is self._goal:
            text = f'{text} ({goal.hint})'
        if goal.begun_at is not None:
            verb = 'ended' if over.code in MAY_MOVE else 'stopped'
            how = f'{verb} {goal.way(goal.view.now - goal.begun_at)}'
        if over.code is not Code.NONE:
            text = f'{how}; {text}'
        goal.code = over.code
        if self._core.readings.has('oi_mode'):
            goal.estimate = self._odometry.estimate
            goal.docked = docked(self._core.readings)
        goal.end(over.code is Code.NONE, text)
