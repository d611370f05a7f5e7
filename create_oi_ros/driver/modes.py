# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Enters modes: on request, when the robot missed the command, and after a hazard is gone.

The robot's demos, too: it plays them in Passive, where it follows no velocity commands.
"""

from .. import oi
from .core import Core
from .events import Severity
from .outbox import done, END_DEMO, Pending, refused
from .outputs import Outputs
from .state import Owner, StateEvent
from .supervision import Cause, MODE_COMMANDS

PAUSE = 'let commands pause and send again'
MODE_TIMEOUT = 0.5
"""Seconds within which the robot must report a requested mode."""
OLD = 0.06
"""Seconds in which frames may come that the robot sent before it was told to enter a mode."""
SETTABLE = ', '.join(f'{mode.value} {mode.name}' for mode in MODE_COMMANDS)


class Modes:
    """Keeps the robot in the wanted mode as far as safety allows."""

    def __init__(self, core: Core, outputs: Outputs) -> None:
        self._core = core
        self._outputs = outputs
        self._request = done('no request')
        self._requested: oi.Mode | None = None
        """The mode of a request that has not ended; None without one."""
        self._deadline = self._valid_at = 0.0
        self._was_in_another = False
        """Whether the robot has been in another mode since the request, or just before it."""

    def set(self, mode: oi.Mode, now: float) -> Pending:
        """Want a mode; the request ends when the robot reports it, or does not in time."""
        if mode not in MODE_COMMANDS:
            return refused(f'mode {mode.name} cannot be set; allowed: {SETTABLE}')
        why = self._core.refusal(MODE_COMMANDS[mode])
        if why is not None:
            return refused(why)
        self.fail('another request came before the robot answered')
        self._request, self._requested = Pending(), mode
        self._deadline, self._valid_at = now + MODE_TIMEOUT, now + OLD
        self._was_in_another = self._core.status.actual is not mode
        self._core.handle(StateEvent.MODE_SET if mode in oi.ACTUATE else StateEvent.PASSIVE_SET)
        self._core.supervision.want(mode)
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
        self._core.supervision.entering(now)
        self._core.handle(StateEvent.MODE_ENTERED)
        self._core.outbox.send(MODE_COMMANDS[mode]())
        if mode in oi.ACTUATE:
            self._outputs.restore()

    def rest(self, now: float) -> Pending:
        """Stop for an empty battery, and want Passive from now on; refused while that is vain."""
        why = self._core.refusal(oi.Start)
        if why is not None:
            return refused(why)
        self._core.handle(StateEvent.RESTED)
        self._core.supervision.want(oi.Mode.PASSIVE)
        self.enter(oi.Mode.PASSIVE, now)
        return done('resting')

    def observe(self, readings: oi.Readings, now: float) -> bool:
        """Take a frame's mode in; True when the robot has just left the wanted mode."""
        left = self._core.supervision.observe(readings, now)
        status = self._core.status
        if left:
            self._core.handle(StateEvent.MODE_LEFT)
            self._core.events.notice(
                Severity.WARNING, f'robot left {status.wanted.name} for '
                f'{status.name}: {status.reason}')
            if status.causes == (Cause.UNKNOWN,) or (
                    status.unknown and status.wanted is oi.Mode.PASSIVE):
                self._core.outbox.send_at_once(END_DEMO, now)  # damaged bytes may have begun one
        if self._requested is not None:
            if status.actual is not self._requested:
                self._was_in_another = True
            elif self._was_in_another or now > self._valid_at:
                self._end(True, f'robot is in {self._requested.name}')
        return left

    def retry(self, now: float) -> None:
        """Enter the wanted mode again where the robot seems to have missed the command."""
        if self._core.state.takes_commands and self._core.supervision.must_enter_again(now):
            self.enter(self._core.status.wanted, now)

    def wrong_mode(self) -> str:
        """Say in which mode the robot is that is told to drive and does not."""
        status = self._core.status
        if status.can_drive:
            return f'robot is to enter {status.wanted.name}'
        why = f' ({status.reason})' if status.reason else ''
        return f'robot is in {status.name}{why}'

    def advice(self, again: str = PAUSE) -> str:
        """Say how a robot that is in no mode to drive is brought to drive."""
        causes = self._core.status.causes
        if self._core.status.unknown:
            return 'call set_mode with SAFE; if that does not help, switch the robot off and on'
        if self._core.supervision.docked:
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
        status = self._core.status
        lost = status.actual is None and not status.unknown
        stays = 'does not answer' if lost else f'stays in {status.name}'
        why = f' ({status.reason})' if status.reason else ''
        needs = (self.advice() if self._core.supervision.docked or status.unknown else
                 'in SAFE it needs all wheels down, no cliff under it and no charger plugged in')
        self.fail(f'robot {stays}{why} instead of entering {self._requested.name}: {needs}')

    def allow_driving(self, now: float) -> str | None:
        """
        Say why a fresh command is not followed, `advice` tells what to do; None where it is.

        While the robot enters a mode to drive in, a command waits for it. Where the robot has left
        the wanted mode, and may enter it again, tell it to.
        """
        status = self._core.status
        if status.wanted not in oi.ACTUATE:
            return self.wrong_mode()
        if status.can_drive or self._core.supervision.is_entering:
            return None
        if not self._core.supervision.may_recover(now):
            return self.wrong_mode()
        if not self._core.outbox.busy:
            self._core.events.notice(Severity.INFO, f'{status.reason} is gone: entering '
                                f'{status.wanted.name} again')
            self.enter(status.wanted, now)
        return None


DOCK_PAUSE = 1.0
"""Seconds that the robot must be in Passive before it is sent to its dock (reported)."""


class Demos:
    """Starts and ends demos; Passive is the wanted mode from then on."""

    def __init__(self, core: Core) -> None:
        self._core = core

    def start(self, demo: oi.DemoNumber) -> Pending:
        """Let the robot play a demo; the request ends when the command is written."""
        if demo is oi.DemoNumber.ABORT:
            return refused('no demo: call stop_demo to end one')
        why = self._core.refusal(oi.Demo)
        if why is not None:
            return refused(why)
        can_drive = self._core.status.can_drive
        self._core.handle(StateEvent.DEMO_STARTED)
        self._core.supervision.want(oi.Mode.PASSIVE)
        if demo is oi.DemoNumber.COVER_AND_DOCK and can_drive:
            self._core.outbox.send(oi.Start(), pause=DOCK_PAUSE)
        return self._core.request(
            oi.Demo(demo=demo), f'demo {demo.name} sent; call stop_demo to end it')

    def seek_dock(self) -> None:
        """Let the robot look for its dock, for a goal."""
        can_drive = self._core.status.can_drive
        self._core.handle(StateEvent.DOCKING_STARTED)
        self._core.supervision.want(oi.Mode.PASSIVE)
        if can_drive:
            self._core.outbox.send(oi.Start(), pause=DOCK_PAUSE)
        self._core.outbox.send(oi.Demo(demo=oi.DemoNumber.COVER_AND_DOCK))

    def stop(self) -> Pending:
        """End the demo that runs, if any; the robot stays in Passive."""
        why = self._core.refusal(oi.Demo)
        if why is not None:
            return refused(why)
        if self._core.state.owner is not Owner.ROBOT and self._core.status.can_drive:
            return done('no demo runs: the robot obeys cmd_vel')
        self._core.handle(StateEvent.DEMO_ENDED)
        return self._core.request(
            END_DEMO, 'end of the demo sent; call set_mode with SAFE to drive again')
