"""
A driver, a port and the thread that connects them; no ROS.

One thread reads, blocking, so that a frame is taken in the moment it is there; it also opens the
port again when it was lost. Requests come from other threads through `request`. A lock keeps the
driver to one of them at a time, and bytes in the order in which they were decided on.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import threading
import time

from .driver import Driver, DriverEvent, Notice, Severity
from .port import Port, PortError

READ_TIMEOUT = 0.02
"""Seconds that a read waits at most: how late the driver's own timers may be."""
RETRY_FIRST, RETRY_MOST = 0.1, 2.0
"""Seconds between attempts to open the port: doubling from the first to the second."""


class Session:
    """Keeps a driver connected until it is closed."""

    def __init__(
        self, driver: Driver, url: str, *, on_event: Callable[[DriverEvent], None],
        on_failure: Callable[[], None],
    ) -> None:
        """
        Prepare.

        `on_event` is called by whichever thread is at the driver, `on_failure` when the
        session's own thread ends unasked, with its traceback printed: then `close` at once.
        """
        self.driver = driver
        self.url = url
        self._on_event = on_event
        self._on_failure = on_failure
        self._lock = threading.RLock()
        self._port: Port | None = None
        self._closing = threading.Event()
        self._complaint = ''
        self._thread = threading.Thread(target=self._run, name='create_session')

    def start(self) -> None:
        """Begin to open the port and to talk."""
        self._thread.start()

    @contextmanager
    def request(self) -> Iterator[tuple[Driver, float]]:
        """Give the driver and the time to one who wants something; what it sends is written."""
        with self._lock:
            now = time.monotonic()
            yield self.driver, now
            self._exchange(now)

    def close(self) -> None:
        """Say goodbye to the robot and close the port."""
        self._closing.set()
        with self._lock:
            self.driver.shut_down(time.monotonic())
            farewell = self.driver.data_to_send()
            if self._port is not None and farewell:
                try:
                    self._port.write(farewell)
                    self._port.flush()
                except PortError as error:
                    self._complain(error)
        self._thread.join()
        if self._port is not None:
            self._port.close()

    def _run(self) -> None:
        pause = RETRY_FIRST
        try:
            while not self._closing.is_set():
                if self._port is None:
                    pause = RETRY_FIRST if self._open() else self._wait(pause)
                else:
                    self._read(self._port)
        finally:
            if not self._closing.is_set():
                self._on_failure()

    def _wait(self, pause: float) -> float:
        self._closing.wait(pause)
        return min(pause * 2, RETRY_MOST)

    def _open(self) -> bool:
        try:
            port = Port(self.url, self.driver.settings.baud, timeout=READ_TIMEOUT)
        except PortError as error:
            self._complain(error)
            return False
        with self._lock:
            self._complaint = ''
            self._port = port
            self._on_event(Notice(Severity.INFO, f'{self.url} opened, calling the robot'))
            now = time.monotonic()
            self.driver.connected(now)
            self._exchange(now)
        return True

    def _read(self, port: Port) -> None:
        try:
            received = port.read()
        except PortError as error:
            with self._lock:
                self._lose(error)
            return
        with self._lock:
            if self._closing.is_set():
                return
            now = time.monotonic()
            if received:
                self.driver.receive(received, now)
            self._exchange(now)

    def _exchange(self, now: float) -> None:
        """Let the driver send, and pass on what has happened."""
        self.driver.poll(now)
        outgoing = self.driver.data_to_send()
        if outgoing and self._port is not None:
            try:
                self._port.write(outgoing)
            except PortError as error:
                self._lose(error)
        while (event := self.driver.next_event()) is not None:
            self._on_event(event)

    def _lose(self, error: PortError) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None
        self.driver.disconnected(str(error))
        self._complain(error)

    def _complain(self, error: PortError) -> None:
        """Say what is wrong with the port, once until it changes."""
        if str(error) != self._complaint:
            self._complaint = str(error)
            self._on_event(Notice(Severity.ERROR, str(error)))
