# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The examples without ROS, against a simulated robot in memory, and what their page says."""

import csv
from importlib import import_module
import io
from itertools import count
from math import degrees, hypot
import re
import subprocess
import sys
from types import ModuleType

import pytest

from create_oi_ros import oi
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.firmware.guesses import Guesses
from support.robot import Robot
from support.source import ROOT

QUARTER = 90
STEP = 0.005
"""Seconds that pass at once: a third of a slot."""


class Port:
    """What `serial.Serial` has, and what `time` has; time passes only while a program waits."""

    def __init__(self) -> None:
        """Lead to a simulated robot as `create_sim` has it."""
        self.robot = Robot(guesses=Guesses(boot_seconds=0), rounding=Rounding.TRUNCATE,
                           config=DEFAULT_BODY)
        self._received = b''

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        until = self.robot.now + seconds
        while self.robot.now < until - STEP / 2:
            self._received += self.robot.run(STEP)

    def monotonic(self) -> float:
        """Return the time."""
        return self.robot.now

    def write(self, data: bytes) -> None:
        """Send bytes to the robot."""
        self._received += self.robot.say(data)

    def read(self, size: int) -> bytes:
        """Wait for bytes; return fewer after a second."""
        until = self.robot.now + 1.0
        while len(self._received) < size and self.robot.now < until:
            self.sleep(STEP)
        read, self._received = self._received[:size], self._received[size:]
        return read

    @property
    def in_waiting(self) -> int:
        """The number of bytes that have arrived."""
        return len(self._received)

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._received = b''

    def example(self, name: str) -> ModuleType:
        """Return an example whose time is that of the robot."""
        module = import_module(f'examples.{name}')
        module.time = self  # type: ignore[attr-defined]
        return module


@pytest.fixture
def port() -> Port:
    return Port()


def test_the_square_ends_where_it_began(port, capsys):
    port.example('oi_square').main(port)
    truth = port.robot.body.truth()
    assert hypot(truth.pose.x, truth.pose.y) < 0.05
    assert abs(truth.pose.yaw) < 0.2
    assert truth.travelled == pytest.approx(4 * 0.5, rel=0.02)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    for line in lines:
        distance, angle = map(int, re.findall(r'(\d+) (?:mm|degrees)', line))
        assert distance == pytest.approx(500, abs=10) and angle == pytest.approx(QUARTER, abs=5)
    assert (port.robot.mode, port.robot.wheels) == (oi.Mode.PASSIVE, (0, 0))


@pytest.mark.parametrize('name', ['oi_square', 'oi_script'])
def test_an_answer_with_lost_bytes_is_asked_for_again(port, name):
    example = port.example(name)
    read, asked = port.read, count()
    port.read = lambda size: read(size)[:-1 if next(asked) % 2 == 0 else None]
    example.main(port)
    assert port.robot.body.truth().travelled > 0.25
    assert port.robot.wheels == (0, 0)


def test_the_log_ends_where_no_frame_comes(port):
    port.write = lambda data: None  # the robot is off
    with pytest.raises(SystemExit, match='no frame for 3 s: is the robot switched on'):
        port.example('oi_log').log(port, io.StringIO(newline=''))


@pytest.mark.parametrize('name', ['oi_log', 'square'])
def test_an_example_has_help_and_says_what_is_wrong_with_its_arguments(name, tmp_path):
    def run(*arguments):
        return subprocess.run(
            [sys.executable, str(ROOT / 'examples' / f'{name}.py'), *arguments], text=True,
            capture_output=True, timeout=60, cwd=tmp_path)
    shown = run('--help')
    assert (shown.returncode, shown.stderr) == (0, '') and 'usage' in shown.stdout
    assert run('--bogus').returncode == 2
    if name.startswith('oi_'):
        assert run().returncode == 2
        ended = run('/dev/nothing', *(['log.csv'] if name == 'oi_log' else []))
        assert ended.returncode == 1
        line, = ended.stderr.splitlines()
        assert 'No such file' in line and line.endswith(
            'is the cable in, and are you in the group dialout?')


def test_the_log_has_a_row_for_each_frame(port):
    port.robot.body.force(analog=512)
    file = io.StringIO(newline='')
    example = port.example('oi_log')
    example.log(port, file, 100)
    rows = list(csv.DictReader(io.StringIO(file.getvalue())))
    assert len(rows) == 100
    assert rows[0].keys() == {'seconds', 'analog_volts', *example.PACKETS.names}
    assert {row['oi_mode'] for row in rows} == {'1'}
    assert {(row['analog_signal'], row['analog_volts']) for row in rows} == {('512', '2.502')}
    assert float(rows[-1]['seconds']) - float(rows[0]['seconds']) == pytest.approx(99 * oi.SLOT)
    port.sleep(1.0)
    port.reset_input_buffer()
    port.sleep(1.0)
    assert port.in_waiting == 0  # the stream is paused


def test_the_script_is_stored_and_played_to_its_end(port, capsys):
    example = port.example('oi_script')
    example.main(port)
    pose = port.robot.body.truth().pose
    assert pose.x == pytest.approx(0.3, abs=0.1) and degrees(pose.yaw) == pytest.approx(90, abs=15)
    assert capsys.readouterr().out.splitlines()[:3] == [
        'the script can end',
        'until this has happened, even a stop is ignored: Wait Distance distance=300',
        'until this has happened, even a stop is ignored: Wait Angle angle=90']
    assert (port.robot.mode, port.robot.wheels) == (oi.Mode.PASSIVE, (0, 0))
