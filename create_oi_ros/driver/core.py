# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the parts of the driver share: state, outbox, events, the robot's mode and readings.

A command that somebody asks for and that the robot would ignore, because of its mode or because no
robot answers, is refused in words that say what to do.
"""

from collections import deque
from collections.abc import Callable

from .. import oi
from .events import DriverEvent, LinkCounts, ModeStatus, Notice, Settings, Severity
from .listening import IGNORES, Listening
from .outbox import MODE_COMMANDS, Outbox, Pending, refused
from .state import Activity, REFUSALS, State, StateEvent, Then


class Core:
    """Made once, and passed to every part."""

    def __init__(
        self, settings: Settings, follow: Callable[[StateEvent, tuple[Then, ...]], None],
    ) -> None:
        """`follow` is called after each event with what follows, once the state has changed."""
        self.settings = settings
        self.limits = settings.limits
        """Limits of the next velocities."""
        self.state = State()
        self.status = ModeStatus(None, settings.mode_on_start)
        """The wanted mode, the actual one, and why they differ."""
        self.readings = oi.Readings()
        """The newest of every packet that has arrived so far."""
        self.outbox = Outbox()
        self.events: deque[DriverEvent] = deque()
        """What has happened, oldest first."""
        self.counts = LinkCounts()
        self.garbage_before = 0
        """Bytes of garbage that had come when the newest frame did."""
        self.listening = Listening(self.outbox, self.notice)
        self._follow = follow
        self._mistakes: set[str] = set()

    def handle(self, event: StateEvent) -> None:
        """Let an event change the state: the only place where it changes."""
        consequences = self.state.handle(event)
        if consequences is None:
            self._report_unknown(event)
        else:
            self._follow(event, consequences)

    def _report_unknown(self, event: StateEvent) -> None:
        """Log once a mistake of the driver: an event where no table lists it."""
        mistake = (f'{event.name} came in {self.state.activity.name}, where the driver does not '
                   'expect it, and is ignored: please report this')
        if mistake not in self._mistakes:
            self._mistakes.add(mistake)
            self.notice(Severity.WARNING, mistake)

    def set_status(self, status: ModeStatus) -> None:
        """Note what is known of the mode; it is an event where it has changed."""
        if status != self.status:
            self.status = status
            self.events.append(status)

    def notice(self, severity: Severity, text: str) -> None:
        self.events.append(Notice(severity, text))

    def refusal(self, command: type[oi.Command]) -> str | None:
        """Say why a command cannot be sent now, and what to do; None where it can."""
        status = self.status
        if self.state.refusal is not None:
            return self.state.refusal
        if self.listening.ignores:
            return IGNORES
        if status.actual is None and not status.unknown:
            return REFUSALS[Activity.CALLING]
        if status.actual in command.modes or (
                status.unknown and command in MODE_COMMANDS.values()):
            return None
        mode = status.described if status.unknown else status.name
        return f'robot is in {mode}: call set_mode with SAFE first'

    def request(self, command: oi.Command, done: str) -> Pending:
        """Send a command, or refuse it; the outcome's text is `done` once it is written."""
        why = self.refusal(type(command))
        if why is not None:
            return refused(why)
        try:
            return self.outbox.send(command, done)
        except ValueError as error:
            return refused(str(error))
