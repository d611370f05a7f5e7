# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Ports that cannot be had, in words; a device that comes back under another name."""

from contextlib import closing, contextmanager
import errno
import os
from pathlib import Path
from select import select
import signal
import socket
import subprocess
import threading
from types import SimpleNamespace
from unittest.mock import Mock

import pytest
import serial
from serial.rfc2217 import PortManager
import serial.tools.list_ports

from create_oi_ros.driver import Driver, Moved, Notice, Settings
from create_oi_ros.link import port, session
from create_oi_ros.link.port import holder, lasting_name, Port, PortError
from create_oi_ros.link.session import Session
from create_oi_ros.oi import Mode
from create_oi_ros.oi.codes import FAST_BAUD, FAST_SPACING
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.world import shipped
from support.processes import dead_man, dead_men
from support.ros import Robot, TIMEOUT
from support.simulator import receive


@pytest.fixture
def terminal():
    """Return the name of a terminal that somebody has open."""
    ends = os.openpty()
    yield os.ttyname(ends[1])
    for end in ends:
        os.close(end)


def refused(url: str) -> str:
    """Open a port that cannot be had; return what is said."""
    with pytest.raises(PortError) as error:
        Port(url, 57600, timeout=0.01)
    return str(error.value)


def test_a_missing_port_names_those_there_are(tmp_path, monkeypatch):
    missing = str(tmp_path / 'none')
    monkeypatch.setattr(port, 'CANDIDATES', (str(tmp_path / 'tty*'),))
    assert 'no serial port was found at all' in refused(missing)
    (tmp_path / 'ttyUSB7').touch()
    assert f'there are {tmp_path}/ttyUSB7' in refused(missing)


def test_without_permission_the_command_that_gives_it_is_named(tmp_path, monkeypatch):
    """A device that has just come may get its permissions yet."""
    device = tmp_path / 'ttyUSB0'
    device.touch()
    come = device.stat().st_ctime
    monkeypatch.setenv('USER', 'ada')
    monkeypatch.setattr(serial.Serial, 'open', Mock(side_effect=OSError(errno.EACCES, 'no')))
    for age, temporary in ((0.1, True), (2.0, False), (-5.0, False)):
        monkeypatch.setattr(port, 'time', SimpleNamespace(time=lambda now=come + age: now))
        with pytest.raises(PortError, match='sudo usermod -aG dialout ada') as error:
            Port(str(device), 57600, timeout=0.01)
        assert error.value.temporary is temporary


@pytest.mark.parametrize('operation', [
    Port.flush, Port.read, lambda port: port.write(b'\x80'),
    lambda port: setattr(port, 'baud', 19200)])
def test_a_terminal_that_has_gone_is_a_port_error_whatever_is_tried(operation):
    robot, host = os.openpty()
    opened = Port(os.ttyname(host), 57600, timeout=0.01)
    os.close(host)
    os.close(robot)
    with pytest.raises(PortError, match='failed .*; is the cable in|cannot be set'):
        operation(opened)
    opened.close()
    opened.close()


@pytest.mark.parametrize(('url', 'said'), [
    ('socket://127.0.0.1', 'give a device such as /dev/ttyUSB0 or a URL such as socket://HOST'),
    ('socket://127.0.0.1:99999', 'Port out of range 0-65535'),
    ('rfc2217://127.0.0.1:1', 'Connection refused; are host and port right'),
    ('rfc2217://127.0.0.1:1?timeout=x', "could not convert string to float: 'x'"),
    ('loop://?logging=x', "KeyError: 'x'"),
    ('spy:///nowhere', "No such file or directory: '/nowhere'"),
    ('alt:///nowhere?class=os', 'TypeError'),
    ('hwgrep://(', 'missing )'),
    ('nonsense://x', "protocol 'nonsense' not known"),
    ('x' * 300, 'File name too long'),
    ('\0', 'embedded null byte'),
])
def test_a_url_that_leads_nowhere_gets_a_sentence(url, said):
    sentence = refused(url)
    assert sentence.startswith(url) and said in sentence


def test_an_error_that_may_go_away_is_not_reported(tmp_path):
    (tmp_path / 'tty').touch()
    errors = iter([PortError('no permission', temporary=True), PortError('in use')])
    heard = Heard()

    def refuse(*_, **__):
        raise next(errors, PortError('in use'))
    ours = Session(Driver(), str(tmp_path / 'tty'), on_event=heard, on_failure=lambda: None,
                   open_port=refuse)
    ours.start()
    try:
        heard.wait_for('in use')
    finally:
        ours.close()
    assert heard.texts == ['in use']


def test_a_port_is_ours_alone_and_the_other_is_told_by_whom(terminal):
    ours = Port(terminal, 57600, timeout=0.01)
    assert 'is in use by' in refused(terminal)
    ours.close()
    Port(terminal, 57600, timeout=0.01).close()


def received(opened: Port, count: int) -> bytes:
    """Read this many bytes: a read returns what has come, which may be a part."""
    data = b''
    while len(data) < count:
        data += opened.read()
    return data


def test_a_line_that_is_no_file_is_read_as_well():
    opened = Port('loop://', 57600, timeout=0.01)
    assert opened.descriptor is None and opened.read() == b''
    opened.write(bytes(range(256)))
    assert received(opened, 256) == bytes(range(256))
    opened.close()


def test_a_line_over_the_network_is_read_and_lost():
    with socket.create_server(('127.0.0.1', 0)) as server:
        opened = Port(f'socket://127.0.0.1:{server.getsockname()[1]}', 57600, timeout=TIMEOUT)
        other, _ = server.accept()
    with closing(opened), closing(other):
        assert opened.descriptor is not None
        other.sendall(b'hello')
        assert received(opened, 5) == b'hello'
        opened.write(b'\x80\x83')
        assert other.recv(2, socket.MSG_WAITALL) == b'\x80\x83'
        other.shutdown(socket.SHUT_RDWR)
        with pytest.raises(PortError, match='is the cable in'):
            opened.read()


def test_a_fast_line_gives_the_robot_time_for_each_byte(monkeypatch):
    other, ours = os.openpty()
    opened = Port(os.ttyname(ours), 57600, timeout=0.01)
    os.close(ours)
    slept = []
    monkeypatch.setattr(port, 'time', SimpleNamespace(sleep=slept.append))
    opened.baud = FAST_BAUD
    opened.write(b'\x80\x83')
    assert receive(other, 2) == b'\x80\x83' and slept == [FAST_SPACING] * 2
    os.close(other)
    opened.close()


def test_who_holds_a_port_is_named(terminal):
    held = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
    with subprocess.Popen(['sleep', '60'], stdin=held) as child:
        named = holder(terminal)
        child.kill()
    os.close(held)
    assert named == f'sleep (process {child.pid})'


def test_the_lasting_name_of_a_device_is_found(tmp_path, terminal):
    assert lasting_name(terminal, str(tmp_path)) is None
    (tmp_path / 'usb-adapter-if00').symlink_to(terminal)
    assert lasting_name(terminal, str(tmp_path)) == str(tmp_path / 'usb-adapter-if00')


class Heard:
    """The notices of a session, which other threads may wait for."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.distance = 0.0
        """Metres driven forward."""
        self._told = threading.Condition()

    def __call__(self, event) -> None:
        """Take an event in."""
        with self._told:
            if isinstance(event, Notice):
                self.texts.append(event.text)
            elif isinstance(event, Moved):
                self.distance = event.estimate.x
            self._told.notify_all()

    def wait_for_more(self) -> None:
        """Wait for the next event."""
        with self._told:
            assert self._told.wait(TIMEOUT), self.texts

    def wait_for(self, words: str, times: int = 1) -> None:
        """Wait until some words have been said so often."""
        with self._told:
            assert self._told.wait_for(
                lambda: sum(words in text for text in self.texts) >= times, TIMEOUT), self.texts


@contextmanager
def session_on(url: Path | str, *, dead_man: bool = False, **settings):
    """Keep a driver connected; yield it and what is heard of it."""
    heard = Heard()
    ours = Session(
        Driver(Settings(**settings)), str(url), on_event=heard, on_failure=lambda: None,
        dead_man=dead_man)
    ours.start()
    try:
        yield ours, heard
    finally:
        ours.close()


def robot_on(link: Path) -> closing[Robot]:
    """Switch a robot on."""
    return closing(Robot(link, shipped('empty'), Rounding.CARRY, DEFAULT_BODY))


class BareLine(serial.Serial):
    """A terminal, which has none of the lines that RFC 2217 carries."""

    rts = dtr = cts = dsr = ri = cd = False


@contextmanager
def served(device: Path, *, telnet: bool):
    """Put a server in front of a device; yield its port."""
    def serve() -> None:
        connection, _ = listener.accept()
        with connection, BareLine(str(device), 57600, timeout=0) as line:
            manager = PortManager(line, SimpleNamespace(write=connection.sendall))
            while True:
                ready, _, _ = select([line, connection], [], [])
                if connection in ready:
                    data = connection.recv(4096)
                    if not data:
                        return
                    line.write(b''.join(manager.filter(data)) if telnet else data)
                if line in ready:
                    data = line.read(4096)
                    connection.sendall(b''.join(manager.escape(data)) if telnet else data)
    with socket.create_server(('127.0.0.1', 0)) as listener:
        server = threading.Thread(target=serve)
        server.start()
        yield listener.getsockname()[1]
        server.join(TIMEOUT)
        assert not server.is_alive()


@pytest.mark.filterwarnings('ignore:set')  # pyserial 3.5
@pytest.mark.parametrize('scheme', ['socket', 'RFC2217'])
def test_a_robot_is_found_and_driven_by_any_url(tmp_path, scheme):
    device = tmp_path / 'tty'
    with (robot_on(device), served(device, telnet=scheme != 'socket') as number,
          session_on(f'{scheme}://127.0.0.1:{number}', dead_man=True) as (ours, heard)):
        heard.wait_for('robot answers')
        while not heard.distance > 0.02:
            ours.drive(0.2, 0.0)
            heard.wait_for_more()
        assert not [text for text in heard.texts if 'no dead-man' in text]


def test_a_device_that_comes_back_under_another_name_is_found(tmp_path, monkeypatch):
    name = tmp_path / 'by-id' / 'usb-adapter'
    name.parent.mkdir()
    named = threading.Event()

    def asked(url: str) -> str | None:
        named.set()
        return lasting_name(url, str(tmp_path / 'by-id'))
    monkeypatch.setattr(session, 'lasting_name', asked)
    name.symlink_to(tmp_path / 'ttyUSB0')  # before the port is there: it is asked for once
    with session_on(tmp_path / 'ttyUSB0') as (_, heard):
        with robot_on(tmp_path / 'ttyUSB0'):
            heard.wait_for('robot answers')
            named.wait(TIMEOUT)
        heard.wait_for('does not exist')
        with robot_on(tmp_path / 'ttyUSB1'):
            (tmp_path / 'beside').symlink_to(tmp_path / 'ttyUSB1')
            (tmp_path / 'beside').replace(name)
            heard.wait_for('robot answers', times=2)
        name.unlink()
        with robot_on(tmp_path / 'ttyUSB0'):  # by another adapter
            heard.wait_for('robot answers', times=3)


def test_a_dead_man_that_was_killed_is_replaced(tmp_path, monkeypatch):
    monkeypatch.setattr(session, 'LEAST_LIFE', 0.0)
    with robot_on(tmp_path / 'tty'), session_on(tmp_path / 'tty', dead_man=True) as (_, heard):
        heard.wait_for('robot answers')
        first = dead_man()
        os.kill(first, signal.SIGKILL)
        heard.wait_for('another one has been started')
        second = dead_man()
        assert second != first
        monkeypatch.setattr(session, 'LEAST_LIFE', 1000.0)
        os.kill(second, signal.SIGKILL)
        heard.wait_for('drives on')
        assert not dead_men()


def test_at_an_orderly_end_the_dead_man_says_nothing(tmp_path):
    modes, later = [], threading.Event()

    def look() -> None:
        modes.append(robot.create.mode)
        if modes[-20:] == [Mode.FULL] * 20:  # 0.3 s, in which its bytes would have come
            later.set()
    with robot_on(tmp_path / 'tty') as robot:
        with session_on(tmp_path / 'tty', dead_man=True, mode_on_exit=Mode.FULL) as (ours, heard):
            heard.wait_for('robot answers')
        assert ours.port is None
        robot.watch(look)
        assert later.wait(TIMEOUT)


def test_a_robot_whose_line_takes_no_bytes_for_once_is_stopped_by_the_dead_man(
        tmp_path, monkeypatch):
    def fail(*_, **__):
        raise PortError('a line that fails')
    stands = threading.Event()
    with robot_on(tmp_path / 'tty') as robot, \
            session_on(tmp_path / 'tty', dead_man=True) as (ours, heard):
        heard.wait_for('robot answers')
        while not any(robot.create.actuators.wheels):
            ours.drive(0.2, 0.0)
            heard.wait_for_more()
        robot.watch(lambda: any(robot.create.actuators.wheels) or stands.set())
        monkeypatch.setattr(ours, '_open_port', fail)  # or the driver would stop it, too
        monkeypatch.setattr(Port, 'write', fail)
        ours.drive(0.2, 0.0)
        heard.wait_for('a line that fails')
        assert stands.wait(TIMEOUT) and ours.port is None
