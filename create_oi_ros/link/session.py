"""
A driver, a port and the thread that connects them; no ROS.

One thread reads, blocking, so that a frame is taken in the moment it is there; it also opens the
port again when it was lost. Requests come from other threads through `request`. A lock keeps the
driver to one of them at a time, and bytes in the order in which they were decided on.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
import threading
import time

from ..driver import Driver, DriverEvent, LAST_WORDS, Notice, Severity
from .dead_man import DeadMan
from .port import exists, lasting_name, Port, PortError

READ_TIMEOUT = 0.02
"""Seconds that a read waits at most: how late the driver's own timers may be."""
RETRY_FIRST, RETRY_MOST = 0.1, 0.8
"""Seconds between attempts to open the port: doubling from the first to the second."""
NAMED_AFTER = 1.0
"""Seconds after which a device that was plugged in has all its names."""
LOOK_EVERY = 0.1
"""Seconds between two looks whether the dead-man still watches."""
LEAST_WATCH = 1.0
"""Seconds that a dead-man must have lasted for another one to be posted in its place."""


class Session:
    """Keeps a driver connected until it is closed."""

    def __init__(
        self, driver: Driver, url: str, *, on_event: Callable[[DriverEvent], None],
        on_failure: Callable[[], None], dead_man: bool = False,
        open_port: Callable[..., Port] = Port,
    ) -> None:
        """
        Prepare.

        `on_event` is called by whichever thread is at the driver, `on_failure` when the
        session's own thread ends unasked, with its traceback printed: then `close` at once.
        With `dead_man`, a process of its own stops the robot when this one dies. `open_port`
        takes what `Port` takes.
        """
        self.driver = driver
        self.url = url
        self._on_event = on_event
        self._on_failure = on_failure
        self._wants_dead_man = dead_man
        self._open_port = open_port
        self._lock = threading.RLock()
        self._port: Port | None = None
        self._dead_man: DeadMan | None = None
        self._posted_at = 0.0
        self._look_at = 0.0
        self._lasting_name: str | None = None
        self._named_at = inf
        """When to ask for the lasting name of the port that was opened last."""
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
            self._send()  # first: a command should not wait for what else there is to do
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
        if self._thread.is_alive():
            self._thread.join()
        self._close_port()

    def _run(self) -> None:
        pause = RETRY_FIRST
        try:
            while not self._closing.is_set():
                if self._port is not None:
                    self._read(self._port)
                elif self._open():
                    pause = RETRY_FIRST
                else:
                    self._wait(pause)
                    pause = min(pause * 2, RETRY_MOST)
        finally:
            if not self._closing.is_set():
                self._on_failure()

    def _wait(self, pause: float) -> None:
        """Wait before the next attempt, but not when a device that was missing appears."""
        missing = not self._device_exists()
        until = time.monotonic() + pause
        while time.monotonic() < until and not self._closing.wait(min(pause, RETRY_FIRST)):
            if missing and self._device_exists():
                return

    def _device_exists(self) -> bool:
        return exists(self.url) or self._lasting_name is not None and exists(self._lasting_name)

    def _open(self) -> bool:
        url = self.url
        if not exists(url) and self._lasting_name is not None and exists(self._lasting_name):
            url = self._lasting_name
        try:
            port = self._open_port(url, self.driver.baud, timeout=READ_TIMEOUT)
        except PortError as error:
            self._complain(error)
            return False
        with self._lock:
            self._complaint = ''
            self._port = port
            self._on_event(Notice(Severity.INFO, f'{url} opened, calling the robot'))
            self._post_dead_man(port)
            now = time.monotonic()
            self._named_at = now + NAMED_AFTER
            self.driver.connected(now)
            self._exchange(now)
        return True

    def _post_dead_man(self, port: Port) -> None:
        if not self._wants_dead_man:
            return
        line = port.descriptor
        if line is None:
            self._on_event(Notice(
                Severity.WARNING, f'{port.url}: no dead-man for this kind of port; if this '
                'process dies, the robot drives on'))
            return
        self._posted_at = time.monotonic()
        try:
            self._dead_man = DeadMan(line, LAST_WORDS)
        except OSError as error:
            self._on_event(Notice(
                Severity.ERROR, f'the dead-man could not be started ({error}); if this process '
                'dies, the robot drives on'))

    def _mind_dead_man(self, port: Port, now: float) -> None:
        """Post another one where the first was ended, unless that happens at once again."""
        if self._dead_man is None or not self._dead_man.ended:
            return
        self._dead_man.release()
        self._dead_man = None
        then = 'if this process dies, the robot drives on'
        if now - self._posted_at > LEAST_WATCH:
            self._post_dead_man(port)
            then = 'another one watches now'
        self._on_event(Notice(Severity.ERROR, f'the dead-man was ended by somebody; {then}'))

    def _read(self, port: Port) -> None:
        try:
            received = port.read()
        except PortError as error:
            with self._lock:
                # Another thread may have lost it already, in writing.
                if self._port is port:
                    self._lose(error)
            return
        with self._lock:
            if self._closing.is_set():
                return
            now = time.monotonic()
            if received:
                self.driver.receive(received, now)
                self._pass_on()  # first: news are awaited, and nothing to send is that urgent
            self._exchange(now)
            if now > self._look_at:
                self._look_at = now + LOOK_EVERY
                self._mind_dead_man(port, now)
            if now > self._named_at:
                self._lasting_name = lasting_name(port.url) or self._lasting_name
                self._named_at = inf

    def _exchange(self, now: float) -> None:
        """Let the driver act and send, and pass on what has happened."""
        self.driver.poll(now)
        self._send()
        self._pass_on()

    def _send(self) -> None:
        outgoing = self.driver.data_to_send()
        if self._port is None:
            return
        try:
            if self._port.baud != self.driver.baud:
                self._port.baud = self.driver.baud
            if outgoing:
                self._port.write(outgoing)
        except PortError as error:
            self._lose(error)

    def _pass_on(self) -> None:
        while (event := self.driver.next_event()) is not None:
            self._on_event(event)

    def _lose(self, error: PortError) -> None:
        self._close_port()
        self.driver.disconnected(str(error))
        self._complain(error)

    def _close_port(self) -> None:
        # The dead-man holds the line as well, and would keep it from being opened again.
        if self._dead_man is not None:
            self._dead_man.release()
            self._dead_man = None
        if self._port is not None:
            self._port.close()
            self._port = None

    def _complain(self, error: PortError) -> None:
        """Say what is wrong with the port, once until it changes; not what may pass at once."""
        if not error.passing and str(error) != self._complaint:
            self._complaint = str(error)
            self._on_event(Notice(Severity.ERROR, str(error)))
