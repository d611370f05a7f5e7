# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Velocity commands: followed, refused, or too old.

The Open Interface has no timeout: the robot keeps the last speeds for ever. So a command holds
only for `MotionLimits.timeout`. Then the wheels stop.
"""

from math import isfinite

from .core import Core
from .events import Severity
from .goal_control import GoalControl
from .modes import Modes, PAUSE
from .motion import WheelCommands
from .state import Activity, Owner, StateEvent

ENDED_BY_PAUSE = (Activity.HOLDING, Activity.DRIVING)
"""Activities that end when no command comes for the timeout."""
AWAY = 'the robot was away, or in another mode, while commands went on'
SHORT = (Activity.SILENCING, Activity.READING)
"""Activities that end within a second."""
LEAST_SENSIBLE = 1e-6
"""Speed, m/s or rad/s, below which no sender means what it sends, unless it is 0."""


class VelocityControl:
    """Decides for each command whether the robot follows it, and sends the wheel speeds."""

    def __init__(
        self, core: Core, wheels: WheelCommands, modes: Modes, goals: GoalControl,
    ) -> None:
        self._core = core
        self._wheels = wheels
        self._modes = modes
        self._goals = goals
        self._refusal_reported = False
        self._hinted = False
        self._not_finite = 0
        """Commands in a row that were not finite."""

    def command(self, linear: float, angular: float, now: float) -> None:
        """Follow a velocity, m/s and rad/s, until the next command or the timeout."""
        finite = isfinite(linear) and isfinite(angular)
        if finite:
            self._report_finite()
            self._hint_at_integers(linear, angular)
        else:
            self._report_not_finite(linear, angular)
        if self._goals.active and not (finite and self._interrupts(linear, angular, now)):
            return
        if not finite:
            self._wheels.stop()
            linear = angular = 0.0
        if not self._wheels.command(linear, angular, now):
            if self._core.state.activity is Activity.HOLDING:
                self._core.handle(StateEvent.HALTED)
        elif self._core.state.owner is Owner.NOBODY:
            self._wheels.stop()
        elif why := self._refusal(now):
            self._wheels.stop()
            if self._core.state.activity is Activity.DRIVING:
                self._core.handle(StateEvent.HALTED)
            self._report_refusal(why)
        else:
            self._refusal_reported = False
            self._core.handle(StateEvent.VELOCITY)
        self._send_speeds(now)

    def _refusal(self, now: float) -> str | None:
        """Say why a command is not followed, and what to do; None where it is."""
        if self._core.state.drive_refusal is not None:
            return self._core.state.drive_refusal
        if self._core.state.activity is Activity.HOLDING:
            if self._core.status.causes:
                return f'{self._modes.wrong_mode()}; {self._modes.advice()}'
            return f'{AWAY}; {PAUSE}, or call set_mode with SAFE'
        why = self._modes.allow_driving(now)
        return None if why is None else f'{why}; {self._modes.advice()}'

    def _interrupts(self, linear: float, angular: float, now: float) -> bool:
        """End the goal that runs if this command may and would; False where it is ignored."""
        if not self._wheels.limits.commands_interrupt or linear == angular == 0:
            return False
        drives = self._core.state.owner is Owner.GOAL
        self._goals.interrupt(now)
        return drives  # after a search for the dock the robot first has to enter its mode

    def poll(self, now: float) -> None:
        """Stop the wheels when the newest command is too old; send speeds that have changed."""
        if self._wheels.expired(now) and self._core.state.activity in ENDED_BY_PAUSE:
            self._core.handle(StateEvent.HALTED)
        self._send_speeds(now)

    def report_next_refusal(self) -> None:
        """Report the next refusal, even if the last command was refused too."""
        self._refusal_reported = False

    def _send_speeds(self, now: float) -> None:
        status = self._core.status
        if self._core.state.takes_commands and (status.can_drive or status.unknown):
            drive = self._wheels.next_drive(now)
            if drive is not None:
                self._core.outbox.send_at_once(drive, now)
        if self._core.state.activity is Activity.DRIVING and self._wheels.at_rest:
            self._core.handle(StateEvent.HALTED)

    def _report_refusal(self, why: str) -> None:
        """Report the first of some refusals in a row, unless they end by themselves at once."""
        if not self._refusal_reported and self._core.state.activity not in SHORT:
            self._refusal_reported = True
            self._core.events.notice(Severity.WARNING, f'not driving: {why}')

    def _report_not_finite(self, linear: float, angular: float) -> None:
        """Report the first of several such commands in a row; count the others."""
        self._not_finite += 1
        if self._not_finite == 1:
            self._core.events.notice(
                Severity.WARNING, f'velocity ({linear} m/s, {angular} rad/s) is not finite: '
                + ('ignored, since a goal runs' if self._goals.active else 'stopped')
                + '; send finite numbers, and -1.0, not -1')

    def _hint_at_integers(self, linear: float, angular: float) -> None:
        """Say once that a speed is next to nothing: a whole number in a message is sent as one."""
        for speed in linear, angular:
            if 0 < abs(speed) < LEAST_SENSIBLE and not self._hinted:
                self._hinted = True
                self._core.events.notice(
                    Severity.WARNING, f'cmd_vel asks for a speed of {speed:.3g}, which moves '
                    'nothing: did the sender write 1 for 1.0?')

    def _report_finite(self) -> None:
        more, self._not_finite = self._not_finite - 1, 0
        if more > 0:
            self._core.events.notice(
                Severity.WARNING,
                f'velocities are finite again; before, {more} more than the first were not')
