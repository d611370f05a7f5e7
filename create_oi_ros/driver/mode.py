# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The wanted mode and the actual one: why the robot left it, and how it gets into it.

In Safe mode the robot itself falls to Passive on a cliff, a wheel drop or a powered charger
(manual: Safe Mode). The driver notices, names the cause, and enters the wanted mode: on request,
when the robot missed the command, and when a fresh velocity comes after the hazard is gone. A goal
only borrows a mode: that from before is wanted again when it ends, unless somebody has asked for
another. The robot's demos are here, too: it plays them in Passive, where it follows no velocity.
"""

from math import inf

from .. import oi
from .core import Core
from .events import Cause, ModeStatus, Severity
from .outbox import done, END_DEMO, MODE_COMMANDS, Pending, refused
from .outputs import Outputs
from .state import StateEvent

PAUSE = 'let commands pause and send again'
CLEAR_TIME = 1.0
"""Seconds that the cause must have been gone before the wanted mode may be entered again."""
RETRY_INTERVAL, MAX_TRIES = 0.2, 3
"""Seconds after which a mode should have been entered, and how often it is tried."""
SETTLING_TIME = 2.0
"""Seconds after the robot was found, or a mode was asked for, in which frames from before may
still come on a busy computer."""
MODE_TIMEOUT = 0.5
"""Seconds within which the robot must report a requested mode."""
DOCK_PAUSE = 1.0
"""Seconds that the robot must be in Passive before it is sent to its dock (reported)."""
SETTABLE = ', '.join(f'{mode.value} {mode.name}' for mode in MODE_COMMANDS)
DEMOS = range(oi.DemoNumber.COVER, oi.DemoNumber.BANJO + 1)
LEFT_DROP, RIGHT_DROP, CASTER_DROP = map(int, (
    oi.BumpsAndWheelDrops.WHEEL_DROP_LEFT, oi.BumpsAndWheelDrops.WHEEL_DROP_RIGHT,
    oi.BumpsAndWheelDrops.WHEEL_DROP_CASTER))
HOME_BASE = int(oi.ChargingSources.HOME_BASE)
hazard_numbers = oi.Readings.numbers(
    'bumps_and_wheel_drops', 'cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right')


def causes_in(readings: oi.Readings) -> tuple[Cause, ...]:
    """Name what in these readings would take the robot out of Safe mode."""
    drops, left, front_left, front_right, right = hazard_numbers(readings)
    seen = (
        (Cause.CLIFF_LEFT, left), (Cause.CLIFF_FRONT_LEFT, front_left),
        (Cause.CLIFF_FRONT_RIGHT, front_right), (Cause.CLIFF_RIGHT, right),
        (Cause.WHEEL_DROP_LEFT, drops & LEFT_DROP), (Cause.WHEEL_DROP_RIGHT, drops & RIGHT_DROP),
        (Cause.WHEEL_DROP_CASTER, drops & CASTER_DROP),
        (Cause.CHARGER, readings.number('charging_sources', 0)))
    return tuple(cause for cause, present in seen if present)


def docked(readings: oi.Readings) -> bool:
    """Tell whether the robot is on the contacts of a Home Base; charging or full."""
    return bool(readings.number('charging_sources', 0) & HOME_BASE)


class Modes:
    """Keeps the robot in the wanted mode as far as safety allows; starts and ends demos."""

    def __init__(self, core: Core, outputs: Outputs) -> None:
        self._core = core
        self._outputs = outputs
        self._tries = 0
        """Commands since the mode was wanted, or entered last; 0: it is not being entered."""
        self._begun_at = self._tried_at = -inf
        """When it was commanded first and last, s; infinite where the next poll says when."""
        self._request = done('no request')
        """Who waits for the mode."""
        self._before_goal: ModeStatus | None = None
        """What was before a goal wanted another mode; None where none does."""
        self._causes_before: tuple[Cause, ...] = ()
        """What the frame before showed."""
        self._cause_seen_at = -inf

    # Which mode is wanted.

    def want(self, mode: oi.Mode, causes: tuple[Cause, ...] = ()) -> None:
        """Want a mode from now on; `causes`: why the robot is not in it."""
        status = self._core.status
        self._request.end(False, 'another request came before the robot answered')
        self._tries, self._before_goal = 0, None
        self._begun_at = self._tried_at = -inf
        self._core.set_status(ModeStatus(
            status.actual, mode, status.causes if status.actual is None else causes))

    @property
    def own(self) -> oi.Mode:
        """The mode that somebody asked for, whatever a goal wants meanwhile."""
        return (self._before_goal or self._core.status).wanted

    def borrow(self, mode: oi.Mode) -> None:
        """Want a mode for the goal that runs."""
        before = self._before_goal or self._core.status
        self.want(mode)
        self._before_goal = None if before.wanted is mode else before

    def give_back(self, *, enter: bool) -> None:
        """
        Want the mode from before a goal again, if it wanted another; perhaps enter it now.

        A robot that a hazard had taken out of that mode before, and that is in Passive, stays.
        """
        before, status = self._before_goal, self._core.status
        if before is None:
            return
        hazards = before.causes if status.actual is oi.Mode.PASSIVE else ()
        if enter and not hazards:
            self.want(before.wanted)
            self.enter(inf)
        else:
            left = status.actual is not before.wanted
            self.want(before.wanted, (status.causes or hazards) if left else ())

    # How the robot gets into it.

    def set(self, number: int, now: float, event: StateEvent | None = None) -> Pending:
        """
        Want a mode; the request ends when the robot reports it, or does not in time.

        `event` is what this means where nobody asked for the mode.
        """
        if number not in MODE_COMMANDS:
            return refused(f'mode {number} cannot be set; allowed: {SETTABLE}')
        mode = oi.Mode(number)
        why = self._core.refusal(MODE_COMMANDS[mode])
        if why is not None:
            return refused(why)
        self.want(mode)
        self._core.handle(event or (
            StateEvent.MODE_SET if mode in oi.ACTUATE else StateEvent.PASSIVE_SET))
        sent = self.enter(now)
        if self._core.status.actual is mode:
            return sent
        self._request = Pending()
        return self._request

    def enter(self, now: float) -> Pending:
        """Tell the robot to enter the wanted mode, and set the outputs that this resets."""
        mode = self._core.status.wanted
        self._tries, self._tried_at = self._tries + 1, now
        if self._tries == 1:
            self._begun_at = now
        self._core.handle(StateEvent.MODE_ENTERED)
        sent = self._core.outbox.send(MODE_COMMANDS[mode](), f'robot is in {mode.name}')
        if mode in oi.ACTUATE:
            self._outputs.restore()
        return sent

    @property
    def entering(self) -> bool:
        """Whether the robot is about to enter the wanted mode, as far as is known."""
        return self._tries > 0 and not self._core.status.causes

    def entering_since(self, begun_at: float) -> bool:
        """
        Tell whether a goal that began then still waits for the mode from before it.

        It may have begun at a frame that was on its way when the robot was told to enter Passive.
        """
        return self.entering and self._begun_at <= begun_at

    def retry(self, now: float) -> None:
        """Enter the wanted mode again where the robot seems to have missed the command."""
        core, status = self._core, self._core.status
        if (not core.listening.may_send or status.actual in (None, status.wanted)
                or now - self._tried_at <= RETRY_INTERVAL):
            return
        # Full instead of Safe, or Safe instead of Full: no safety stop, but a damaged command.
        damaged = status.actual in oi.ACTUATE and status.wanted in oi.ACTUATE
        if damaged or self.entering and self._tries < MAX_TRIES:
            self.enter(now)

    def allow_driving(self, now: float) -> str | None:
        """
        Say why a fresh velocity is not followed, `advice` tells what to do; None where it is.

        While the robot enters a mode to drive in, a velocity waits for it. Where the robot has
        left the wanted mode, and may enter it again, tell it to.
        """
        status = self._core.status
        if status.wanted not in oi.ACTUATE:
            return self.wrong_mode()
        if status.can_drive or self.entering:
            return None
        if (not self._core.settings.recover_mode or not status.causes or status.actual is None
                or now - self._cause_seen_at < CLEAR_TIME):
            return self.wrong_mode()
        if not self._core.outbox.busy:
            self._core.notice(
                Severity.INFO, f'clear again (was: {status.reason}): entering '
                f'{status.wanted.name} again')
            self.enter(now)
        return None

    # What the robot reports.

    def forget(self) -> None:
        """Forget the actual mode: no robot answers."""
        self._core.set_status(ModeStatus(None, self._core.status.wanted))
        self._tries = 0

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Take a frame's mode in: notice a mode that was left, and one that was requested."""
        present = causes_in(readings)
        if present:
            self._cause_seen_at = now
        before, actual = self._core.status, readings.oi_mode
        causes = before.causes
        left = before.actual == before.wanted != actual
        # Without a cause it may only seem so: a frame from before the mode was entered came late.
        dropped = left and (bool(present) or now - self._begun_at > SETTLING_TIME)
        dropped |= actual is None and (left or before.can_drive)
        tried_in_vain = (
            self.entering and now - self._tried_at > RETRY_INTERVAL
            and (bool(present) or self._tries >= MAX_TRIES))
        if actual is None:
            causes = (Cause.MODE_UNKNOWN,)
        elif dropped:
            causes = present or self._causes_before or (
                (Cause.POWER,) if actual is oi.Mode.OFF else (Cause.UNKNOWN,))
        elif actual == before.wanted:
            causes, self._tries = (), 0
        elif left:
            self._tries = 1
        elif before.unknown or tried_in_vain:
            causes = present or (Cause.UNKNOWN,)
        self._causes_before = present
        self._core.set_status(ModeStatus(actual, before.wanted, causes))
        if dropped:
            self._mode_left(now)
        if actual is before.wanted:
            self._request.end(True, f'robot is in {actual.name}')

    def _mode_left(self, now: float) -> None:
        """Report why the robot left the wanted mode; end a demo that nobody asked for."""
        status = self._core.status
        self._core.handle(StateEvent.MODE_LEFT)
        self._core.notice(
            Severity.WARNING, f'robot left {status.wanted.name} for {status.name}: '
            f'{status.reason}')
        if self._core.listening.may_send and (status.causes == (Cause.UNKNOWN,) or (
                status.unknown and status.wanted is oi.Mode.PASSIVE)):
            self._core.outbox.send_at_once(END_DEMO, now)  # damaged bytes may have begun one

    def poll(self, now: float) -> None:
        """End a request whose mode the robot did not report in time."""
        self._begun_at, self._tried_at = min(self._begun_at, now), min(self._tried_at, now)
        if self._request.outcome is None and now > self._begun_at + MODE_TIMEOUT:
            self.fail()

    def fail(self, why: str = '') -> None:
        """End the request for a mode, if one waits; by default say what the robot does instead."""
        status = self._core.status
        does, needs = f'stays in {status.described}', (
            'in SAFE it needs all wheels down, no cliff under it and no charger plugged in')
        if status.actual is None and not status.unknown:
            does = f'does not answer ({status.reason})'
            needs = 'check cable and power, the driver keeps trying'
        elif docked(self._core.readings) or status.unknown:
            needs = self.advice()
        self._request.end(
            False, why or f'robot {does} instead of entering {status.wanted.name}: {needs}')

    # In words.

    def wrong_mode(self) -> str:
        """Say in which mode the robot is that is told to drive and does not."""
        status = self._core.status
        return (f'robot is to enter {status.wanted.name}' if status.can_drive else
                f'robot is in {status.described}')

    def advice(self, again: str = PAUSE) -> str:
        """Say how a robot that is in no mode to drive is brought to drive."""
        causes = self._core.status.causes
        if self._core.status.unknown:
            return 'call set_mode with SAFE; if that does not help, switch the robot off and on'
        if docked(self._core.readings):
            return 'send the goal undock, it is on its dock (dock and undock are actions)'
        if Cause.CHARGER in causes:
            return f"pull the charger's plug, {again}"
        if not causes:
            return 'call set_mode with SAFE'
        return f'{again}, or call set_mode with SAFE'

    # Demos; Passive is the wanted mode from then on.

    def start_demo(self, number: int) -> Pending:
        """Let the robot play a demo; the request ends when the command is written."""
        if number not in DEMOS:
            return refused(f'there is no demo {number}; allowed: 0 (Cover) to 9 (Banjo)')
        why = self._core.refusal(oi.Demo)
        if why is not None:
            return refused(why)
        self.want(oi.Mode.PASSIVE)
        return self.play_demo(oi.DemoNumber(number), StateEvent.DEMO_STARTED)

    def play_demo(self, demo: oi.DemoNumber, event: StateEvent) -> Pending:
        """Tell a robot that takes commands to play a demo; `event` says for whom."""
        self._core.handle(event)
        rest = 0.0
        if demo is oi.DemoNumber.COVER_AND_DOCK and self._core.status.can_drive:
            rest = DOCK_PAUSE
            self._core.outbox.send(oi.Start())
        return self._core.outbox.send(
            oi.Demo(demo=demo), f'demo {demo.name} sent; call stop_demo to end it', rest=rest)

    def stop_demo(self) -> Pending:
        """End the demo that runs, if any; the robot stays in Passive."""
        core = self._core
        why = core.refusal(oi.Demo)
        if why is not None:
            return refused(why)
        if core.state.robot_moves:
            self.want(oi.Mode.PASSIVE)
        elif core.status.can_drive:
            return done('no demo runs: the robot obeys cmd_vel')
        core.handle(StateEvent.DEMO_ENDED)
        return core.outbox.send(
            END_DEMO, 'end of the demo sent; call set_mode with SAFE to drive again')
