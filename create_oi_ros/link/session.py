# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A driver, a port and the thread that connects them; no ROS.

One thread reads, blocking, so that a frame is taken in as soon as it arrives; it also opens the
port again when it was lost. Requests come from other threads through `request`. A lock gives the
driver to one thread at a time and keeps the bytes in the order of the decisions. Once `close` has
begun, nothing but the driver's farewell is written.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import inf
import os
import threading
import time

from ..driver import DEAD_MAN_STOP, Driver, DriverEvent, Health, Notice, Severity
from ..oi.tools.capture_format import RecordKind
from .dead_man import DeadMan
from .port import lasting_name, Port, PortError

READ_TIMEOUT = 0.02
"""Longest wait of a read, in seconds; the driver's timers may be late by as much."""
RETRY_INTERVAL = 0.5
"""Seconds between attempts to open the port."""
NAMES_SETTLED = 1.0
"""Seconds after plugging in when a device has all its names."""
LEAST_LIFE = 1.0
"""Seconds that a dead-man must have run to be started again."""
UNGUARDED = 'if this process dies, the robot drives on'
CLOCK = getattr(time, 'CLOCK_BOOTTIME', time.CLOCK_MONOTONIC)
"""The driver's clock: `time.monotonic` stands still on Linux while the computer sleeps."""


class Session:
    """Keeps a driver connected until it is closed."""

    def __init__(
        self, driver: Driver, url: str, *, on_event: Callable[[DriverEvent], None],
        on_failure: Callable[[], None], dead_man: bool = False,
        record: Callable[[RecordKind, bytes | str], None] | None = None,
        open_port: Callable[..., Port] = Port,
        clock: Callable[[], float] | None = None,
    ) -> None:
        """
        Prepare a session; `start` begins it.

        `on_event` is called by whichever thread uses the driver. `on_failure` is called after an
        error, once the robot was stopped: `close` the session then. The error itself is raised
        in the thread that used the driver; in the session's own, its traceback is printed.
        With `dead_man`, a process of its own stops the robot when this one dies. `record` is
        called with all that passes, as `Capture.add`. `open_port` takes what `Port` takes.
        `clock` returns seconds; by default that of `CLOCK` does.
        """
        self.driver = driver
        self.url = url
        self._on_event = on_event
        self._on_failure = on_failure
        self._wants_dead_man = dead_man
        self._record = record or (lambda kind, content: None)
        self._open_port = open_port
        self._clock = clock or (lambda: time.clock_gettime(CLOCK))
        self._lock = threading.RLock()
        self.port: Port | None = None
        """The open port; None while there is none. Use it only within a `request`."""
        self._dead_man: DeadMan | None = None
        self._dead_man_started_at = 0.0
        self._lasting_name: str | None = None
        self._named_at = inf
        """When to look up the lasting name of the open port."""
        self._closing = threading.Event()
        self._stopped = False
        """Whether the driver's last commands were made and written without an error."""
        self._reported: str | None = None
        """What was last reported about the port; None while it is open."""
        self._thread = threading.Thread(target=self._run, name='create_session')

    def start(self) -> None:
        """Start the thread that opens the port and reads it."""
        self._thread.start()

    @contextmanager
    def _use_driver(self) -> Iterator[float]:
        """Keep the driver to this thread, and give the time; an error ends the session."""
        with self._lock:
            try:
                yield self._clock()
            except Exception as error:
                try:
                    self._fail()
                finally:
                    raise error from None  # what fails because of it is not reported

    @contextmanager
    def request(self) -> Iterator[tuple[Driver, float]]:
        """Lend the driver, with the time; what it decides to send is written."""
        with self._use_driver() as now:
            yield self.driver, now
            self._send()  # first: a command must not wait for the rest
            self._exchange(now)

    def _fail(self) -> None:
        """Stop the robot for good, after an error."""
        self._closing.set()
        try:
            self._stop_robot()
        finally:
            self._on_failure()

    def drive(self, linear: float, angular: float) -> None:
        """Follow a velocity, m/s and rad/s; it is written at once."""
        with self.request() as (driver, now):
            driver.drive(linear, angular, now)

    def health(self) -> Health:
        """Return what is known of driver, line and robot; nothing is sent."""
        with self._use_driver() as now:
            health = self.driver.health(now)
            return replace(health, line_problem=self._reported or health.line_problem)

    def close(self) -> None:
        """Stop the robot, leave it in the mode for exit, and close the port."""
        failed = self._closing.is_set()
        self._closing.set()
        try:
            with self._lock:
                if not failed:  # else it was stopped, and whoever listens may be what failed
                    self._stop_robot()
                    self._report_events()
        finally:
            if self._thread.is_alive():
                self._thread.join()
            port = self.port
            self._leave_port(stopped=self._stopped)
            if port is not None:
                port.close()

    def _stop_robot(self) -> None:
        """Write the driver's last commands, whatever fails; the dead-man's where they fail."""
        try:
            self.driver.shut_down(self._clock())
        finally:
            farewell = self.driver.data_to_send()
            if self.port is not None and farewell:
                try:
                    self._write(self.port, farewell)
                    self.port.flush()
                except PortError as error:
                    self._leave_port(stopped=False)
                    self._record(RecordKind.LOST, str(error))
                    self._report(error)
        self._stopped = True

    def _run(self) -> None:
        try:
            while not self._closing.is_set():
                port = self._open()
                while port is not None and self.port is port and not self._closing.is_set():
                    self._read(port)
                if port is not None and self.port is not port:
                    port.close()  # lost; only here, since this thread may just be reading it
                self._closing.wait(RETRY_INTERVAL)
        finally:
            if not self._closing.is_set():
                self._on_failure()

    def _open(self) -> Port | None:
        lasting = self._lasting_name
        url = lasting if lasting is not None and os.path.exists(lasting) else self.url
        try:
            port = self._open_port(url, self.driver.baud, timeout=READ_TIMEOUT)
        except PortError as error:
            self._report(error)
            return None
        self._record(RecordKind.OPENED, f'{url} at {port.baud} baud')
        with self._use_driver() as now:
            if self._closing.is_set():
                port.close()
                return None
            self._reported = None
            self.port = port
            self._on_event(Notice(Severity.INFO, f'{url} opened, calling the robot'))
            self._start_dead_man(port)
            self._named_at = now + NAMES_SETTLED
            self.driver.connected(now)
            self._exchange(now)
        return port

    def _start_dead_man(self, port: Port) -> None:
        if not self._wants_dead_man:
            return
        if port.descriptor is None:
            self._on_event(Notice(
                Severity.WARNING, f'{port.url}: no dead-man for this kind of port; {UNGUARDED}'))
            return
        self._dead_man_started_at = self._clock()
        try:
            self._dead_man = DeadMan(port.descriptor, DEAD_MAN_STOP)
        except OSError as error:
            self._on_event(Notice(
                Severity.ERROR, f'the dead-man could not be started ({error}); {UNGUARDED}'))

    def _check_dead_man(self, port: Port, now: float) -> None:
        """Start another dead-man where the first was killed, unless it ended at once."""
        if self._dead_man is None or not self._dead_man.ended:
            return
        self._dead_man.release()
        self._dead_man = None
        then = UNGUARDED
        if now - self._dead_man_started_at > LEAST_LIFE:
            self._start_dead_man(port)
            then = 'another one has been started'
        self._on_event(Notice(Severity.ERROR, f'the dead-man has ended; {then}'))

    def _read(self, port: Port) -> None:
        received: bytes | PortError
        try:
            received = port.read()
            if received:
                self._record(RecordKind.FROM_ROBOT, received)
        except PortError as error:
            received = error
        with self._use_driver() as now:
            # Another thread may have lost it meanwhile, while writing.
            if self._closing.is_set() or self.port is not port:
                return
            if isinstance(received, PortError):
                self._lose(received)
                return
            if received:
                self.driver.receive(received, now)
                self._report_events()  # first: a bump must not wait
            self._exchange(now)
            self._check_dead_man(port, now)
            if now > self._named_at:
                self._lasting_name = lasting_name(port.url) or self._lasting_name
                self._named_at = inf

    def _exchange(self, now: float) -> None:
        """Let the driver act, send its bytes, and report its events."""
        self.driver.poll(now)
        self._send()
        self._report_events()

    def _send(self) -> None:
        outgoing = self.driver.data_to_send()
        if not outgoing or self.port is None:
            return
        try:
            self._write(self.port, outgoing)
        except PortError as error:
            self._lose(error)

    def _write(self, port: Port, outgoing: bytes) -> None:
        baud = self.driver.baud  # it changes only with what is sent at the new rate
        if baud != port.baud:
            port.flush()
            port.baud = baud
            self._record(RecordKind.BAUD, str(baud))
        self._record(RecordKind.TO_ROBOT, outgoing)  # before: an answer must never come first
        port.write(outgoing)

    def _report_events(self) -> None:
        while (event := self.driver.next_event()) is not None:
            self._on_event(event)

    def _lose(self, error: PortError) -> None:
        self._leave_port(stopped=False)
        self._record(RecordKind.LOST, str(error))
        self.driver.disconnected(str(error))
        self._report(error)
        self._report_events()  # the thread that reads has no other reason to, without a port

    def _leave_port(self, *, stopped: bool) -> None:
        """Use the port no more; a robot that may not have been stopped is left to the dead-man."""
        # The dead-man holds the line open too, and would keep it from being opened again.
        if self._dead_man is not None:
            if stopped:
                self._dead_man.release()
            else:
                self._dead_man.trigger()
            self._dead_man = None
        self.port = None

    def _report(self, error: PortError) -> None:
        """Report what is wrong with the port, once until it changes; skip what may go away."""
        if not error.temporary and str(error) != self._reported:
            self._reported = str(error)
            self._on_event(Notice(Severity.ERROR, str(error)))
