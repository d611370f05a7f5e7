# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A port that opens, closes or is lost while another thread does something else with it."""

from collections.abc import Callable
import threading
import time

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver, LinkCounts, Notice, Settings
from create_oi_ros.driver.listening import QUESTIONS
from create_oi_ros.driver.outbox import farewell, HALT
from create_oi_ros.link.port import PortError
from create_oi_ros.link.session import RETRY_FIRST, RETRY_MOST, Session
from create_oi_ros.oi.tools.capture_format import RecordKind
from support.loop import Loop
from support.ros import TIMEOUT

FAREWELL = b''.join(command.encode() for command in farewell(None, oi.Mode.FULL))


class ScriptedPort:
    """What a session needs of a port; `read` does what the test says."""

    def __init__(self, read: Callable[[], bytes] = lambda: b'', baud: int = 57600) -> None:
        self.url, self.descriptor = 'scripted', None
        self.read, self._baud = read, baud
        self.did: list[bytes | int | str] = []
        """Bytes that were written, rates that were set, and `flush` and `close`."""
        self.failing = False

    @property
    def baud(self) -> int:
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self.did.append(baud)
        self._baud = baud

    def write(self, encoded: bytes) -> None:
        if self.failing:
            raise PortError('writing failed')
        self.did.append(encoded)

    def flush(self) -> None:
        self.did.append('flush')

    def close(self) -> None:
        self.did.append('close')


def session_on(
    open_port: Callable[..., ScriptedPort], record: Callable[..., None] | None = None, *,
    clock: Callable[[], float] | None = None, **settings,
) -> tuple[Session, list[str]]:
    """Return a session that is not started, and what it says."""
    texts: list[str] = []

    def on_event(event) -> None:
        if isinstance(event, Notice):
            texts.append(event.text)
    return Session(Driver(Settings(**settings)), 'loop://', on_event=on_event,
                   on_failure=lambda: texts.append('failure'), record=record,
                   open_port=open_port, clock=clock), texts


def test_a_session_closed_while_its_port_opens_writes_nothing_to_it():
    port, opening, may_open = ScriptedPort(), threading.Event(), threading.Event()

    def open_port(*_, **__) -> ScriptedPort:
        opening.set()
        assert may_open.wait(TIMEOUT)
        return port
    ours, texts = session_on(open_port, mode_on_exit=oi.Mode.FULL)
    ours.start()
    assert opening.wait(TIMEOUT)
    closing = threading.Thread(target=ours.close)
    closing.start()
    assert ours._closing.wait(TIMEOUT)
    may_open.set()
    closing.join(TIMEOUT)
    assert not closing.is_alive()
    assert port.did == ['close'] and texts == []


def test_a_port_that_fails_while_the_session_closes_still_gets_the_farewell_last():
    ours: Session
    reading = threading.Event()

    def read() -> bytes:
        reading.set()
        assert ours._closing.wait(TIMEOUT)
        raise PortError('reading failed')
    port = ScriptedPort(read)
    ours, texts = session_on(lambda *_, **__: port, mode_on_exit=oi.Mode.FULL)
    ours.start()
    assert reading.wait(TIMEOUT)
    ours.close()
    assert port.did[-3:] == [FAREWELL, 'flush', 'close'] and port.did.count('close') == 1
    assert 'reading failed' not in texts and 'failure' not in texts


def test_a_port_lost_by_one_thread_is_closed_by_the_one_that_reads_it():
    reading, may_return, opened_again = (threading.Event() for _ in range(3))
    ours: Session

    def read() -> bytes:
        reading.set()
        assert may_return.wait(TIMEOUT)
        return QUESTIONS[0].pack_frame([1])

    def read_second() -> bytes:
        opened_again.set()
        assert ours._closing.wait(TIMEOUT)
        return b''
    first, second = ScriptedPort(read), ScriptedPort(read_second)
    ports = iter([first, second])
    ours, texts = session_on(lambda *_, **__: next(ports))
    ours.start()
    assert reading.wait(TIMEOUT)
    first.failing = True
    with ours.request() as (driver, now):
        driver.stop(now)
    assert 'writing failed' in texts and 'close' not in first.did
    may_return.set()
    assert opened_again.wait(TIMEOUT)
    assert first.did[-1] == 'close'
    ours.close()
    assert ours.driver.counts == LinkCounts(), 'bytes of a lost port are dropped'


def test_a_port_that_opens_and_fails_again_and_again_is_tried_ever_less_often(monkeypatch):
    pauses, enough = [], threading.Event()

    def wait(_, pause: float) -> None:
        pauses.append(pause)
        if len(pauses) == 5:
            enough.set()
            assert ours._closing.wait(TIMEOUT)

    def read() -> bytes:
        raise PortError('reading failed')
    monkeypatch.setattr(Session, '_wait', wait)
    ours, _ = session_on(lambda *_, **__: ScriptedPort(read))
    ours.start()
    assert enough.wait(TIMEOUT)
    ours.close()
    assert pauses == [RETRY_FIRST, 0.2, 0.4, RETRY_MOST, RETRY_MOST]


def test_health_says_what_is_wrong_with_the_port_then_with_the_robot():
    ports = iter([PortError('no such port'), ScriptedPort(), PortError('unplugged')])

    def open_port(*_, **__) -> ScriptedPort:
        port = next(ports)
        if isinstance(port, PortError):
            raise port
        return port
    ours, _ = session_on(open_port)
    assert ours._open() is None and ours.health().line_problem == 'no such port'
    port = ours._open()
    assert ours.health().line_problem is None
    with ours.request() as (driver, now):
        for number in range(4):
            driver.poll(now + number)
    assert ours.health().line_problem.startswith('no answer at 57600 baud: is the robot on')
    port.failing = True
    with ours.request() as (driver, now):
        driver.stop(now)
    assert ours.health().line_problem == 'writing failed'
    assert ours._open() is None and ours.health().line_problem == 'unplugged'


def test_the_rate_changes_when_all_bytes_have_left_also_for_the_farewell():
    port = ScriptedPort()
    ours, _ = session_on(lambda *_, **__: port, baud=0, mode_on_exit=oi.Mode.FULL)
    ours._open()
    assert isinstance(port.did[-1], bytes)
    ours.driver._connection.baud = 19200
    ours.close()
    assert port.did[1:] == ['flush', 19200, FAREWELL, 'flush', 'close']


def test_all_that_passes_is_recorded_in_its_order_and_a_loss_once():
    passed, port = [], ScriptedPort(lambda: b'hello')
    ours, _ = session_on(lambda *_, **__: port, lambda *what: passed.append(what), baud=0)
    ours._open()
    assert passed == [(RecordKind.OPENED, 'loop:// at 57600 baud'),
                      (RecordKind.TO_ROBOT, port.did[0])]
    passed.clear()
    ours._read(port)
    ours.driver._connection.baud = 19200
    for failing in (False, True, True):
        port.failing = failing
        with ours.request() as (driver, now):
            driver.stop(now)
    halt = HALT.encode()
    assert passed == [
        (RecordKind.FROM_ROBOT, b'hello'), (RecordKind.BAUD, '19200'), (RecordKind.TO_ROBOT, halt),
        (RecordKind.TO_ROBOT, halt), (RecordKind.LOST, 'writing failed')]


# A computer that sleeps: the monotonic clock of Linux stands still meanwhile.


class RobotPort(ScriptedPort):
    """A port with a robot whose bytes wait until somebody reads them."""

    def __init__(self, loop: Loop) -> None:
        super().__init__(self.take)
        self.robot, self.loop = loop.robot, loop

    def take(self) -> bytes:
        self.loop.now += 0.005
        self.robot.poll(self.loop.now)
        return self.robot.data_to_send()

    def write(self, encoded: bytes) -> None:
        self.robot.receive(encoded, self.loop.now)


@pytest.mark.parametrize('asleep', [1.3, 20.0, 3600.0])
def test_after_a_sleep_what_came_meanwhile_is_dropped_and_the_robot_called_anew(asleep):
    loop = Loop()
    port = RobotPort(loop)
    ours, texts = session_on(lambda *_, **__: port, clock=lambda: loop.now)
    ours._open()
    for _ in range(400):
        ours._read(port)
    ours.drive(0.2, 0.3)
    for _ in range(40):
        ours._read(port)
    texts.clear()
    frames = ours.driver.counts.frames
    loop.now += asleep
    for _ in range(10):
        ours._read(port)
    assert ours.driver.counts.frames < frames + 3, 'old frames count as new ones'
    for _ in range(200):
        ours._read(port)
    assert texts[0].startswith(f'the driver stood still for {asleep:.1f} s (Ctrl-Z, a debugger, ')
    assert texts[0].endswith('calling the robot again')
    assert ours.driver.state.answered and ours.driver.counts.impossible_jumps == 0
    assert loop.robot.actuators.wheels == (0, 0)


def test_a_velocity_is_not_followed_before_a_sleep_is_noticed():
    loop = Loop()
    port = RobotPort(loop)
    ours, _ = session_on(lambda *_, **__: port, clock=lambda: loop.now)
    ours._open()
    for _ in range(200):
        ours._read(port)
    loop.now += 20.0
    ours.drive(0.3, 0.0)
    assert loop.robot.actuators.wheels == (0, 0) and not ours.driver.state.answered


def test_the_clock_of_a_session_goes_on_while_the_computer_sleeps(monkeypatch):
    ours = Session(Driver(), 'loop://', on_event=print, on_failure=print)
    monkeypatch.setattr(time, 'clock_gettime', {time.CLOCK_BOOTTIME: 5e6}.__getitem__)
    with ours.request() as (_, now):
        assert now == 5e6
