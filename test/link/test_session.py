# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A port that opens, closes or is lost while another thread does something else with it."""

from collections.abc import Callable
import threading
import time

from create_oi_ros import oi
from create_oi_ros.driver import Driver, DriverEvent, LinkCounts, Notice, Settings
from create_oi_ros.driver.listening import QUESTIONS
from create_oi_ros.driver.outbox import farewell
from create_oi_ros.link.port import PortError
from create_oi_ros.link.session import Session
from support.ros import TIMEOUT

FAREWELL = b''.join(command.encode() for command in farewell(None, oi.Mode.FULL))


class ScriptedPort:
    """What a session needs of a port; `read` does what the test says."""

    url, descriptor, baud = 'scripted', None, 57600

    def __init__(self, read: Callable[[], bytes] = lambda: b'') -> None:
        self.read = read
        self.did: list[bytes | str] = []
        """Bytes that were written, and `flush` and `close`."""
        self.failing = False

    def write(self, encoded: bytes) -> None:
        if self.failing:
            raise PortError('writing failed')
        self.did.append(encoded)

    def flush(self) -> None:
        self.did.append('flush')

    def close(self) -> None:
        self.did.append('close')


class Watched(Session):
    """A session that collects what it says, and shows when another thread uses its driver."""

    def __init__(self, open_port: Callable[..., ScriptedPort]) -> None:
        self.texts: list[str] = []
        self.used = threading.Event()
        super().__init__(
            Driver(Settings(mode_on_exit=oi.Mode.FULL)), 'loop://', on_event=self._take,
            on_failure=lambda: self.texts.append('failure'), open_port=open_port, clock=self._time)

    def _take(self, event: DriverEvent) -> None:
        if isinstance(event, Notice):
            self.texts.append(event.text)

    def _time(self) -> float:
        if threading.current_thread().name != 'create_session':
            self.used.set()
        return time.monotonic()


def test_a_session_closed_while_its_port_opens_writes_nothing_to_it():
    port, opening, may_open = ScriptedPort(), threading.Event(), threading.Event()

    def open_port(*_, **__) -> ScriptedPort:
        opening.set()
        assert may_open.wait(TIMEOUT)
        return port
    ours = Watched(open_port)
    ours.start()
    assert opening.wait(TIMEOUT)
    closing = threading.Thread(target=ours.close)
    closing.start()
    assert ours.used.wait(TIMEOUT), 'it closes'
    may_open.set()
    closing.join(TIMEOUT)
    assert not closing.is_alive()
    assert port.did == ['close'] and ours.texts == []


def test_a_port_that_fails_while_the_session_closes_still_gets_the_farewell_last():
    reading = threading.Event()

    def read() -> bytes:
        reading.set()
        assert ours.used.wait(TIMEOUT), 'it closes'
        raise PortError('reading failed')
    port = ScriptedPort(read)
    ours = Watched(lambda *_, **__: port)
    ours.start()
    assert reading.wait(TIMEOUT)
    ours.close()
    assert port.did[-3:] == [FAREWELL, 'flush', 'close'] and port.did.count('close') == 1
    assert 'reading failed' not in ours.texts and 'failure' not in ours.texts


def test_a_port_lost_by_one_thread_is_closed_by_the_one_that_reads_it():
    reading, may_return, opened_again, over = (threading.Event() for _ in range(4))

    def read() -> bytes:
        reading.set()
        assert may_return.wait(TIMEOUT)
        return QUESTIONS[0].pack_frame([1])

    def read_second() -> bytes:
        opened_again.set()
        assert over.wait(TIMEOUT)
        return b''
    first, second = ScriptedPort(read), ScriptedPort(read_second)
    ports = iter([first, second])
    ours = Watched(lambda *_, **__: next(ports))
    ours.start()
    assert reading.wait(TIMEOUT)
    first.failing = True
    with ours.request() as (driver, now):
        driver.stop(now)
    assert 'writing failed' in ours.texts and 'close' not in first.did
    may_return.set()
    assert opened_again.wait(TIMEOUT)
    assert first.did[-1] == 'close'
    over.set()
    ours.close()
    assert ours.driver.counts == LinkCounts(), 'bytes of a lost port are dropped'


def test_the_clock_of_a_session_goes_on_while_the_computer_sleeps(monkeypatch):
    """`time.monotonic` stands still on Linux meanwhile."""
    ours = Session(Driver(), 'loop://', on_event=print, on_failure=print)
    monkeypatch.setattr(time, 'clock_gettime', {time.CLOCK_BOOTTIME: 5e6}.__getitem__)
    with ours.request() as (_, now):
        assert now == 5e6
