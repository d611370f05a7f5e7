# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The host's side of the line, as a machine without clock, thread or I/O.

It mirrors the robot's: `receive(bytes, now)`, `poll(now)`, `data_to_send()`. Call `receive` when
bytes have come, `poll` whenever time has passed, and write what `data_to_send` returns; fetch
what happened with `next_event`. `now` is in seconds on any clock that does not go backwards.

What the driver is doing is one value, `state`. `_handle` is the only place where it changes, and
where the wheels and the other parts are told. A request (set_mode, outputs.set_leds, ...) returns
a `Pending`; `poll` sends.
"""

from collections import deque
from copy import copy
from math import inf

from .. import oi
from ..odometry import Odometry
from .acquaintance import Acquaintance
from .battery_guard import BatteryGuard
from .charge_watch import ChargeWatch
from .command_watch import IGNORES
from .connection import Connection
from .demos import Demos
from .events import DriverEvent, EventQueue, LinkCounts, ModeChanged, Moved, Severity
from .goal_control import GoalControl
from .goals.hazards import BUMPS
from .health import Health
from .modes import Modes
from .motion import MotionLimits, WheelCommands
from .outbox import LOST, Outbox
from .outputs import Outputs
from .pending import done, Pending, refused
from .plausibility import ANGLE_STUCK, TurnCheck
from .requests import Requests
from .script_control import ScriptControl
from .script_speeds import requested_speeds
from .settings import Settings
from .state import Activity, Owner, State, StateEvent
from .stopping import END_DEMO, farewell, HALT
from .stream_plan import StreamPlan
from .supervision import causes_in, ModeStatus, Supervision
from .tracking import Taken, Tracking
from .velocity_control import VelocityControl

ROBOT_UNKNOWN = (StateEvent.OPENED, StateEvent.NO_ANSWER, StateEvent.PORT_CLOSED)
"""Events after which nothing is known of the robot."""
LOOK_INTERVAL = 0.1
"""Seconds between two looks at what changes within seconds."""
SPEEDS_HOLD = (StateEvent.VELOCITY, StateEvent.HALTED)
"""Events after which the wheels still run at the speeds that were sent last."""


class Driver:
    """The state machine between the node and the serial port."""

    def __init__(
        self, settings: Settings | None = None, odometry: Odometry | None = None,
    ) -> None:
        """Drive by these settings; `odometry` replaces the usual one."""
        self.settings = settings = settings or Settings()
        self.state = State()
        self.counts = LinkCounts()
        self._events = EventQueue()
        self._outbox = Outbox()
        self._wheels = WheelCommands(settings.limits)
        self._supervision = Supervision(settings.mode_on_start, recover=settings.recover_mode)
        self._tracking = Tracking(settings, self.counts, odometry)
        self._acquaintance = Acquaintance(settings.robot, self._events)
        self._turn_check = TurnCheck(settings.limits.wheel_separation)
        self._connection = Connection(
            settings.baud, self.state, self._outbox, self._events, self.counts, self._handle)
        self._requests = requests = Requests(self._outbox, self.state, self._supervision)
        self.outputs = Outputs(self._outbox, requests, self._tracking)
        self.demos = Demos(
            self._outbox, requests, self.state, self._supervision, self._handle)
        self.scripts = ScriptControl(
            self._outbox, requests, self.state, self._connection.plan,
            settings.limits.wheel_separation, self._handle)
        self._modes = Modes(self._supervision, self.state, self._outbox, requests, self.outputs,
                            self._events, self._handle)
        self._battery = BatteryGuard(settings.battery, self.demos, self._modes, self._events)
        self._charging = ChargeWatch(
            self._supervision, self._outbox, self._events, reset=settings.reset_when_not_charging)
        self.goals = GoalControl(
            self._wheels, self.state, self._supervision, self._modes, self.demos, self._outbox,
            self._events, self._tracking, self._handle)
        self._velocity = VelocityControl(
            self._wheels, self.state, self._supervision, self._modes, self.goals, self._outbox,
            self._events, self._handle)
        self._unchecked: deque[tuple[Taken, Moved]] = deque()
        """Frames that were reported as events, and that `poll` still has to check."""
        self._look_at = -inf
        self._mistakes: set[str] = set()
        self._reported_status = self.status

    def _handle(self, event: StateEvent) -> None:
        """Let an event change the state; tell the wheels and the other parts what follows."""
        if not self.state.knows(event):
            self._report_unknown(event)
            return
        self.state.handle(event)
        if not self.state.moving:
            self._wheels.stop()
        if self.state.owner is not Owner.ROBOT:
            self._outbox.call_off_motion()
        if event not in SPEEDS_HOLD:
            self._wheels.forget_sent()
        if event in ROBOT_UNKNOWN:
            self.outputs.fail(LOST)
            self._connection.forget()
            self._tracking.restart()
            self._supervision.lost()
            self._wheels.hold(False)
            self.scripts.forget()
            self._unchecked.clear()
        self.goals.handled(event)

    def _report_unknown(self, event: StateEvent) -> None:
        """Log once a mistake of the driver: an event where no table lists it."""
        mistake = (f'{event.name} came in {self.state.activity.name}, where the driver does not '
                   'expect it, and is ignored: please report this')
        if mistake not in self._mistakes:
            self._mistakes.add(mistake)
            self._events.notice(Severity.WARNING, mistake)

    # What arrives and leaves, and what happened.

    def connected(self, now: float) -> None:
        """Start to call the robot: the port has been opened."""
        self._connection.opened(now)

    def disconnected(self, why: str) -> None:
        """Stop talking: the port is gone."""
        self._connection.reader.flush()
        self._outbox.clear()
        self._handle(StateEvent.PORT_CLOSED)
        self._modes.fail(f'port lost: {why}')

    def receive(self, data: bytes, now: float) -> None:
        """Take in bytes that came from the robot."""
        self._connection.check_standstill(now)
        if self.state.activity is Activity.READING:
            self.scripts.receive(data)
        elif self._connection.feed(data, now):
            self._take_events(self._connection.reader, now)

    def _take_events(self, reader: oi.StreamReader, now: float) -> None:
        """Take frames and garbage from the bytes that came."""
        while (event := reader.next_event()) is not None:
            if isinstance(event, oi.Frame):
                if event.packets is self.plan.knock:
                    self._connection.heard_knock(now)
                else:
                    self._take_frame(event, now)
            else:
                self._connection.add_garbage(event.data)
                self._tracking.clock.suspect(len(event.data) / self.plan.short.frame_size)
        self.counts.checksum_failures = reader.checksum_failures

    def poll(self, now: float) -> None:
        """Check new frames, advance timers, and make ready what is to be sent."""
        self._outbox.confirm()
        if self.state.activity is Activity.CLOSED:
            return
        self._connection.check_standstill(now)
        while self._unchecked:
            self._check_frame(*self._unchecked.popleft(), now)
        if not self.state.takes_commands:
            if self.scripts.reading:
                self._connection.heard_at = now
            self.scripts.poll(now, self._connection.heard_at)
        self._connection.check_silence(now)
        self._modes.check_timeout(now)
        self.outputs.check_timeout(now)
        if self.goals.active:
            self.goals.poll(now)
        self._velocity.poll(now)
        if self._connection.probe(now):
            self._send_again()
        if (self.state.takes_commands and not self._connection.suspects
                and not self._outbox.busy):
            stream = self._connection.plan.next_stream(
                now, motion_due=self._tracking.reading_due)
            if stream is not None:
                self._connection.ask(stream, now)
        self._outbox.release(now)

    def data_to_send(self) -> bytes:
        """Return the bytes to write now; the next `poll` takes them as written."""
        return self._outbox.take_ready()

    def next_event(self) -> DriverEvent | None:
        """Remove and return what has happened, oldest first."""
        if self._events:
            return self._events.popleft()
        before, status = self._reported_status, self._supervision.status
        if status is before:
            return None
        self._reported_status = status
        return ModeChanged(status) if status != before else None

    # What is known.

    @property
    def status(self) -> ModeStatus:
        """The wanted mode, the actual one, and why they differ."""
        return self._supervision.status

    @property
    def baud(self) -> int:
        """Bits per second at which the robot is called; the port has to follow."""
        return self._connection.baud

    @property
    def busy(self) -> bool:
        """Whether commands wait to be made ready by `poll`."""
        return self._outbox.busy

    @property
    def plan(self) -> StreamPlan:
        """The lists of packets that the robot is asked to stream."""
        return self._connection.plan

    def health(self, now: float) -> Health:
        """Return what is known of driver, line and robot."""
        readings, connection = self._tracking.readings, self._connection
        return Health(
            activity=self.state.activity, answered=self.state.answered,
            busy=self.scripts.status(now) or self.state.refusal,
            mode=self.status,
            hazards=causes_in(readings) if readings.has('oi_mode') else (),
            readings=readings, odd=dict(self._tracking.odd.newest), counts=copy(self.counts),
            line_problem=connection.problem,
            frame_age=now - connection.heard_at if self.counts.frames else None,
            spare_bytes=connection.plan.budget.spare, checksum=connection.reader.checksum,
            ignores_commands=connection.ignores_commands,
            suspects_commands=connection.suspects, angle_stuck=self._turn_check.stuck,
            frame_period=self._tracking.clock.known_period, robot=self._tracking.robot,
            battery=self._battery.level, songs=tuple(sorted(self.outputs.songs)))

    # What is requested.

    def drive(self, linear: float, angular: float, now: float) -> None:
        """Follow a velocity, m/s and rad/s, until the next command or the timeout."""
        self._velocity.command(linear, angular, now)

    def stop(self, now: float) -> Pending:
        """Stop the wheels, and a demo, before anything else; says whether the robot obeys."""
        activity = self.state.activity
        sends = activity is not Activity.CLOSED and (
            activity is not Activity.SCRIPT or self.scripts.may_stop())
        if sends and not (self._wheels.held and self._wheels.told_to_stand):
            self._outbox.send_at_once(HALT, now)
            if self._may_play_demo:
                self._outbox.send_at_once(END_DEMO, now)
        if self._outbox.call_off_motion() and self.scripts.playing:
            self.scripts.call_off()
        self._handle(StateEvent.STOPPED)
        why = IGNORES if self._connection.ignores_commands else (
            self.scripts.status(now) or self._requests.refusal(oi.Demo))
        return done('stop sent') if why is None else refused(why)

    @property
    def _may_play_demo(self) -> bool:
        """Whether the robot may play a demo, or begin one before its next frame."""
        return (self.status.unknown
                or oi.Mode.PASSIVE in (self.status.actual, self.status.wanted))

    def set_limits(self, limits: MotionLimits) -> None:
        """Change the limits, from the next command on."""
        self._wheels.limits = limits

    def set_mode(self, mode: oi.Mode, now: float) -> Pending:
        """Want a mode; the request ends when the robot reports it, or after a timeout."""
        return self._modes.set(mode, now)

    def reset_odometry(self) -> Pending:
        """Put the origin of the odometry frame where the robot is; not while a goal needs it."""
        if self.goals.active:
            return refused('a goal runs and needs the odometry: cancel it first')
        self._tracking.odometry.reset()
        return done('odom starts again where the robot is')

    def shut_down(self, now: float) -> None:
        """Stop all that moves, pause the stream, and leave the robot in the mode for exit."""
        if self.state.activity is Activity.CLOSED:
            return
        try:
            mode = oi.Mode.PASSIVE if self._may_play_demo else self.status.actual
            self._outbox.clear(*farewell(mode, self.settings.mode_on_exit))
            self._modes.fail('driver is shutting down')
            script = self.scripts.status(now)
            if script is not None:
                self._events.notice(
                    Severity.ERROR, f'the driver ends, but {script}; the script moves the wheels')
            self.goals.driver_ends()
        finally:
            self._handle(StateEvent.PORT_CLOSED)

    # How frames are handled.

    def _take_frame(self, frame: oi.Frame, now: float) -> None:
        """Report a frame at once: a bump must not wait until `poll` has checked everything."""
        before = self._tracking.readings
        taken = self._tracking.take(frame, self._connection.baud, now)
        self._connection.add_frame(frame.packets)
        self._connection.heard_at = now
        if taken is None:
            return
        for text in self._tracking.odd.news:
            self._events.notice(Severity.WARNING, text)
        self._tracking.odd.news.clear()
        activity = self.state.activity
        if activity is Activity.CALLING:
            self._found(before, now)
        elif activity is Activity.SCRIPT and self.scripts.ended(frame.packets):
            self._after_script()
        self._connection.present_at = now
        moved = self._tracking.moved(taken, self.scripts.speeds(taken.readings))
        self._events.append(moved)
        self._unchecked.append((taken, moved))

    def _found(self, before: oi.Readings, now: float) -> None:
        """Enter the wanted mode; `before` is what was known before this first frame."""
        had, mode = (each.oi_mode if each.has('oi_mode') else None
                     for each in (before, self._tracking.readings))
        away = self._connection.was_away(now) or had is not None and (
            had is not mode or mode not in oi.ACTUATE)
        self._connection.answered(StateEvent.RETURNED if away else StateEvent.ANSWERED)
        self._velocity.report_next_refusal()
        wanted = self.status.wanted
        self._events.notice(Severity.INFO, f'robot answers; entering {wanted.name}')
        self.outputs.restore_songs()
        self._modes.enter(wanted, now)

    def _after_script(self) -> None:
        if self.scripts.resets_accumulators:
            self._tracking.odometry.recounted()
        self._events.notice(Severity.INFO, (
            'the robot obeys between the rounds of its script, which may go on: an empty script '
            '(define_script) ends it' if self.scripts.goes_on else
            'the script has ended; wheels stopped'))
        if self._tracking.readings.oi_mode in oi.ACTUATE:
            self.outputs.restore()
        else:
            self._handle(StateEvent.MODE_LEFT)

    def _check_frame(self, taken: Taken, moved: Moved, now: float) -> None:
        """React to what a frame says about mode, commands, line, angle and battery."""
        readings = moved.readings
        self._wheels.blocked = bool(readings.number('bumps_and_wheel_drops', 0) & BUMPS)
        if self.goals.active:
            self.goals.see(moved, taken.dt, measured=taken.readings.has('distance'), now=now)
            if self.goals.wants_reading:
                self._tracking.odometry.hurry()
        self.outputs.observe(moved.readings)
        if self._modes.observe(readings, now):
            self._velocity.report_next_refusal()
        status = self.status
        drives = status.can_drive
        right, left = requested_speeds(readings)
        seen = (drives or status.unknown) and None not in (right, left)
        if seen and self.state.takes_commands:
            self._wheels.reported(right, left, now)
        else:
            self._wheels.missed_since = None
        if self._connection.check_line(self._wheels.missed_since, now):
            self._send_again()
        elif self._connection.suspects is not self._wheels.held:
            self._wheels.hold(self._connection.suspects)
        if status.actual is not status.wanted and not self._connection.suspects:
            self._modes.retry(now)
        if self._turn_check.observe(taken.readings, taken.dt, drives=drives):
            self._events.notice(Severity.WARNING, ANGLE_STUCK)
        if now >= self._look_at:
            self._look_at = now + LOOK_INTERVAL
            self._look(readings, now)

    def _look(self, readings: oi.Readings, now: float) -> None:
        """Look at what changes within seconds: battery, charger, what is known of the robot."""
        self._battery.observe(readings, now)
        self._charging.observe(readings, now)
        if self._acquaintance.due(now):
            self._acquaintance.look(self._tracking.robot)

    def _send_again(self) -> None:
        """Send again what the robot may have missed: speeds, songs, LEDs, outputs."""
        self._wheels.hold(False)
        self.outputs.restore_songs()
        if self.status.actual in oi.ACTUATE:
            self.outputs.restore()
