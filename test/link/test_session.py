# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A session whose port is lost meanwhile, or whose driver raises: the robot stops all the same."""

from collections.abc import Callable
from contextlib import suppress
import inspect
import threading
import time

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver, DriverEvent, LinkCounts, MotionLimits, Notice, Settings
from create_oi_ros.driver.battery import Battery
from create_oi_ros.driver.connection import Connection
from create_oi_ros.driver.core import Core
from create_oi_ros.driver.goal_control import GoalControl
from create_oi_ros.driver.goals import DriveDistance
from create_oi_ros.driver.listening import Listening, QUESTIONS
from create_oi_ros.driver.mode import Modes
from create_oi_ros.driver.motion import Motion
from create_oi_ros.driver.outbox import farewell, HALT
from create_oi_ros.driver.outputs import Outputs
from create_oi_ros.driver.script import ScriptControl
from create_oi_ros.driver.songs import Songs
from create_oi_ros.driver.stream import StreamPlan
from create_oi_ros.driver.tracking import Tracking
from create_oi_ros.link.port import PortError
from create_oi_ros.link.session import Session
from create_oi_ros.oi.tools.text import parse_script
from support.loop import Loop, STEP
from support.ros import TIMEOUT

# A port that opens, closes or is lost while another thread does something else with it.


ENDING = b''.join(command.encode() for command in farewell(None, oi.Mode.FULL))


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
    assert port.did[-3:] == [ENDING, 'flush', 'close'] and port.did.count('close') == 1
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


# Whatever part of the driver raises: the robot stops, the error comes once, the session ends.


SETTINGS = Settings(limits=MotionLimits(timeout=1000.0))
FAREWELL = b''.join(command.encode() for command in farewell(oi.Mode.SAFE, oi.Mode.PASSIVE))
PARTS = (Battery, Connection, Core, GoalControl, Listening, Modes, Motion, Outputs, ScriptControl,
         Songs, StreamPlan, Tracking)
"""Parts of the driver that can fail. Where the outbox does, the dead-man acts."""


class Broken(RuntimeError):
    """What a part raises."""


def fail(*_args, **_options):
    raise Broken


def break_part(monkeypatch, part: type) -> None:
    """Let every method of a part that others call raise from now on."""
    for name, _ in inspect.getmembers(part, inspect.isfunction):
        if not name.startswith('_'):
            monkeypatch.setattr(part, name, fail)


each_part = pytest.mark.parametrize('part', PARTS, ids=lambda part: part.__name__)


@each_part
@pytest.mark.parametrize(('goal', 'end'), [(False, Driver.stop), (True, Driver.shut_down)])
def test_a_stop_is_queued_before_anything_that_can_fail(part, goal, end, monkeypatch):
    loop = Loop(SETTINGS)
    loop.run(0.5)
    if goal:
        loop.driver.goals.start(DriveDistance(2.0, 0.2, 0.0), loop.now)
    else:
        loop.driver.drive(0.2, 0.0, loop.now)
    loop.run(0.5)
    assert loop.driver.state.moving
    break_part(monkeypatch, part)
    with suppress(Broken):
        end(loop.driver, loop.now)
    assert loop.driver.data_to_send().startswith(HALT.encode())


class LoopPort:
    """A port with a robot in memory; time passes while it is read."""

    descriptor = None
    url = 'memory'
    baud = Settings().baud

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.heard = bytearray()
        self.asleep = 0.0
        """Seconds that the computer sleeps before the next read."""
        self.until, self.reached = 0.0, threading.Event()

    def run(self, seconds: float) -> None:
        """Wait until the robot's time has passed."""
        self.reached.clear()
        self.until = self.loop.now + seconds
        assert self.reached.wait(TIMEOUT)

    def read(self) -> bytes:
        """Let a step of time pass, unless it is time to wait; return what the robot says."""
        if self.loop.now > self.until:
            self.reached.set()
            time.sleep(1e-3)
            return b''
        self.loop.now += STEP + self.asleep
        self.asleep = 0.0
        self.loop.robot.poll(self.loop.now)
        return self.loop.robot.data_to_send()

    def write(self, data: bytes) -> None:
        """Let the robot hear."""
        self.heard += data
        self.loop.robot.receive(data, self.loop.now)

    def flush(self) -> None:
        """Do nothing: all has been written."""

    close = flush


class Ride:
    """A session whose robot drives, and all that failed."""

    def __init__(self, monkeypatch) -> None:
        self.port = LoopPort(Loop(SETTINGS))
        self.failures = 0
        self.errors: list[type] = []
        monkeypatch.setattr(
            threading, 'excepthook', lambda about: self.errors.append(about.exc_type))
        self.on_event = lambda event: None
        self.session = Session(
            Driver(SETTINGS), '/dev/null', on_event=lambda event: self.on_event(event),
            on_failure=self.failed, open_port=lambda *_, **__: self.port,
            clock=lambda: self.port.loop.now)
        self.session.start()
        self.port.run(1.0)
        self.session.drive(0.2, 0.0)
        self.port.run(0.5)
        assert any(self.wheels)

    @property
    def wheels(self) -> tuple[int, int]:
        """Speeds that the robot was told."""
        return self.port.loop.robot.actuators.wheels

    def failed(self) -> None:
        """Note that the session cannot go on; nothing else will let time pass."""
        assert self.wheels == (0, 0), 'it stops before anything else is told'
        self.failures += 1
        self.port.reached.set()

    def use(self, what) -> None:
        """Use the session as a thread of the node does."""
        try:
            what(self.session)
        except Broken as error:
            self.errors.append(type(error))


def stop(ours: Session) -> None:
    """Call the driver's stop as the service does."""
    with ours.request() as (driver, now):
        driver.stop(now)


@each_part
def test_a_robot_stands_after_any_part_has_raised_and_the_error_comes_once(part, monkeypatch):
    ride = Ride(monkeypatch)
    break_part(monkeypatch, part)
    ride.port.run(6.0)
    ride.use(Session.close)
    assert ride.wheels == (0, 0) and ride.port.heard.endswith(FAREWELL)
    assert ride.errors in ([Broken], []) and ride.failures <= len(ride.errors)


@pytest.mark.parametrize('use', [
    lambda ours: ours.drive(0.1, 0.0), stop, Session.health],
    ids=['drive', 'request', 'health'])
def test_an_error_in_another_thread_stops_the_robot_and_ends_the_session(use, monkeypatch):
    ride = Ride(monkeypatch)
    for method in ('drive', 'stop', 'health'):
        monkeypatch.setattr(Driver, method, fail)
    ride.use(use)
    ride.use(Session.close)
    assert ride.wheels == (0, 0) and ride.port.heard.endswith(FAREWELL)
    assert ride.errors[:1] == [Broken] and ride.failures >= 1


def test_a_publisher_that_raises_stops_the_robot_and_ends_the_session(monkeypatch):
    ride = Ride(monkeypatch)
    ride.on_event = fail
    ride.port.run(1.0)
    ride.use(Session.close)
    assert ride.wheels == (0, 0) and ride.port.heard.endswith(FAREWELL)
    assert (ride.errors, ride.failures) == ([Broken], 1)


def test_a_session_that_is_closed_tells_what_the_driver_says_last(monkeypatch):
    ride, told = Ride(monkeypatch), []
    ride.on_event = told.append
    with ride.session.request() as (driver, now):
        driver.stop(now)
        driver.scripts.define(parse_script('Wait Time time=100'))
        assert driver.scripts.play(now, force=False).outcome is None
    ride.port.run(0.5)
    ride.session.close()
    texts = [event.text for event in told if isinstance(event, Notice)]
    assert texts[-1].startswith('the driver ends, but a script plays')


@pytest.mark.parametrize('asleep', [1.3, 20.0])
def test_after_a_sleep_of_the_computer_the_robot_stands_and_is_called_anew(monkeypatch, asleep):
    ride, told = Ride(monkeypatch), []
    ride.on_event = told.append
    ride.port.asleep = asleep
    for seconds in (0.1, 2.0):  # until it has slept, and after it
        ride.port.run(seconds)
    assert ride.wheels == (0, 0)
    ride.session.close()
    texts = [event.text for event in told if isinstance(event, Notice)]
    assert texts[0].startswith(f'the driver stood still for {asleep:.1f} s (Ctrl-Z, a debugger, ')
    assert texts[0].endswith('calling the robot again')
    assert ride.session.driver.counts.impossible_jumps == 0
