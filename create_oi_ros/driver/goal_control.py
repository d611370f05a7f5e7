# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Goals: started, pursued frame by frame, and ended for whatever reason.

One goal runs at a time; a new one takes over. Whether one runs is the driver's activity, GOAL or
DOCKING: an event that leads out of these ends the goal, with the code that belongs to the event.
"""

from collections.abc import Callable
from math import inf

from .. import oi
from .demos import Demos
from .events import EventQueue, Moved, Severity
from .goals import Code, Ending, Goal, Running
from .goals.approach import Learned
from .goals.goal import DockDemo, docked, Enter, Order, Over, View
from .modes import Modes
from .motion import Velocity, WheelCommands
from .outbox import Outbox
from .state import Activity, Owner, REFUSALS, State, StateEvent
from .stopping import END_DEMO, HALT
from .supervision import Cause, Supervision

MODE_WAIT = 1.0
"""Seconds that the robot may take to enter its mode before a goal begins."""
TAKEN_OVER = {
    StateEvent.STOPPED: (Code.STOPPED, 'stopped: by the service stop, or by low_battery_action'),
    StateEvent.DEMO_STARTED: (Code.SUPERSEDED, 'a demo took over'),
    StateEvent.DEMO_ENDED: (Code.SUPERSEDED, 'the demo was ended by stop_demo'),
    StateEvent.SCRIPT_STARTED: (Code.SUPERSEDED, 'a script took over'),
    StateEvent.SHOW_STARTED: (Code.SUPERSEDED, 'the stored script is being read'),
    StateEvent.MODE_ENTERED: (Code.SUPERSEDED, 'another mode was set'),
    StateEvent.NO_ANSWER: (Code.LINK, 'the robot no longer answers: check cable and power'),
    StateEvent.PORT_CLOSED: (Code.LINK, 'the port is gone, or the driver ends'),
}
"""What an event means for the goal that it ends."""
CLIFFS = (Cause.CLIFF_LEFT, Cause.CLIFF_FRONT_LEFT, Cause.CLIFF_FRONT_RIGHT, Cause.CLIFF_RIGHT)


class GoalControl:
    """Pursues the goal that was started last."""

    def __init__(
        self, wheels: WheelCommands, state: State, supervision: Supervision, modes: Modes,
        demos: Demos, outbox: Outbox, events: EventQueue, handle: Callable[[StateEvent], None],
    ) -> None:
        """`handle` passes an event to the driver's state."""
        self._wheels = wheels
        self._state = state
        self._supervision = supervision
        self._modes = modes
        self._demos = demos
        self._outbox = outbox
        self._events = events
        self._handle = handle
        self.straight, self.turning = Learned(), Learned()
        """How the robot coasts, straight and turning."""
        self._goal: Goal | None = None
        self._running = Running()
        self._begun = False
        self._started_at = 0.0
        self._view: View | None = None
        self._mode_before = oi.Mode.SAFE

    def start(self, goal: Goal, now: float) -> Running:
        """Pursue a goal from the next frame on; one that runs is superseded."""
        running = Running()
        refused = self._refusal(goal, now)
        if refused is not None:
            self._end(running, refused, 0.0)
            return running
        if self._goal is not None:
            self._finish(Over(Code.SUPERSEDED, 'another goal took over'), now)
        self._goal, self._running = goal, running
        self._begun, self._started_at = False, now
        self._mode_before = self._supervision.status.wanted
        self._handle(StateEvent.GOAL_STARTED)
        return running

    @property
    def active(self) -> bool:
        """Whether a goal runs."""
        return self._goal is not None

    def cancel(self, running: Running, now: float) -> None:
        """End this goal, if it still runs."""
        if running is self._running and self.active:
            self._finish(Over(Code.CANCELED, 'canceled'), now)

    def abandon(self, running: Running, now: float) -> None:
        """End this goal, if it still runs: nobody waits for it any more."""
        if running is self._running and self.active:
            self._finish(Over(Code.STOPPED, 'its client has gone'), now)

    def interrupt(self, now: float) -> None:
        """End the goal that runs: a velocity command takes over."""
        if self.active:
            self._finish(Over(Code.SUPERSEDED, 'a velocity command took over'), now)

    def handled(self, event: StateEvent) -> None:
        """End the goal after an event that has led out of its activities."""
        if self._goal is None or self._state.pursues or event is StateEvent.GOAL_ENDED:
            return
        if event is StateEvent.MODE_LEFT:
            over = self._left_mode()
        else:
            over = Over(*TAKEN_OVER[event])
        self._conclude(over)

    def see(self, moved: Moved, dt: float, *, measured: bool, now: float) -> None:
        """Pursue the goal in a new frame."""
        self._view = View(
            now, dt, moved.estimate, moved.readings, measured, self._wheels.limits)
        if self._goal is None:
            return
        if not self._begun and not self._begin(self._goal, self._view):
            return
        if self._goal.needs_driving and not self._supervision.status.can_drive:
            self._finish(self._wrong_mode(), now)
            return
        order = self._goal.step(self._view)
        self._running.progress = self._goal.progress
        self._obey(order, now)

    def poll(self, now: float) -> None:
        """End a goal whose time is over."""
        if self._goal is None:
            return
        if not self._begun and now - self._started_at > MODE_WAIT:
            self._finish(self._wrong_mode(), now)
        elif self._begun and now - self._started_at > (self._goal.allowance or inf):
            self._finish(self._goal.timed_out(), now)

    # How a goal begins.

    def _refusal(self, goal: Goal, now: float) -> Over | None:
        """Say why a goal cannot be pursued now; None where it can."""
        state = self._state
        if state.owner is Owner.NOBODY:
            return Over(Code.NO_ROBOT, REFUSALS[state.activity])
        if state.pursues and self._goal is not None:
            return None
        why = state.drive_refusal if goal.needs_driving else state.refusal
        if why is None and goal.needs_driving:
            self._supervision.commands_paused()  # a goal is as good as a fresh command
            why = self._modes.allow_driving(now)
        return None if why is None else Over(Code.MODE, why)

    def _begin(self, goal: Goal, view: View) -> bool:
        """Let a goal begin once the robot follows velocities; False where it has not yet."""
        if goal.needs_driving and not self._supervision.status.can_drive:
            return False
        self._begun, self._started_at = True, view.now
        over = goal.begin(view)
        if over is not None:
            self._finish(over, view.now)
        return over is None

    def _wrong_mode(self) -> Over:
        mode = self._supervision.status.actual
        name = 'no known mode' if mode is None else mode.name
        return Over(Code.MODE, f'robot is in {name}: call set_mode with SAFE first')

    def _left_mode(self) -> Over:
        """Say what took the robot out of its mode."""
        status = self._supervision.status
        why = f'the robot left {status.wanted.name}: {status.reason}'
        if any(cause in CLIFFS for cause in status.causes):
            return Over(Code.CLIFF, why)
        return Over(Code.MODE, why)

    # What a goal orders.

    def _obey(self, order: Order, now: float) -> None:
        match order:
            case Velocity(linear, angular):
                self._wheels.command(linear, angular, now)
            case Over():
                self._finish(order, now)
            case Enter(mode, why):
                self._enter(mode, why, now)
            case DockDemo.PLAY:
                self._demos.seek_dock()

    def _enter(self, mode: oi.Mode, why: str, now: float) -> None:
        if why:
            self._events.notice(Severity.WARNING, why)
        self._wheels.command(0.0, 0.0, now)
        self._supervision.want(mode)
        self._modes.enter(mode, now)

    # How a goal ends.

    def _finish(self, over: Over, now: float) -> None:
        """End the goal, and stop what it set in motion."""
        was_docking = self._state.activity is Activity.DOCKING
        self._conclude(over)
        self._handle(StateEvent.GOAL_ENDED)
        self._outbox.send_at_once(HALT, now)
        if was_docking and over.code is not Code.NONE:
            self._outbox.send_at_once(END_DEMO, now)
            self._supervision.want(self._mode_before)
            self._modes.enter(self._mode_before, now)

    def _conclude(self, over: Over) -> None:
        self._goal = None
        ran = 0.0 if self._view is None else self._view.now - self._started_at
        self._end(self._running, over, max(0.0, ran))

    def _end(self, running: Running, over: Over, seconds: float) -> None:
        """Tell who waits how the goal ended, and how long it ran."""
        view = self._view
        if view is None:
            running.end(Ending(over.code, over.text))
            return
        running.end(Ending(
            over.code, over.text, view.estimate, seconds, docked(view.readings)))
