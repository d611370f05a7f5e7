# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Enters modes: on request, when the robot missed the command, and after a hazard is gone."""

from collections.abc import Callable

from .. import oi
from .events import EventQueue, Severity
from .outbox import Outbox
from .outputs import Outputs
from .pending import done, Pending, refused
from .requests import Requests
from .state import State, StateEvent
from .stopping import END_DEMO
from .supervision import Cause, MODE_COMMANDS, Supervision

PAUSE = 'let commands pause and send again'
MODE_TIMEOUT = 0.5
"""Seconds within which the robot must report a requested mode."""
OLD = 0.06
"""Seconds in which frames may come that the robot sent before it was told to enter a mode."""
SETTABLE = ', '.join(f'{mode.value} {mode.name}' for mode in MODE_COMMANDS)


class Modes:
    """Keeps the robot in the wanted mode as far as safety allows."""

    def __init__(
        self, supervision: Supervision, state: State, outbox: Outbox, requests: Requests,
        outputs: Outputs, events: EventQueue, handle: Callable[[StateEvent], None],
    ) -> None:
        """`handle` passes an event to the driver's state."""
        self._supervision = supervision
        self._state = state
        self._outbox = outbox
        self._requests = requests
        self._outputs = outputs
        self._events = events
        self._handle = handle
        self._request = done('no request')
        self._requested: oi.Mode | None = None
        """The mode of a request that has not ended; None without one."""
        self._deadline = self._believed_at = 0.0
        self._was_in_another = False
        """Whether the robot has been in another mode since the request, or just before it."""

    def set(self, mode: oi.Mode, now: float) -> Pending:
        """Want a mode; the request ends when the robot reports it, or does not in time."""
        if mode not in MODE_COMMANDS:
            return refused(f'mode {mode.name} cannot be set; allowed: {SETTABLE}')
        why = self._requests.refusal(MODE_COMMANDS[mode])
        if why is not None:
            return refused(why)
        self.fail('another request came before the robot answered')
        self._request, self._requested = Pending(), mode
        self._deadline, self._believed_at = now + MODE_TIMEOUT, now + OLD
        self._was_in_another = self._supervision.status.actual is not mode
        self._handle(StateEvent.MODE_SET if mode in oi.ACTUATE else StateEvent.PASSIVE_SET)
        self._supervision.want(mode)
        self.enter(mode, now)
        return self._request

    def fail(self, why: str) -> None:
        """End a request that has not been answered."""
        self._end(False, why)

    def _end(self, ok: bool, text: str) -> None:
        self._requested = None
        self._request.end(ok, text)

    def enter(self, mode: oi.Mode, now: float) -> None:
        """Tell the robot to enter a mode, and set the outputs that this resets."""
        self._supervision.entering(now)
        self._handle(StateEvent.MODE_ENTERED)
        self._outbox.send(MODE_COMMANDS[mode]())
        if mode in oi.ACTUATE:
            self._outputs.restore()

    def rest(self, now: float) -> Pending:
        """Stop for an empty battery, and want Passive from now on; refused while that is vain."""
        why = self._requests.refusal(oi.Start)
        if why is not None:
            return refused(why)
        self._handle(StateEvent.RESTED)
        self._supervision.want(oi.Mode.PASSIVE)
        self.enter(oi.Mode.PASSIVE, now)
        return done('resting')

    def observe(self, readings: oi.Readings, now: float) -> bool:
        """Take a frame's mode in; True when the robot has just left the wanted mode."""
        left = self._supervision.observe(readings, now)
        status = self._supervision.status
        if left:
            self._handle(StateEvent.MODE_LEFT)
            self._events.notice(
                Severity.WARNING, f'robot left {status.wanted.name} for '
                f'{status.name}: {status.reason}')
            if status.causes == (Cause.UNKNOWN,) or (
                    status.unknown and status.wanted is oi.Mode.PASSIVE):
                self._outbox.send_at_once(END_DEMO, now)  # damaged bytes may have begun one
        if self._requested is not None:
            if status.actual is not self._requested:
                self._was_in_another = True
            elif self._was_in_another or now > self._believed_at:
                self._end(True, f'robot is in {self._requested.name}')
        return left

    def retry(self, now: float) -> None:
        """Enter the wanted mode again where the robot seems to have missed the command."""
        if self._state.takes_commands and self._supervision.must_enter_again(now):
            self.enter(self._supervision.status.wanted, now)

    def wrong_mode(self) -> str:
        """Say in which mode the robot is that is told to drive and does not."""
        status = self._supervision.status
        if status.can_drive:
            return f'robot is to enter {status.wanted.name}'
        why = f' ({status.reason})' if status.reason else ''
        return f'robot is in {status.name}{why}'

    def advice(self, again: str = PAUSE) -> str:
        """Say how a robot that is in no mode to drive is brought to drive."""
        causes = self._supervision.status.causes
        if self._supervision.status.unknown:
            return 'call set_mode with SAFE; if that does not help, switch the robot off and on'
        if self._supervision.docked:
            return 'send the goal undock, it is on its dock (dock and undock are actions)'
        if Cause.CHARGER in causes:
            return f"pull the charger's plug, {again}"
        if not causes:
            return 'call set_mode with SAFE'
        return f'{again}, or call set_mode with SAFE'

    def check_timeout(self, now: float) -> None:
        """End a request whose mode the robot did not report in time."""
        if self._requested is None or now <= self._deadline:
            return
        status = self._supervision.status
        lost = status.actual is None and not status.unknown
        stays = 'does not answer' if lost else f'stays in {status.name}'
        why = f' ({status.reason})' if status.reason else ''
        needs = (self.advice() if self._supervision.docked or status.unknown else
                 'in SAFE it needs all wheels down, no cliff under it and no charger plugged in')
        self.fail(f'robot {stays}{why} instead of entering {self._requested.name}: {needs}')

    def allow_driving(self, now: float) -> str | None:
        """
        Say why a fresh command is not followed, `advice` tells what to do; None where it is.

        While the robot enters a mode to drive in, a command waits for it. Where the robot has left
        the wanted mode, and may enter it again, tell it to.
        """
        status = self._supervision.status
        if status.wanted not in oi.ACTUATE:
            return self.wrong_mode()
        if status.can_drive or self._supervision.is_entering:
            return None
        if not self._supervision.may_recover(now):
            return self.wrong_mode()
        if not self._outbox.busy:
            self._events.notice(Severity.INFO, f'{status.reason} is gone: entering '
                                f'{status.wanted.name} again')
            self.enter(status.wanted, now)
        return None
