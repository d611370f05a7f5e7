# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The host's side of the line, as a machine without clock, thread or I/O.

It mirrors the robot's: `receive(bytes, now)`, `poll(now)`, `data_to_send()`. Call `receive` when
bytes have come, `poll` whenever time has passed, and write what `data_to_send` returns; fetch
what happened with `next_event`. `now` is in seconds on any clock that does not go backwards.

What the driver is doing is one value, `state`: `Core.handle` changes it, and `_follow` does what
follows. A request (modes.set, outputs.set_leds, ...) returns a `Pending`; `poll` sends.
"""

from collections import deque
from copy import copy
from math import inf, isfinite

from .. import oi
from ..odometry import Odometry
from .battery import Battery, charging
from .connection import Connection
from .core import Core
from .events import DriverEvent, Health, ModeStatus, MotionLimits, Moved, Settings, Severity
from .goal_control import COMMANDED, GoalControl
from .listening import QUESTIONS
from .mode import causes_in, docked, Modes
from .motion import Motion
from .outbox import done, END_DEMO, farewell, HALT, LOST, Pending, refused
from .outputs import Outputs
from .script import ScriptControl
from .songs import Songs
from .state import Activity, StateEvent, Then
from .tracking import Tracking

SLOW_CHECK_INTERVAL = 0.1
"""Seconds between two checks of what changes within seconds."""
MAX_COORDINATE = 1e6
"""Metres from the origin where the robot can be said to be."""


class Driver:
    """The state machine between the node and the serial port."""

    def __init__(
        self, settings: Settings | None = None, odometry: Odometry | None = None,
    ) -> None:
        """Drive by these settings; `odometry` replaces the usual one."""
        self.core = core = Core(settings or Settings(), self._follow)
        self.settings = core.settings
        self.state = core.state
        self.counts = core.counts
        self._connection = Connection(core)
        self.plan = self._connection.plan
        """The lists of packets that the robot is asked to stream."""
        self.outputs = Outputs(core)
        self.songs = Songs(core)
        self.modes = Modes(core, self.outputs)
        self.motion = Motion(core, self.modes)
        self.scripts = ScriptControl(core, self.plan)
        self._tracking = Tracking(core, self.scripts, odometry)
        self.goals = GoalControl(core, self.motion, self.modes, self._tracking)
        self._battery = Battery(core, self.modes)
        self._on_dock = False
        """Whether the robot was on its dock, and no goal drove it, when that was checked last."""
        self._unchecked: deque[Moved] = deque()
        """Frames that were reported as events, and that `poll` still has to check."""
        self._check_at = -inf

    def _follow(self, event: StateEvent, consequences: tuple[Then, ...]) -> None:
        """Do what follows from an event."""
        for then in consequences:
            match then:
                case Then.STAND:
                    self.motion.stop()
                case Then.AGAIN:
                    self.motion.send_again()
                case Then.CALL_OFF:
                    self.core.outbox.call_off_motion()
                case Then.FORGET:
                    self._forget()
                case Then.END:
                    self.goals.taken_over(event)
                case Then.GIVE_BACK | Then.RESTORE:
                    self.modes.give_back(enter=then is Then.RESTORE)
                case _:  # WARN
                    self.motion.warn_again()

    def _forget(self) -> None:
        """Forget what is known of the robot, and end what waits for it."""
        self.plan.asked = None
        self.core.listening.trust()
        self._tracking.restart()
        self.modes.forget()
        self.motion.resume()
        self.scripts.forget()
        self._unchecked.clear()
        self.songs.fail(LOST)
        self.modes.fail()

    # What arrives and leaves, and what happened.

    def connected(self, now: float) -> None:
        """Start to call the robot: the port has been opened."""
        self._connection.opened(now)

    def disconnected(self, why: str) -> None:
        """Stop talking: the port is gone."""
        self._connection.reader.flush()
        self.core.outbox.clear()
        self.modes.fail(f'port lost: {why}')
        self.core.handle(StateEvent.PORT_CLOSED)

    def receive(self, data: bytes, now: float) -> None:
        """Take in bytes that came from the robot."""
        self._connection.check_standstill(now)
        reader = self._connection.reader
        if now < self._connection.stale_until:
            return
        reader.feed(data)
        while (event := reader.next_event()) is not None:
            if isinstance(event, oi.Frame):
                self._take_frame(event, now)
            else:
                self._connection.add_garbage(event.data)
        self.counts.checksum_failures = reader.checksum_failures

    def poll(self, now: float) -> None:
        """Check new frames, advance timers, and make ready what is to be sent."""
        self.core.outbox.confirm()
        if self.state.activity is Activity.CLOSED:
            return
        self._connection.check_standstill(now)
        self._check_frames(now)
        self._connection.check_silence(now)
        self.modes.poll(now)
        self.songs.poll(now)
        if self.state.pursues:
            self.goals.poll(now)
        self.motion.poll(now)
        listening = self.core.listening
        if not self.state.takes_commands:
            listening.trust()
        elif listening.check(self.motion.missed_since, now):
            self._send_again()
        listening.poll(now)
        self._connection.ask(now, motion_due=self._tracking.odometry.reading_due)
        self.core.outbox.release(now)

    def data_to_send(self) -> bytes:
        """Return the bytes to write now; the next `poll` takes them as written."""
        return self.core.outbox.take_ready()

    def next_event(self) -> DriverEvent | None:
        """Remove and return what has happened, oldest first."""
        return self.core.events.popleft() if self.core.events else None

    # What is known.

    @property
    def status(self) -> ModeStatus:
        """The wanted mode, the actual one, and why they differ."""
        return self.core.status

    @property
    def baud(self) -> int:
        """Bits per second at which the robot is called; the port has to follow."""
        return self._connection.baud

    def health(self, now: float) -> Health:
        """Return what is known of driver, line and robot."""
        readings, connection = self.core.readings, self._connection
        return Health(
            activity=self.state.activity, answered=self.state.answered,
            busy=self.scripts.status(now) or self.state.refusal,
            mode=self.status,
            hazards=causes_in(readings) if readings.has('oi_mode') else (),
            readings=readings, odd=dict(self._tracking.odd.newest), counts=copy(self.counts),
            line_problem=connection.problem,
            frame_age=now - connection.frame_at if self.counts.frames else None,
            spare_bytes=self.plan.budget.spare, checksum=connection.reader.checksum,
            ignores_commands=self.core.listening.ignores,
            suspects_commands=bool(self.core.listening.doubt),
            robot=self._tracking.robot, gyro=self._tracking.odometry.gyro,
            battery=self._battery.level, charging=charging(readings),
            songs=tuple(sorted(self.songs.defined)))

    # What is requested.

    def drive(self, linear: float, angular: float, now: float) -> None:
        """Follow a velocity, m/s and rad/s, until the next command or the timeout."""
        self._connection.check_standstill(now)
        finite = self.motion.check_numbers(linear, angular)
        if self.state.pursues:
            if not (finite and self.core.limits.commands_interrupt and (linear or angular)):
                return
            borrowed = self.modes.own is not self.status.wanted
            self.goals.finish(COMMANDED, now)
            if borrowed:
                return  # the robot first has to enter its mode
        self.motion.command(linear, angular, now)

    def stop(self, now: float) -> Pending:
        """Stop the wheels, and a demo, before anything else; says whether the robot obeys."""
        if self.state.activity is not Activity.CLOSED and self.core.listening.may_stop:
            self.core.outbox.send_at_once(HALT, now)
            if self._may_play_demo:
                self.core.outbox.send_at_once(END_DEMO, now)
            self.core.listening.stop_sent = True
        if self.core.outbox.call_off_motion() and self.scripts.playing:
            self.core.listening.close()
            self.plan.asked = None
            self.core.handle(StateEvent.SCRIPT_ENDED)
        self.core.handle(StateEvent.STOPPED)
        why = self.scripts.status(now) or self.core.refusal(oi.Demo)
        return done('stop sent') if why is None else refused(why)

    @property
    def _may_play_demo(self) -> bool:
        """Whether the robot may play a demo, or begin one before its next frame."""
        return (self.status.unknown
                or oi.Mode.PASSIVE in (self.status.actual, self.status.wanted))

    def set_limits(self, limits: MotionLimits) -> None:
        """Change the limits, from the next command on."""
        self.core.limits = limits

    def reset_odometry(self) -> Pending:
        """Put the origin of the odometry frame where the robot is; not while a goal needs it."""
        return self._place(0.0, 0.0, 0.0, 'odom starts again where the robot is')

    def reset_pose(self, x: float, y: float, yaw: float) -> Pending:
        """Say where the robot is in the odometry frame, m and rad; not while a goal needs it."""
        if not (abs(x) <= MAX_COORDINATE and abs(y) <= MAX_COORDINATE and isfinite(yaw)):
            return refused(f'pose x {x:g} m, y {y:g} m, yaw {yaw:g} rad; allowed: up to '
                           f'{MAX_COORDINATE:g} m from the origin, and a finite yaw')
        return self._place(x, y, yaw, f'odom goes on from x {x:g} m, y {y:g} m, yaw {yaw:g} rad')

    def _place(self, x: float, y: float, yaw: float, text: str) -> Pending:
        if self.state.pursues:
            return refused('a goal runs and needs the odometry: cancel it first')
        self._tracking.odometry.reset(x, y, yaw)
        return done(text)

    def shut_down(self, now: float) -> None:
        """Stop all that moves, pause the stream, and leave the robot in the mode for exit."""
        if self.state.activity is Activity.CLOSED:
            return
        try:
            mode = oi.Mode.PASSIVE if self._may_play_demo else self.status.actual
            self.core.outbox.clear(*farewell(mode, self.settings.mode_on_exit))
            self.songs.fail('driver is shutting down')
            self.modes.fail('driver is shutting down')
            script = self.scripts.status(now)
            if script is not None:
                self.core.notice(
                    Severity.ERROR, f'the driver ends, but {script}; the script moves the wheels')
            self.goals.driver_ends()
        finally:
            self.core.handle(StateEvent.PORT_CLOSED)

    # How frames are handled.

    def _take_frame(self, frame: oi.Frame, now: float) -> None:
        """Report a frame at once: a bump must not wait until `poll` has checked everything."""
        before, activity, connection = self.core.readings, self.state.activity, self._connection
        answers = connection.take_answer(frame.packets, now)
        if frame.packets in QUESTIONS:
            if answers and self.state.answered:
                self._check_frames(now)  # speeds go on from those that were reported before
                self._send_again()
            return
        moved = self._tracking.take(frame, connection.baud, now)
        connection.add_frame(now)
        if answers and activity is Activity.SCRIPT:
            self._after_script()
        if moved is None:
            return
        if activity is Activity.CALLING:
            self._found(before, now)
        connection.present_at = now
        self.core.events.append(moved)
        self._unchecked.append(moved)

    def _found(self, before: oi.Readings, now: float) -> None:
        """Enter the wanted mode; `before` is what was known before this first frame."""
        had, mode = (each.oi_mode if each.has('oi_mode') else None
                     for each in (before, self.core.readings))
        away = self._connection.was_away(now) or had is not None and (
            had is not mode or mode not in oi.ACTUATE)
        self.core.listening.close()
        self.core.handle(StateEvent.RETURNED if away else StateEvent.ANSWERED)
        wanted = self.status.wanted
        self.core.notice(Severity.INFO, f'robot answers; entering {wanted.name}')
        self.outputs.switch_drivers_off()
        self.songs.restore()
        self.modes.enter(now)

    def _after_script(self) -> None:
        """React to a robot that has shown that its script has ended."""
        self.core.handle(StateEvent.SCRIPT_ENDED)
        if self.scripts.resets_accumulators:
            self._tracking.odometry.recounted()
        self.core.notice(Severity.INFO, (
            'the robot obeys between the rounds of its script, which may go on: an empty script '
            '(define_script) ends it' if self.scripts.goes_on else
            'the script has ended; wheels stopped'))
        if self.core.readings.oi_mode in oi.ACTUATE:
            self.outputs.restore()
        else:
            self.core.handle(StateEvent.MODE_LEFT)

    def _check_frames(self, now: float) -> None:
        """React to what new frames say about mode, commands, line and battery."""
        while self._unchecked:
            moved = self._unchecked.popleft()
            readings = moved.readings
            if self.state.pursues:
                self.goals.see(moved, now)
            self.modes.observe(readings, now)
            self.motion.observe(readings, now)
            self.modes.retry(now)
            if now >= self._check_at:
                self._check_at = now + SLOW_CHECK_INTERVAL
                self._check_slow(readings, now)

    def _check_slow(self, readings: oi.Readings, now: float) -> None:
        """Check what changes within seconds: battery, dock, what is known of the robot."""
        self._battery.observe(readings, now)
        self._tracking.report_robot()
        was_on_dock, pose = self._on_dock, self.settings.dock_pose
        self._on_dock = docked(readings) and self.state.activity is not Activity.GOAL
        if pose is not None and self._on_dock and not was_on_dock:
            self._tracking.odometry.reset(*pose)
            self.core.notice(Severity.INFO, 'on the dock: odom goes on from dock_pose')

    def _send_again(self) -> None:
        """Send again what the robot may have missed: its list, speeds, songs, LEDs, outputs."""
        self.plan.asked = None
        self.motion.resume()
        self.songs.restore()
        if self.status.actual in oi.ACTUATE:
            self.outputs.restore()
