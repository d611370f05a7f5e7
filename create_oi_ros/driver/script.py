# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Scripts in the robot: stored and played.

While a script waits, the robot obeys nothing, a stop included, and it does not report the end.
Whether it loses what it is sent meanwhile or obeys it afterwards is not known, nor how much it can
keep. So the driver sends, once, a stop and a question (`listening`), which a robot that keeps what
it is sent answers after its script. One that loses it is asked again from when the script should
have ended. Whichever answer comes, the wheels are stopped.

The last Drive is reported in packets 39 and 40, the last Drive Direct in 41 and 42, and nothing
tells which of them came last. So a script is followed if it uses only one of them.
"""

from collections.abc import Iterable

from .. import oi
from ..odometry.wheels import Speeds
from ..oi.commands import wheel_speeds
from ..oi.script import can_end, commands_of, duration, endless_wait, open_waits, SCRIPT_LIMIT
from ..oi.tools.text import format_command
from ..robot import FIRMWARE_SEPARATION, MM_PER_M, TOP_SPEED
from .core import Core
from .listening import ASK_INTERVAL
from .outbox import END_DEMO, Pending, refused
from .state import Activity, StateEvent
from .stream import DRIVE_REQUEST, requested_speeds, StreamPlan

CLEARED = oi.Drive(velocity=0, radius=oi.Radius.STRAIGHT)
"""Sent before a script plays: packets 39 and 40 may still hold an earlier Drive."""

LATE, LATE_FRACTION = 0.1, 0.04
"""Seconds, and part of its time, by which a script may end later than it should."""
SEPARATION = FIRMWARE_SEPARATION * MM_PER_M
"""Wheel separation that the firmware assumes, mm."""


class ScriptControl:
    """The script that the robot stores, as far as it is known."""

    def __init__(self, core: Core, plan: StreamPlan) -> None:
        self._core = core
        self._plan = plan
        self._stored: oi.Script | None = None
        """The script; None where it is not known."""
        self._followed = self._by_drive = False
        """Whether the script that plays is followed by its packets, and whether by 39 and 40."""
        self.resets_accumulators = False
        """Whether the script that played last has set distance and angle to zero as it waited for
        them (manual), so that a part of the motion is missing from them. False where it was not
        followed: then that part is all that is known."""
        self._ends_at: float | None = None
        """When the script that plays should end; None where that is not known."""

    @property
    def playing(self) -> bool:
        """Whether a script may be playing, so that the robot may ignore commands."""
        return self._core.state.activity is Activity.SCRIPT

    def define(self, script: oi.Script) -> Pending:
        """Store a script; an empty one clears it."""
        try:
            commands_of(script)
        except ValueError as error:
            return refused(str(error))
        request = self._core.request(script, f'sent: {_described(script)}')
        if request.outcome is None:
            self._stored = script
        return request

    # Played.

    def play(self, now: float, *, force: bool) -> Pending:
        """Play the stored script; one that cannot end, or is not known, only with `force`."""
        commands = commands_of(self._stored) if self._stored else []
        why = self._cannot_play(commands, force=force)
        if why is not None:
            return refused(why)
        core, status, stored = self._core, self._core.status, self._stored
        self._follow(commands)
        self._ends_at, ended = None, now
        takes = None if stored is None or not can_end(stored) else duration(
            stored, status.actual or oi.Mode.OFF, SEPARATION)
        if takes is not None:
            self._ends_at = now + takes
            ended = now + takes + LATE + LATE_FRACTION * takes
        core.listening.begin(
            now + ASK_INTERVAL, self._questions(commands),
            after_script=max(ended, now + 2 * ASK_INTERVAL))
        core.handle(StateEvent.SCRIPT_STARTED)
        if status.wanted is oi.Mode.PASSIVE or status.causes and not status.can_drive:
            core.outbox.send(END_DEMO)  # it runs, or was begun by a button
        core.outbox.send(CLEARED)
        core.outbox.send(oi.Stream(packets=self._plan.script.ids))
        return core.outbox.send(oi.PlayScript(), 'script sent to play')

    def _follow(self, commands: Iterable[oi.Command]) -> None:
        """Find out whether packets can tell how fast the wheels run by the stored script."""
        known = self._stored is not None and self._core.refusal(oi.Drive) is None
        used = set(map(type, commands))
        self._by_drive = oi.Drive in used
        self._followed = known and oi.Script not in used and not (
            self._by_drive and oi.DriveDirect in used)
        self.resets_accumulators = self._followed and not used.isdisjoint(
            (oi.WaitDistance, oi.WaitAngle))

    def _questions(self, commands: Iterable[oi.Command]) -> list[oi.PacketList]:
        """Return the lists that show the end of a script, for it does not ask for them itself."""
        streamed = [each.packets for each in commands if isinstance(each, oi.Stream)]
        return [each for each in self._plan.questions if each.ids not in streamed]

    def _cannot_play(self, commands: Iterable[oi.Command], *, force: bool) -> str | None:
        """Say why the stored script is not played, and what to do; None where it may be."""
        if self._core.state.pursues:
            return 'a goal runs: cancel it first'
        if self._core.state.moving:
            return 'the robot drives, and could not be told to stop meanwhile: stop it first'
        if self._stored == oi.Script(script=b''):
            return 'no script is stored: call define_script'
        if not self._questions(commands):
            return ('the stored script streams each list of packets by which the driver could see '
                    'its end: change the packets, or their order, in one of them')
        why = self._core.refusal(oi.PlayScript)
        if why is not None or force:
            return why
        if self._stored is None:
            return 'the stored script is not known: call define_script, or set force'
        if not can_end(self._stored):
            return ('the stored script plays itself again and may never end; then only the Power '
                    'button stops the robot: set force to play it')
        endless = endless_wait(
            self._stored, self._core.status.actual or oi.Mode.OFF, SEPARATION)
        if endless is not None:
            return (f'command {endless.place} of the stored script, '
                    f'{format_command(endless.command)}, waits for ever, since {endless.why}, '
                    'and only the Power button stops a robot that waits: change the script, or '
                    'set force to play it')
        return None

    def status(self, now: float) -> str | None:
        """Say that a script plays, how long it still takes, and what ends it; None where not."""
        if not self.playing:
            return None
        left = ('for an unknown time' if self._ends_at is None else
                f'for about {max(0.0, self._ends_at - now):.0f} s more')
        return f'{self._core.state.refusal} (it plays {left})'

    def speeds(self, readings: oi.Readings) -> Speeds | None:
        """Return the requested wheel speeds, of driver or script; None if not known."""
        if self.playing and not self._followed:
            return None
        if self.playing and self._by_drive:
            if readings.has(*DRIVE_REQUEST) and readings.requested_velocity is None:
                return None
            most = TOP_SPEED * MM_PER_M
            right, left = (max(-most, min(most, speed)) for speed in wheel_speeds(
                readings.number('requested_velocity', 0),
                readings.number('requested_radius', int(oi.Radius.STRAIGHT)),
                self._core.settings.limits.wheel_separation * MM_PER_M))
        else:
            right, left = requested_speeds(readings)
        return None if None in (right, left) else (right / MM_PER_M, left / MM_PER_M)

    @property
    def goes_on(self) -> bool:
        """Whether the script that played last plays itself, so that it may not have ended."""
        return self._stored is not None and not can_end(self._stored)

    def forget(self) -> None:
        """Forget the script: no robot answers, it may have been switched off."""
        self._stored = None


def _described(script: oi.Script) -> str:
    """Say how long a script is in bytes, and whether it ends."""
    if not script.script:
        return 'no script is stored'
    size = f'{len(script.script)} of {SCRIPT_LIMIT} bytes'
    waits = ', '.join(format_command(wait) for wait in open_waits(script))
    if not can_end(script):
        return f'{size}; it plays itself again and may never end'
    return f'{size}; it ends only if this happens: {waits}' if waits else size
