"""Ports that cannot be had, in words; a device that comes back under another name."""

import errno
import os
from pathlib import Path
import subprocess
import sys
import threading

import pytest

from create_oi_ros import port, session
from create_oi_ros.driver import Driver, Link, Notice
from create_oi_ros.port import holder, lasting_name, Port, PortError
from create_oi_ros.session import Session
from create_oi_ros.sim.encoders import Rounding
from create_oi_ros.sim.world import shipped
from ros import PATIENCE, Robot

HOLDER = """
import os, sys
os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
print('open', flush=True)
sys.stdin.read()
"""


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


def test_without_permission_the_command_that_gives_it_is_named(monkeypatch):
    monkeypatch.setenv('USER', 'ada')
    said = port._advice('/dev/ttyUSB0', OSError(errno.EACCES, 'Permission denied'))
    assert 'sudo usermod -aG dialout ada' in said


def test_a_port_is_ours_alone_and_the_other_is_told_by_whom(terminal):
    ours = Port(terminal, 57600, timeout=0.01)
    assert 'is in use by' in refused(terminal)
    ours.close()
    Port(terminal, 57600, timeout=0.01).close()


def test_who_holds_a_port_is_named(terminal):
    child = subprocess.Popen(
        [sys.executable, '-S', '-c', HOLDER, terminal], stdin=subprocess.PIPE,
        stdout=subprocess.PIPE)
    assert child.stdout is not None
    assert child.stdout.readline()
    assert f'(process {child.pid})' in str(holder(terminal))
    child.communicate()


def test_what_is_no_device_is_refused(tmp_path):
    (tmp_path / 'file').write_text('')
    assert str(tmp_path / 'file') in refused(str(tmp_path / 'file'))
    assert 'socket://' in refused('nonsense://x')


def test_the_lasting_name_of_a_device_is_found(tmp_path, terminal):
    assert lasting_name(terminal, str(tmp_path)) is None
    (tmp_path / 'usb-adapter-if00').symlink_to(terminal)
    assert lasting_name(terminal, str(tmp_path)) == str(tmp_path / 'usb-adapter-if00')


def test_a_device_that_comes_back_under_another_name_is_found(tmp_path, monkeypatch):
    names = tmp_path / 'by-id'
    names.mkdir()
    monkeypatch.setattr(session, 'lasting_name', lambda url: lasting_name(url, str(names)))
    notices: list[str] = []
    told = threading.Condition()

    def on_event(event):
        if isinstance(event, Notice):
            with told:
                notices.append(event.text)
                told.notify_all()

    def wait_for(words: str) -> None:
        with told:
            assert told.wait_for(lambda: any(words in text for text in notices), PATIENCE), notices

    robot = Robot(tmp_path / 'ttyUSB0', shipped('empty'), Rounding.CARRY)
    (names / 'usb-adapter').symlink_to(tmp_path / 'ttyUSB0')
    ours = Session(
        Driver(), str(tmp_path / 'ttyUSB0'), on_event=on_event, on_failure=lambda: None)
    ours.start()
    try:
        wait_for('robot answers')
        robot.close()
        wait_for('does not exist')
        notices.clear()
        robot = Robot(tmp_path / 'ttyUSB1', shipped('empty'), Rounding.CARRY)
        beside = Path(tmp_path / 'beside')
        beside.symlink_to(tmp_path / 'ttyUSB1')
        beside.replace(names / 'usb-adapter')
        wait_for('robot answers')
        assert any(f'{names}/usb-adapter opened' in text for text in notices)
        assert ours.driver.link is Link.UP
    finally:
        ours.close()
        robot.close()
