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
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import shipped
from support.source import ROOT

QUARTER = 90
STEP = 0.005
"""Seconds that pass at once: a third of a slot."""


class MemoryPort:
    """What `serial.Serial` has, and what `time` has; time passes only while a program waits."""

    def __init__(self, create: Create, timeout: float = 1.0) -> None:
        self._create, self._timeout = create, timeout
        self._received = b''
        self._now = 0.0
        create.poll(0.0)

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        until = self._now + seconds
        while self._now < until - STEP / 2:
            self._now += STEP
            self._create.poll(self._now)
            self._received += self._create.data_to_send()

    def monotonic(self) -> float:
        """Return the time."""
        return self._now

    def write(self, data: bytes) -> None:
        """Send bytes to the robot."""
        self._create.receive(data, self._now)
        self._received += self._create.data_to_send()

    def read(self, size: int) -> bytes:
        """Wait for bytes; return fewer after the timeout."""
        until = self._now + self._timeout
        while len(self._received) < size and self._now < until:
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


class Bench:
    """A simulated robot as `create_sim` has it, and its port."""

    def __init__(self) -> None:
        self.body = Body(shipped('empty'))
        self.create = Create(self.body, guesses=Guesses(boot_seconds=0))
        self.port = MemoryPort(self.create)

    def example(self, name: str) -> ModuleType:
        """Return an example whose time is that of the robot."""
        module = import_module(f'examples.{name}')
        module.time = self.port  # type: ignore[attr-defined]
        return module

    @property
    def wheels(self) -> tuple[float, float]:
        """The commanded speeds, mm/s."""
        return tuple(self.create.actuators.wheels)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_the_square_ends_where_it_began(bench, capsys):
    bench.example('oi_square').main(bench.port)
    truth = bench.body.truth()
    assert hypot(truth.pose.x, truth.pose.y) < 0.05
    assert abs(truth.pose.yaw) < 0.2
    assert truth.travelled == pytest.approx(4 * 0.5, rel=0.02)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    for line in lines:
        distance, angle = map(int, re.findall(r'(\d+) (?:mm|degrees)', line))
        assert distance == pytest.approx(500, abs=10) and angle == pytest.approx(QUARTER, abs=5)
    assert (bench.create.mode, bench.wheels) == (oi.Mode.PASSIVE, (0, 0))


@pytest.mark.parametrize('name', ['oi_square', 'oi_script'])
def test_an_answer_with_lost_bytes_is_asked_for_again(bench, name):
    example = bench.example(name)
    read, asked = bench.port.read, count()
    bench.port.read = lambda size: read(size)[:-1 if next(asked) % 2 == 0 else None]
    example.main(bench.port)
    assert bench.body.truth().travelled > 0.25
    assert bench.wheels == (0, 0)


def test_the_log_ends_where_no_frame_comes(bench):
    bench.port.write = lambda data: None  # the robot is off
    with pytest.raises(SystemExit, match='no frame for 3 s: is the robot switched on'):
        bench.example('oi_log').log(bench.port, io.StringIO(newline=''))


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


def test_the_log_has_a_row_for_each_frame(bench):
    bench.body.force(analog=512)
    file = io.StringIO(newline='')
    example = bench.example('oi_log')
    example.log(bench.port, file, 100)
    rows = list(csv.DictReader(io.StringIO(file.getvalue())))
    assert len(rows) == 100
    assert rows[0].keys() == {'seconds', 'analog_volts', *example.PACKETS.names}
    assert {row['oi_mode'] for row in rows} == {'1'}
    assert {(row['analog_signal'], row['analog_volts']) for row in rows} == {('512', '2.502')}
    assert float(rows[-1]['seconds']) - float(rows[0]['seconds']) == pytest.approx(99 * oi.SLOT)
    bench.port.sleep(1.0)
    bench.port.reset_input_buffer()
    bench.port.sleep(1.0)
    assert bench.port.in_waiting == 0  # the stream is paused


def test_the_script_is_stored_and_played_to_its_end(bench, capsys):
    example = bench.example('oi_script')
    example.main(bench.port)
    pose = bench.body.truth().pose
    assert pose.x == pytest.approx(0.3, abs=0.1) and degrees(pose.yaw) == pytest.approx(90, abs=15)
    assert capsys.readouterr().out.splitlines()[:3] == [
        'the script can end',
        'until this has happened, even a stop is ignored: Wait Distance distance=300',
        'until this has happened, even a stop is ignored: Wait Angle angle=90']
    assert (bench.create.mode, bench.wheels) == (oi.Mode.PASSIVE, (0, 0))
