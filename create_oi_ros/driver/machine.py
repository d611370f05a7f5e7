"""
The host's side of the line, as a machine without clock, thread or I/O.

It mirrors the robot's: `receive(bytes, now)`, `poll(now)`, `data_to_send()`. Call `receive` when
bytes have come, `poll` whenever time has passed, and write what `data_to_send` returns; take
what happened with `next_event`. `now` is in seconds on any clock that does not go backwards.
Requests (drive, set_mode, ...) only change what is wanted; `poll` sends.
"""

from collections import deque

from .. import oi
from .actuators import Actuators
from .calling import CALL_AGAIN, Calling, DRAIN
from .checks import TurnCheck
from .demos import Demos, END_DEMO
from .events import DriverEvent, Link, LinkCounts, ModeChanged, Moved, Notice, Severity
from .frame_budget import FrameBudget, too_slow
from .hearing import DEAF, Hearing, Turn
from .motion import Motion, MotionLimits
from .outbox import Outbox
from .power import BatteryLevel, BatteryWatch, LowBatteryAction
from .requests import mode_refusal, ModeRequest, Reply, Requests
from .scripts import Scripts
from .settings import Settings
from .stream_plan import StreamPlan
from .supervision import Cause, causes_in, MODE_COMMANDS, ModeStatus, Supervision
from .tracking import Taken, Tracking

SILENCE = 0.5
"""Seconds without a frame after which the robot is taken to be away, and called again."""
STANDSTILL = 1.0
"""Seconds between two calls after which this process is taken to have been stopped."""
STALE = 0.05
"""Seconds after that in which the system still hands out what came long ago."""


class Driver:
    """What the node talks to and the serial port is fed from."""

    def __init__(self, settings: Settings | None = None) -> None:
        self.settings = settings = settings or Settings()
        self.link = Link.CLOSED
        self.counts = LinkCounts()
        self._tracking = Tracking(settings, self.counts)
        self.odometry = self._tracking.odometry
        self.battery = BatteryWatch(settings.battery)
        self.turning = TurnCheck(settings.limits.wheel_separation)
        self.hearing = Hearing()
        self.frame_budget = FrameBudget()
        self._calling = Calling(settings.baud)
        self.plan = StreamPlan(self._calling.baud)
        self._motion = Motion(settings.limits)
        self._supervision = Supervision(settings.mode_on_start, recover=settings.recover_mode)
        self._outbox = Outbox()
        self._reader = oi.StreamReader(self.plan.lists)
        self._events: deque[DriverEvent] = deque()
        self._unjudged: deque[tuple[Taken, Moved]] = deque()
        self._status_told = self.status
        self._mode_request = ModeRequest()
        self._requests = Requests(self._outbox, self._refusal)
        self.actuators = Actuators(self._outbox, self._requests, lambda: self.readings)
        self.demos = Demos(self._outbox, self._requests, self._supervision, self._motion)
        self.scripts = Scripts(
            self._outbox, self._requests, self._motion, lambda: self.plan)
        self.heard_at = 0.0
        """When the last frame came, in the clock of `now`."""
        self._refusal_said = False
        self._slow_told = ''
        self._called_at: float | None = None
        self._stale_until = 0.0

    # What the line says.

    def connected(self, now: float) -> None:
        """Begin to talk: the port has been opened."""
        self._calling.begin()
        self._called_at = now
        self._judge_rate()
        self._wake(now)

    def disconnected(self, why: str) -> None:
        """Stop talking: the port is gone."""
        self.link = Link.CLOSED
        self._reader.flush()
        self._lose()
        self._mode_request.answer(False, f'port lost: {why}')

    def receive(self, data: bytes, now: float) -> None:
        """Take in bytes that came from the robot."""
        self._mind_standstill(now)
        if now < self._stale_until or self.scripts.take(data):
            return
        self.frame_budget.heard(len(data))
        self._reader.feed(data)
        while (event := self._reader.next_event()) is not None:
            match event:
                case oi.Frame():
                    self._take_frame(event, now)
                case oi.Garbage():
                    self.counts.garbage_bytes += len(event.data)
                    self._calling.overheard(event.data)
                    self._tracking.clock.suspect(len(event.data) / self.plan.short.frame_size)
        self.counts.checksum_failures = self._reader.checksum_failures

    def poll(self, now: float) -> None:
        """Do what time asks for."""
        self._outbox.confirm()
        if self.link is Link.CLOSED:
            return
        self._mind_standstill(now)
        while self._unjudged:
            self._judge(*self._unjudged.popleft(), now)
        if self.scripts.reading:
            self.heard_at = now
        if now - self.heard_at > (SILENCE if self.link is Link.UP else CALL_AGAIN):
            self._miss(now)
        overdue = self._mode_request.expired(now)
        if overdue is not None:
            self._refuse_mode_request(overdue)
        self.scripts.poll(now)
        if self._motion.expired(now):
            self._supervision.commands_paused()
        self._stream_and_drive(now)
        self._outbox.release(now)

    def data_to_send(self) -> bytes:
        """Return the bytes to write now; the next `poll` takes them as written."""
        return self._outbox.take()

    def next_event(self) -> DriverEvent | None:
        """Take out what has happened, oldest first."""
        if self._events:
            return self._events.popleft()
        if self.status != self._status_told:
            self._status_told = self.status
            return ModeChanged(self.status)
        return None

    # What the user wants.

    @property
    def status(self) -> ModeStatus:
        """The wanted mode, the actual one, and why they differ."""
        return self._supervision.status

    @property
    def readings(self) -> oi.Readings:
        """The newest of every packet that has arrived so far."""
        return self._tracking.readings

    @property
    def baud(self) -> int:
        """Bits per second at which the robot is spoken to; the port has to follow."""
        return self._calling.baud

    @property
    def hazards(self) -> tuple[Cause, ...]:
        """What would take the robot out of Safe mode now; empty before the first frame."""
        return tuple(causes_in(self.readings)) if self.readings.has('oi_mode') else ()

    @property
    def moving(self) -> bool:
        """Whether wheels are wanted to turn."""
        return self._motion.moving

    @property
    def checksum(self) -> oi.Checksum | None:
        """The convention of checksums that the robot follows, once it is known."""
        return self._reader.checksum

    def drive(self, linear: float, angular: float, now: float) -> None:
        """Want a velocity, m/s and rad/s, until it is replaced or expires."""
        if not self._motion.command(linear, angular, now):
            self._say(Severity.WARNING, f'velocity ({linear} m/s, {angular} rad/s) is not finite: '
                      'stopped; send finite numbers')
        if self.scripts.playing:
            self._motion.stop()
            self._say_refusal(self.scripts.refusal)
        elif not self._motion.moving:
            self._supervision.commands_paused()
        elif self.status.actual not in oi.DriveDirect.modes:
            self._drive_when_not_allowed(now)
        self._tell_speeds(now)

    def stop(self, now: float) -> tuple[bool, str]:
        """Stop the wheels, and a demo, before anything else; says whether the robot hears it."""
        self._motion.stop()
        self._motion.forget()
        self._supervision.commands_paused()
        if self.link is not Link.CLOSED:
            self._outbox.send_at_once(oi.DriveDirect(right=0, left=0), now)
        if self.status.actual is oi.Mode.PASSIVE:
            self._outbox.send_at_once(END_DEMO, now)
        if self.status.wanted is oi.Mode.PASSIVE and self._outbox.busy:
            self._outbox.send(END_DEMO)  # one may be about to begin
        refusal = DEAF if self.hearing.deaf else self._refusal(oi.Demo)
        return not refusal, refusal or 'wheels stopped'

    def set_limits(self, limits: MotionLimits) -> None:
        """Bound the motion otherwise from the next command on."""
        self._motion.limits = limits

    def set_mode(self, mode: oi.Mode, now: float, reply: Reply) -> None:
        """Want a mode; the reply comes when the robot reports it, or does not."""
        if mode not in MODE_COMMANDS:
            allowed = ', '.join(f'{m.value} {m.name}' for m in MODE_COMMANDS)
            reply(False, f'mode {mode.name} cannot be set; allowed: {allowed}')
        elif refusal := self._refusal(MODE_COMMANDS[mode]):
            reply(False, refusal)
        else:
            self._mode_request.begin(mode, now + SILENCE, reply)
            self._supervision.want(mode)
            self._enter(mode, now)

    def reset_odometry(self) -> None:
        """Put the origin of the odometry frame where the robot is."""
        self.odometry.reset()

    def shut_down(self, now: float) -> None:
        """Say goodbye: all that moves stopped, stream halted, the mode asked for on exit."""
        self._mode_request.answer(False, 'driver is shutting down')
        if self.link is Link.CLOSED:
            return
        self._outbox.clear()
        for command in (
            oi.DriveDirect(right=0, left=0),
            oi.PwmLowSideDrivers(driver_0=0, driver_1=0, driver_2=0),
            *((END_DEMO,) if self.status.actual is oi.Mode.PASSIVE else ()),
            oi.PauseResumeStream(state=oi.StreamState.PAUSE),
            MODE_COMMANDS[self.settings.mode_on_exit](),
        ):
            self._outbox.send_at_once(command, now)
        self.link = Link.CLOSED

    # How it is done.

    def _wake(self, now: float) -> None:
        """Call the robot, whatever state it is in, and stop it."""
        self.link = Link.WAKING
        self.heard_at = now
        self._lose()
        self._tune(self._calling.call())
        self._outbox.send_raw(DRAIN)
        self._outbox.send(oi.DriveDirect(right=0, left=0))
        self._outbox.send(oi.Start())
        stream = self.plan.next_stream(now, motion_due=True)
        if stream is not None:
            self._outbox.send(stream)

    def _tune(self, baud: int) -> None:
        """Plan for a baud rate; whoever holds the port follows `baud`."""
        if baud != self.plan.baud:
            self.plan = StreamPlan(baud)
            self._reader.expect(self.plan.lists)

    def _lose(self) -> None:
        self._outbox.clear()
        self.scripts.lost()
        self._motion.stop()
        self._motion.forget()
        self._supervision.lost()
        self.plan.restart()
        self._tracking.restart()
        self._unjudged.clear()
        self.hearing.restart()
        self.frame_budget.restart()

    def _miss(self, now: float) -> None:
        if self.link is Link.UP:
            self.counts.silences += 1
            self._calling.begin()
            why = self.frame_budget.why_silent(self.plan.budget, self.baud)
            self._say(Severity.ERROR, f'no frame for {SILENCE} s: {why}; calling it until it '
                      'answers')
        rest = self._reader.flush()
        if rest is not None:
            self._calling.overheard(rest.data)
        complaint = self._calling.complaint()
        if complaint is not None:
            self._events.append(complaint)
        self._wake(now)

    def _judge_rate(self) -> None:
        slow = too_slow(self.plan.budget, self.baud)
        if slow and slow != self._slow_told:
            self._say(Severity.ERROR, slow)
        self._slow_told = slow

    def _mind_standstill(self, now: float) -> None:
        """Begin anew after this process has been stopped: the dead-man may have acted."""
        still = 0.0 if self._called_at is None else now - self._called_at
        self._called_at = now
        if self.link is Link.UP and still > STANDSTILL:
            self._say(Severity.WARNING, f'the driver stood still for {still:.1f} s (Ctrl-Z, a '
                      'debugger, a computer that slept or was too busy); calling the robot anew')
            self._reader.flush()
            self._calling.begin()
            self._lose()
            self._outbox.send_at_once(oi.DriveDirect(right=0, left=0), now)
            # Called only when the rest is over, or the answer, with distance and angle, is lost.
            self.link, self._stale_until = Link.WAKING, now + STALE
            self.heard_at = self._stale_until - CALL_AGAIN

    def _take_frame(self, frame: oi.Frame, now: float) -> None:
        """Tell what a frame says; what follows from it is left to `poll`, for news are urgent."""
        taken = self._tracking.take(frame, self.baud, now)
        self.frame_budget.frame(frame.packets.frame_size)
        self.hearing.seen(frame.packets.ids)
        if taken is None:
            return
        self.heard_at = now
        if self.link is Link.WAKING:
            self._found(now)
        if self.scripts.heard(frame.packets):
            self._script_ended()
        moved = self._tracking.moved(taken, self.scripts.speeds(taken.readings))
        self._events.append(moved)
        self._unjudged.append((taken, moved))

    def _judge(self, taken: Taken, moved: Moved, now: float) -> None:
        """Draw the conclusions from a frame."""
        self._supervise(moved.readings, now)
        if self.turning.observe(taken.readings, taken.dt):
            self._say(Severity.WARNING, 'the angle does not change though the robot was told to '
                      'turn: are the wheels blocked, or does odometry_window: 0 hide slow turns? '
                      'Some firmware before 3.4.1 is reported to send a constant 0')
        if self.battery.observe(moved.readings, now):
            self._mind_battery(now)

    def _mind_battery(self, now: float) -> None:
        level, action = self.battery.level, self.battery.limits.action
        volts = f'{self.readings.voltage / 1000:.1f} V'
        self._say(Severity.WARNING, f'battery {level.value} ({volts}): charge it')
        if level is not BatteryLevel.EMPTY or action is LowBatteryAction.NONE:
            return
        if action is LowBatteryAction.DOCK:
            self.demos.start(oi.DemoNumber.COVER_AND_DOCK, lambda *_: None)
        else:
            self._motion.stop()
            self._supervision.want(oi.Mode.PASSIVE)
            self._enter(oi.Mode.PASSIVE, now)
        self._say(Severity.ERROR, f'battery {level.value}: low_battery_action {action.value}')

    def _found(self, now: float) -> None:
        self.link = Link.UP
        wanted = self.status.wanted
        self._judge_rate()
        self._say(Severity.INFO, f'robot answers; entering {wanted.name}')
        self.actuators.restore_songs()
        self._enter(wanted, now)

    def _enter(self, mode: oi.Mode, now: float) -> None:
        self._supervision.entering(now)
        self._motion.forget()
        self._outbox.send(MODE_COMMANDS[mode]())
        if mode in oi.ACTUATE:
            self.actuators.restore()

    def _script_ended(self) -> None:
        self._motion.forget()
        if self.scripts.recounts:
            self.odometry.recounted()
        self._say(Severity.INFO, 'the script has ended; wheels stopped')
        if self.readings.oi_mode in oi.ACTUATE:
            self.actuators.restore()

    def _refusal(self, command: type[oi.Command]) -> str:
        """Say why a command cannot be sent now, and what to do; '' if it can."""
        if self.link is not Link.UP:
            return f'{self.link.value}: check cable and power, the driver keeps trying'
        return self.scripts.refusal or mode_refusal(command, self.status.actual)

    def _supervise(self, readings: oi.Readings, now: float) -> None:
        dropped = self._supervision.observe(readings, now)
        status = self.status
        if dropped:
            self._refusal_said = False
            self._motion.stop()
            self._motion.forget()
            self._say(Severity.WARNING, f'robot left {status.wanted.name} for '
                      f'{readings.oi_mode.name}: {status.reason}')
            if status.causes == (Cause.UNKNOWN,):
                self._outbox.send_at_once(END_DEMO, now)  # damaged bytes may have begun one
        self._mode_request.observe(status.actual)
        if status.actual in oi.DriveDirect.modes and not self.scripts.refusal:
            self._motion.reported(
                readings.requested_right_velocity, readings.requested_left_velocity, now)
        self._mind_line(now)
        if self._supervision.must_enter_again(now) and not self.scripts.refusal:
            self._enter(status.wanted, now)

    def _mind_line(self, now: float) -> None:
        """Do something about a robot that does not hear, tell of one that is not heard well."""
        if self.scripts.refusal:
            self.hearing.restart()
            self.frame_budget.restart()
            return
        drives = self.status.actual in oi.DriveDirect.modes
        match self.hearing.turn(self._motion.missed if drives else 0, now):
            case Turn.DOUBTED:
                self._outbox.send_raw(DRAIN)
            case Turn.DEAF:
                self._say(Severity.ERROR, DEAF)
            case Turn.HEARS_AGAIN:
                self._hears_again()
        if self.frame_budget.judge(self.baud, now, fits=self.plan.budget.fits):
            complaint = self.frame_budget.complaint
            self._say(Severity.WARNING if complaint else Severity.INFO,
                      complaint or 'frames arrive in time again')

    def _hears_again(self) -> None:
        """Say all again that the robot may have missed."""
        self._motion.forget()
        self.actuators.restore_songs()
        if self.status.actual in oi.ACTUATE:
            self.actuators.restore()

    def _drive_when_not_allowed(self, now: float) -> None:
        """Bring the wanted mode back for a fresh command, or say why it is not obeyed."""
        status = self.status
        if self._supervision.may_recover(now):
            if not self._outbox.busy:
                self._say(Severity.INFO, f'{status.reason} is gone: entering '
                          f'{status.wanted.name} again')
                self._enter(status.wanted, now)
            return
        self._motion.stop()
        if status.actual is not None:
            why = f' ({status.reason})' if status.reason else ''
            self._say_refusal(f'robot is in {status.actual.name}{why}; let commands pause and '
                              'send again, or call set_mode with SAFE')

    def _say_refusal(self, why: str) -> None:
        if not self._refusal_said:
            self._refusal_said = True
            self._say(Severity.WARNING, f'not driving: {why}')

    def _tell_speeds(self, now: float) -> None:
        if (self.link is Link.UP and self.status.actual in oi.DriveDirect.modes
                and not self.scripts.refusal):
            drive = self._motion.next_drive(now)
            if drive is not None:
                self._outbox.send_at_once(drive, now)

    def _stream_and_drive(self, now: float) -> None:
        if self.link is not Link.UP or self.scripts.refusal:
            return
        self._tell_speeds(now)
        stream = self.plan.next_stream(now, motion_due=self.odometry.reading_due)
        if stream is not None:
            self._outbox.send(stream)
            self.hearing.asked(tuple(stream.packets), now)

    def _refuse_mode_request(self, mode: oi.Mode) -> None:
        actual = self.status.actual
        stays = 'does not answer' if actual is None else f'stays in {actual.name}'
        causes = self._supervision.status.reason
        why = f' ({causes})' if causes else ''
        self._mode_request.answer(
            False, f'robot {stays}{why} instead of entering {mode.name}: in SAFE it needs all '
            'wheels down, no cliff under it and no charger plugged in')

    def _say(self, severity: Severity, text: str) -> None:
        self._events.append(Notice(severity, text))
