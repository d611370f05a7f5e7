# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Commands that somebody asked for: checked before they are sent, answered when they are written.

A command that the robot would ignore, because of its mode or because no robot answers, is
refused in words that say what to do.
"""

from .. import oi
from .outbox import Outbox
from .pending import Pending, refused
from .state import Activity, REFUSALS, State
from .supervision import Supervision


class Requests:
    """Sends requested commands, or refuses them."""

    def __init__(self, outbox: Outbox, state: State, supervision: Supervision) -> None:
        self._outbox = outbox
        self._state = state
        self._supervision = supervision

    @property
    def mode(self) -> oi.Mode | None:
        """The robot's mode; None while no robot answers."""
        return self._supervision.status.actual

    def refusal(self, command: type[oi.Command]) -> str | None:
        """Say why a command cannot be sent now, and what to do; None where it can."""
        mode = self.mode
        if self._state.refusal is not None:
            return self._state.refusal
        if mode is None:
            return REFUSALS[Activity.CALLING]
        if mode in command.modes:
            return None
        return f'robot is in {mode.name}: call set_mode with SAFE first'

    def send(self, command: oi.Command, done: str, *, pause: float = 0.0) -> Pending:
        """Send a command, or refuse it; the outcome's text is `done` once it is written."""
        why = self.refusal(type(command))
        if why is not None:
            return refused(why)
        try:
            return self._outbox.request(command, done, pause=pause)
        except ValueError as error:
            return refused(str(error))
