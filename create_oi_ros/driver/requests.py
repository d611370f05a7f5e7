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
from .supervision import MODE_COMMANDS, Supervision


class Requests:
    """Sends requested commands, or refuses them."""

    def __init__(self, outbox: Outbox, state: State, supervision: Supervision) -> None:
        self._outbox = outbox
        self._state = state
        self._supervision = supervision

    @property
    def mode(self) -> oi.Mode | None:
        """The robot's mode; None while it is not known."""
        return self._supervision.status.actual

    def refusal(self, command: type[oi.Command]) -> str | None:
        """Say why a command cannot be sent now, and what to do; None where it can."""
        mode = self.mode
        if self._state.refusal is not None:
            return self._state.refusal
        status = self._supervision.status
        if mode is None and not status.unknown:
            return REFUSALS[Activity.CALLING]
        if mode in command.modes or status.unknown and command in MODE_COMMANDS.values():
            return None
        why = f' ({status.reason})' if status.unknown else ''
        return f'robot is in {status.name}{why}: call set_mode with SAFE first'

    def send(self, command: oi.Command, done: str, *, pause: float = 0.0) -> Pending:
        """Send a command, or refuse it; the outcome's text is `done` once it is written."""
        why = self.refusal(type(command))
        if why is not None:
            return refused(why)
        try:
            return self._outbox.request(command, done, pause=pause)
        except ValueError as error:
            return refused(str(error))
