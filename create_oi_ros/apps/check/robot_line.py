# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The robot of a check: it does moves, one at a time, and nothing may disturb them.

`Runner` is pure, as the driver is; `RobotLine` has it at a port, in real time, with a capture.
"""

from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from itertools import cycle
from math import inf
import threading
import time

from ... import __version__, oi
from ...driver import (
    Driver,
    DriverEvent,
    Health,
    MotionLimits,
    Notice,
    Outcome,
    Settings,
    Severity,
)
from ...driver.goals.motions import bumps
from ...link.capture import Capture
from ...link.session import Session
from ...odometry import Estimate, GyroSettings, Increment, Odometry
from ...oi.tools.capture_format import RecordKind
from ...robot import MM_PER_M, SLOT
from ...ros.programs import UserError
from .moves import Move, Reads, REST, Segment

LIMITS = MotionLimits(linear_acceleration=0.0, angular_acceleration=0.0)
"""None on accelerations: steps show most of a robot."""
TELLING = 0.8
"""Seconds after a request in which readings are frequent."""
MOST_LOOKS = 30
"""Readings before a move after which it begins though they are not zero."""
TURN = 0.02
"""Seconds between two looks."""
ANSWER = 15.0
"""Seconds within which a robot must answer."""


class Notebook(Odometry):
    """Takes the place of the driver's odometry: learns as ever, but asks for readings as told."""

    reading_due = False
    """Whether the next frame should carry distance and angle."""

    def __init__(self) -> None:
        super().__init__(window=1.0, gyro=GyroSettings())
        self.reading = Increment(0.0, 0.0, 0.0)
        """The newest frame that had a reading."""
        self.seconds = 0.0
        """The robot's time since the first frame."""
        self._intervals: Iterator[int] = iter(())
        self._wait = 0
        """Frames until a reading is due by itself; 0 or less: none is."""

    def ask(self, intervals: tuple[int, ...] = ()) -> None:
        """Ask for a reading until one comes, and for others so many frames apart, in turn."""
        self._intervals = cycle(intervals)
        self._wait, self.reading_due = next(self._intervals, 0), True

    def ask_no_more(self) -> None:
        """Ask for no more readings."""
        self._wait, self.reading_due = 0, False

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        if increment.distance is not None:
            self.reading, self.reading_due = increment, False
        self.seconds += increment.dt
        self._wait -= 1
        if self._wait == 0:
            self._wait, self.reading_due = next(self._intervals), True
        return super().update(increment)


class Runner:
    """One robot that moves as told. Pure, as the driver is: `poll` has the time."""

    def __init__(self, driver: Driver, notebook: Notebook) -> None:
        self._driver, self._notebook = driver, notebook
        driver.set_limits(LIMITS)
        self.disturbance: str | None = None
        """Why the last move ended early; None where it did not."""
        self._steps: Iterator[None] | None = None
        """What is left of the move; None: nothing."""
        self._now = 0.0

    @property
    def busy(self) -> bool:
        """Whether a move is under way."""
        return self._steps is not None

    def begin(self, move: Move) -> None:
        """Start a move."""
        self.disturbance = None
        self._steps = self._do(move)

    def poll(self, now: float) -> None:
        """Go on with the move, once in a frame."""
        if self._steps is None or now - self._now < SLOT:
            return
        self._now = now
        self.disturbance = self._disturbance()
        if self.disturbance is not None:
            self._notebook.ask_no_more()
            self._driver.stop(now)
            self._steps = None
        elif next(self._steps, True):
            self._steps = None

    def _do(self, move: Move) -> Iterator[None]:
        """Do a move, from the moment when the counts are empty to the last reading."""
        notebook = self._notebook
        for _ in range(MOST_LOOKS):
            reading = yield from self._read()
            if (reading.distance, reading.angle) == (0, 0):
                break
        end = notebook.seconds
        for seconds, right, left in (*move.segments, Segment(REST, 0, 0)):
            began, end = notebook.seconds, end + seconds
            if move.intervals:  # the first moments of a segment tell most
                notebook.ask(move.intervals)
            while notebook.seconds <= end:
                if move.reads is Reads.OFTEN and notebook.seconds - began > TELLING:
                    notebook.ask_no_more()
                self._driver.drive((right + left) / 2 / MM_PER_M,
                                   (right - left) / MM_PER_M / LIMITS.wheel_separation, self._now)
                yield
        yield from self._read()

    def _read(self) -> Generator[None, None, Increment]:
        """Ask for a reading, and return it."""
        before = self._notebook.reading
        self._notebook.ask()
        while self._notebook.reading is before:
            yield
        return self._notebook.reading

    def _disturbance(self) -> str | None:
        """Say what disturbs the move; None: nothing."""
        health = self._driver.health(self._now)
        readings = health.readings
        if not health.answered:
            return 'the robot does not answer any more'
        if health.hazards:
            return ', '.join(cause.value for cause in health.hazards)
        if not health.mode.can_drive:
            return f'the robot left Safe mode: {health.mode.reason or "no reason"}'
        if readings.has('oi_mode') and bumps(readings):
            return 'the bumper was pressed'
        return None


class RobotLine:
    """A driver with a notebook in place of its odometry."""

    def __init__(self, url: str, baud: int, capture_file: str) -> None:
        """Prepare; OSError: the capture cannot be written."""
        self.notebook = Notebook()
        self.heard = bytearray()
        """What the robot says, to look for a banner."""
        self.lost = threading.Event()
        """Set when the session has ended by itself."""
        self.capture = Capture(
            capture_file, {'driver': f'create_check of create_oi_ros {__version__}', 'port': url},
            lambda why: print(f'create_check: capture: {why}'))
        self.session = Session(
            Driver(Settings(baud=baud, recover_mode=False, gyro=GyroSettings()), self.notebook),
            url,
            on_event=self._on_event, on_failure=self.lost.set, dead_man=True,
            record=self._record)
        self.runner = Runner(self.session.driver, self.notebook)

    def _record(self, kind: RecordKind, content: bytes | str) -> None:
        self.capture.add(kind, content)
        if kind is RecordKind.FROM_ROBOT and isinstance(content, bytes):
            self.heard += content

    def _on_event(self, event: DriverEvent) -> None:
        if isinstance(event, Notice):
            self.capture.add(RecordKind.NOTE, f'{event.severity.name.lower()}: {event.text}')
            answered = bool(self.notebook.seconds)
            if event.severity is not Severity.INFO and answered and not self.runner.busy:
                print(f'  ({event.text})', flush=True)

    @contextmanager
    def open(self) -> Iterator[None]:
        """Talk to the robot; at the end stop it, whatever happened."""
        self.session.start()
        try:
            yield
        finally:
            self.session.close()
            self.capture.close()
            if not self.notebook.seconds:
                self.capture.path.unlink(missing_ok=True)  # nothing of a robot is in it

    def until(self, happened: Callable[[Health], object], seconds: float = inf) -> bool:
        """Wait until something is the case; False: not in time. UserError: the line has failed."""
        end = time.monotonic() + seconds
        while not self.lost.is_set():
            if happened(self.session.health()):
                return True
            if time.monotonic() > end:
                return False
            time.sleep(TURN)
        raise UserError('the line to the robot has failed; see above for why')

    def wait_for_robot(self) -> None:
        """Wait for all that is asked about before the first move; UserError: no robot answers."""
        def heard(health: Health) -> bool:  # on a slow line, not in the first frames
            return health.readings.has('charging_sources', 'charging_state')
        self.until(lambda health: heard(health) or (
            self.session.port is None and health.line_problem), ANSWER)
        if not heard(health := self.session.health()):
            raise UserError(health.line_problem or (
                f'no robot answers at {self.session.url} within {ANSWER:.0f} s: is it switched '
                'on, and the cable in?'))

    def enter(self, mode: oi.Mode) -> Outcome:
        """Ask for a mode; return how that ended."""
        with self.session.request() as (driver, now):
            pending = driver.modes.set(mode, now)
        self.until(lambda _: pending.outcome is not None)
        assert pending.outcome is not None
        return pending.outcome

    def send_raw(self, data: bytes) -> None:
        """Send bytes that no command of the driver's has."""
        with self.session.request():
            port = self.session.port
            if port is not None:
                self.capture.add(RecordKind.TO_ROBOT, data)
                port.write(data)

    def make(self, move: Move) -> bool:
        """Make a move; False: something disturbed it, and the wheels stand."""
        self.runner.begin(move)

        def made(_health: Health) -> bool:
            with self.session.request() as (_driver, now):
                self.runner.poll(now)
            return not self.runner.busy
        self.until(made)
        return self.runner.disturbance is None
