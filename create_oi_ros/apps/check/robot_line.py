# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot of a check at its port, in real time, with a capture of it all."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
import threading
import time

from ... import __version__, oi
from ...driver import Driver, DriverEvent, Health, Notice, Outcome, Settings, Severity
from ...link.capture import Capture
from ...link.session import Session
from ...odometry import GyroSettings
from ...oi.tools.capture_format import RecordKind
from ...ros.programs import UserError
from .moves import Move
from .runner import Notebook, Runner

TURN = 0.02
"""Seconds between two looks."""
ANSWER = 15.0
"""Seconds within which a robot must answer."""


class RobotLine:
    """A driver with a notebook in place of its odometry."""

    def __init__(self, url: str, baud: int, capture_file: str) -> None:
        """Prepare; OSError: the capture cannot be written."""
        self.notebook = Notebook()
        self.heard = bytearray()
        """What the robot says, to look for a banner."""
        self._answered = False
        """Whether a robot has ever answered."""
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
            if event.severity is not Severity.INFO and self._answered and not self.runner.busy:
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
            if not self._answered:
                self.capture.path.unlink(missing_ok=True)  # nothing of a robot is in it

    def health(self) -> Health:
        """Return what is known now."""
        return self.session.health()

    def until(self, happened: Callable[[Health], bool], seconds: float = inf) -> bool:
        """Wait until something is the case; False: not in time. UserError: the line has failed."""
        end = time.monotonic() + seconds
        while not self.lost.is_set():
            if happened(self.health()):
                return True
            if time.monotonic() > end:
                return False
            time.sleep(TURN)
        raise UserError('the line to the robot has failed; see above for why')

    def wait_for_robot(self) -> None:
        """Wait until the robot answers; UserError: it does not."""
        def settled(health: Health) -> bool:
            self._answered = health.answered and bool(self.notebook.seconds)
            return self._answered or self.session.port is None and bool(health.line_problem)
        self.until(settled, ANSWER)
        if not self._answered:
            raise UserError(self.health().line_problem or (
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
        with self.session.request() as (_driver, _now):
            self.runner.begin(move)

        def made(_health: Health) -> bool:
            with self.session.request() as (_driver, now):
                self.runner.poll(now)
            return not self.runner.busy
        self.until(made)
        return self.runner.disturbance is None
