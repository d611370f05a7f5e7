"""
The host's side of the line, as a machine without clock, thread or I/O.

It mirrors the robot's: `receive(bytes, now)`, `poll(now)`, `data_to_send()`. Call `receive` when
bytes have come, `poll` whenever time has passed, and write what `data_to_send` returns; take
what happened with `next_event`. `now` is in seconds on any clock that does not go backwards.
Requests (drive, set_mode, ...) only change what is wanted; `poll` sends.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate, Geometry, Increment, Odometry
from .frame_clock import FrameClock
from .motion import MM, Motion, MotionLimits
from .outbox import Outbox
from .stream_plan import StreamPlan
from .supervision import MODE_COMMANDS, ModeStatus, Supervision

DRAIN = b'\xff' + bytes(260)
"""Ends any command that was cut short, harmlessly (manual: "waiting" state).

The first byte completes Baud or Demo as no baud code and as `abort`; zeros complete any count,
speed or output as nothing. Neither byte is an opcode.
"""
SILENCE = 0.5
"""Seconds without a frame after which the robot is taken to be away, and called again."""

Reply = Callable[[bool, str], None]
"""Takes whether a request succeeded, and if not why and what to do."""


class Severity(Enum):
    """How loud a notice is."""

    INFO = 'info'
    WARNING = 'warning'
    ERROR = 'error'


class Notice(NamedTuple):
    """Something a person should read, said once."""

    severity: Severity
    text: str


class Moved(NamedTuple):
    """A frame was taken in."""

    stamp: float
    """When the frame left the robot, in the clock of `now`."""
    readings: oi.Readings
    """The newest of every packet that has arrived so far."""
    estimate: Estimate


DriverEvent = Notice | Moved


@dataclass(frozen=True)
class Settings:
    """What the driver is to do; SI units."""

    baud: int = 57600
    mode_on_start: oi.Mode = oi.Mode.SAFE
    mode_on_exit: oi.Mode = oi.Mode.PASSIVE
    recover_mode: bool = True
    odometry_window: float = 0.0
    limits: MotionLimits = field(default_factory=MotionLimits)
    geometry: Geometry = field(default_factory=Geometry)


class Link(Enum):
    """State of the line to the robot."""

    CLOSED = 'port closed'
    WAKING = 'no answer yet'
    UP = 'robot answers'


@dataclass
class LinkCounts:
    """What has come over the line since the driver was made."""

    frames: int = 0
    checksum_failures: int = 0
    garbage_bytes: int = 0
    implausible_frames: int = 0
    silences: int = 0


class _ModeRequest(NamedTuple):
    mode: oi.Mode
    deadline: float
    reply: Reply


class Driver:
    """What the node talks to and the serial port is fed from."""

    def __init__(self, settings: Settings = Settings()) -> None:
        self.settings = settings
        self.odometry = Odometry(settings.geometry, window=settings.odometry_window)
        self.link = Link.CLOSED
        self.counts = LinkCounts()
        self.plan = StreamPlan(settings.baud)
        self._motion = Motion(settings.limits)
        self._supervision = Supervision(settings.mode_on_start, recover=settings.recover_mode)
        self._outbox = Outbox()
        self._reader = oi.StreamReader(self.plan.lists)
        self._clock = FrameClock()
        self._readings = oi.Readings()
        self._events: deque[DriverEvent] = deque()
        self._mode_request: _ModeRequest | None = None
        self._heard_at = 0.0
        self._refusal_said = False

    # What the line says.

    def connected(self, now: float) -> None:
        """Begin to talk: the port has been opened."""
        self._wake(now)

    def disconnected(self, why: str) -> None:
        """Stop talking: the port is gone."""
        self.link = Link.CLOSED
        self._reader.flush()
        self._lose()
        self._answer_mode_request(False, f'port lost: {why}')

    def receive(self, data: bytes, now: float) -> None:
        """Take in bytes that came from the robot."""
        self._reader.feed(data)
        while (event := self._reader.next_event()) is not None:
            match event:
                case oi.Frame():
                    self._take_frame(event, now)
                case oi.Garbage():
                    self.counts.garbage_bytes += len(event.data)
        self.counts.checksum_failures = self._reader.checksum_failures

    def poll(self, now: float) -> None:
        """Do what time asks for."""
        self._outbox.confirm()
        if self.link is Link.CLOSED:
            return
        if now - self._heard_at > SILENCE:
            self._miss(now)
        if self._mode_request is not None and now > self._mode_request.deadline:
            self._refuse_mode_request(self._mode_request.mode)
        if self._motion.expired(now):
            self._supervision.commands_paused()
        self._stream_and_drive(now)
        self._outbox.release(now)

    def data_to_send(self) -> bytes:
        """Return the bytes to write now; the next `poll` takes them as written."""
        return self._outbox.take()

    def next_event(self) -> DriverEvent | None:
        """Take out what has happened, oldest first."""
        return self._events.popleft() if self._events else None

    # What the user wants.

    @property
    def status(self) -> ModeStatus:
        """The wanted mode, the actual one, and why they differ."""
        return self._supervision.status

    @property
    def checksum(self) -> oi.Checksum | None:
        """The convention of checksums that the robot follows, once it is known."""
        return self._reader.checksum

    def drive(self, linear: float, angular: float, now: float) -> None:
        """Want a velocity, m/s and rad/s, until it is replaced or expires."""
        if not self._motion.command(linear, angular, now):
            self._say(Severity.WARNING, f'velocity ({linear} m/s, {angular} rad/s) is not finite: '
                      'stopped; send finite numbers')
        if not self._motion.moving:
            self._supervision.commands_paused()
        elif self.status.actual not in oi.DriveDirect.modes:
            self._drive_when_not_allowed(now)

    def stop(self, now: float) -> bool:
        """Stop the wheels before anything else is sent; False when no robot answers."""
        self._motion.stop()
        self._motion.forget()
        self._supervision.commands_paused()
        if self.link is not Link.CLOSED:
            self._outbox.send_at_once(oi.DriveDirect(right=0, left=0), now)
        return self.link is Link.UP

    def set_limits(self, limits: MotionLimits) -> None:
        """Bound the motion otherwise from the next command on."""
        self._motion.limits = limits

    def set_mode(self, mode: oi.Mode, now: float, reply: Reply) -> None:
        """Want a mode; the reply comes when the robot reports it, or does not."""
        if mode not in MODE_COMMANDS:
            allowed = ', '.join(f'{m.value} {m.name}' for m in MODE_COMMANDS)
            reply(False, f'mode {mode.name} cannot be set; allowed: {allowed}')
        elif self.link is not Link.UP:
            reply(False, f'{self.link.value}: check cable and power, the driver keeps trying')
        else:
            self._answer_mode_request(False, 'another set_mode came before the robot answered')
            self._mode_request = _ModeRequest(mode, now + SILENCE, reply)
            self._supervision.want(mode)
            self._enter(mode)

    def reset_odometry(self) -> None:
        """Put the origin of the odometry frame where the robot is."""
        self.odometry.reset()

    def shut_down(self, now: float) -> None:
        """Say goodbye: wheels stopped, stream halted, the mode that was asked for on exit."""
        self._answer_mode_request(False, 'driver is shutting down')
        if self.link is Link.CLOSED:
            return
        self._outbox.clear()
        for command in (
            oi.DriveDirect(right=0, left=0),
            oi.PauseResumeStream(state=oi.StreamState.PAUSE),
            MODE_COMMANDS[self.settings.mode_on_exit](),
        ):
            self._outbox.send_at_once(command, now)
        self.link = Link.CLOSED

    # How it is done.

    def _wake(self, now: float) -> None:
        """Call the robot, whatever state it is in, and stop it."""
        self.link = Link.WAKING
        self._heard_at = now
        self._lose()
        self._outbox.send_raw(DRAIN)
        self._outbox.send(oi.DriveDirect(right=0, left=0))
        self._outbox.send(oi.Start())
        stream = self.plan.next_stream(now, motion_due=True)
        if stream is not None:
            self._outbox.send(stream)

    def _lose(self) -> None:
        self._outbox.clear()
        self._motion.stop()
        self._motion.forget()
        self._supervision.lost()
        self.plan.restart()
        self._clock.restart()
        self.odometry.interrupted()

    def _miss(self, now: float) -> None:
        if self.link is Link.UP:
            self.counts.silences += 1
            self._say(Severity.ERROR, f'no frame for {SILENCE} s: the robot is off, asleep or '
                      'unplugged; calling it until it answers')
        self._wake(now)

    def _take_frame(self, frame: oi.Frame, now: float) -> None:
        readings = frame.readings
        if readings.implausible():
            self.counts.implausible_frames += 1
            return
        self.counts.frames += 1
        self._heard_at = now
        wire_time = frame.packets.budget(self.settings.baud).seconds
        stamp, dt = self._clock.stamp(now, wire_time)
        self._readings.update(readings)
        if self.link is Link.WAKING:
            self._found()
        self._supervise(now)
        self._events.append(Moved(
            stamp, oi.Readings(self._readings.__dict__), self._estimate(readings, dt)))

    def _estimate(self, readings: oi.Readings, dt: float) -> Estimate:
        asked = readings.has('distance', 'angle')
        return self.odometry.update(Increment(
            dt=dt,
            right=readings.requested_right_velocity / MM,
            left=readings.requested_left_velocity / MM,
            driven=readings.oi_mode in oi.DriveDirect.modes,
            distance=readings.distance if asked else None,
            angle=readings.angle if asked else None))

    def _found(self) -> None:
        self.link = Link.UP
        wanted = self.status.wanted
        self._say(Severity.INFO, f'robot answers; entering {wanted.name}')
        self._enter(wanted)

    def _enter(self, mode: oi.Mode) -> None:
        self._motion.forget()
        self._outbox.send(MODE_COMMANDS[mode]())

    def _supervise(self, now: float) -> None:
        dropped = self._supervision.observe(self._readings, now)
        status = self.status
        if dropped:
            self._refusal_said = False
            self._motion.stop()
            self._motion.forget()
            self._say(Severity.WARNING, f'robot left {status.wanted.name} for '
                      f'{self._readings.oi_mode.name}: {status.reason}')
        request = self._mode_request
        if request is not None and status.actual == request.mode:
            self._answer_mode_request(True, f'robot is in {request.mode.name}')

    def _drive_when_not_allowed(self, now: float) -> None:
        """Bring the wanted mode back for a fresh command, or say why it is not obeyed."""
        status = self.status
        if self._supervision.may_recover(now):
            if not self._outbox.busy:
                self._say(Severity.INFO, f'{status.reason} is gone: entering '
                          f'{status.wanted.name} again')
                self._enter(status.wanted)
            return
        self._motion.stop()
        if status.actual is not None and not self._refusal_said:
            self._refusal_said = True
            why = f' ({status.reason})' if status.reason else ''
            self._say(Severity.WARNING, f'not driving: robot is in {status.actual.name}{why}; '
                      'let commands pause and send again, or call set_mode with SAFE')

    def _stream_and_drive(self, now: float) -> None:
        if self.link is not Link.UP:
            return
        if self.status.actual in oi.DriveDirect.modes:
            drive = self._motion.next_drive(now)
            if drive is not None:
                self._outbox.send_at_once(drive, now)
        stream = self.plan.next_stream(now, motion_due=self.odometry.reading_due)
        if stream is not None:
            self._outbox.send(stream)

    def _answer_mode_request(self, success: bool, message: str) -> None:
        request, self._mode_request = self._mode_request, None
        if request is not None:
            request.reply(success, message)

    def _refuse_mode_request(self, mode: oi.Mode) -> None:
        actual = self.status.actual
        stays = 'does not answer' if actual is None else f'stays in {actual.name}'
        causes = self._supervision.status.reason
        why = f' ({causes})' if causes else ''
        self._answer_mode_request(
            False, f'robot {stays}{why} instead of entering {mode.name}: in SAFE it needs all '
            'wheels down, no cliff under it and no charger plugged in')

    def _say(self, severity: Severity, text: str) -> None:
        self._events.append(Notice(severity, text))
