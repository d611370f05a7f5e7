# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_check`: moves, what they show, and the program at a simulated robot's port."""

from contextlib import closing
from dataclasses import replace
import fcntl
from math import degrees, radians
import os
import signal
import subprocess
import sys
import time

import pytest

from create_oi_ros import oi
from create_oi_ros.apps.check import robot_line
from create_oi_ros.apps.check.moves import Move, Reads, Segment, STEPS
from create_oi_ros.apps.check.questions import by_tape, in_lines, Person
from create_oi_ros.apps.check.robot_line import Notebook, RobotLine, Runner
from create_oi_ros.apps.check.verdict import as_mapping, banner_in, lines, of_gyro, of_wheels
from create_oi_ros.driver import Settings
from create_oi_ros.link.port import Port
from create_oi_ros.odometry import GyroSettings, Knowledge, Rounding, SignSource
from create_oi_ros.odometry.gyro import STEP
from create_oi_ros.ros.odometry_model import parsed, text_of
from create_oi_ros.ros.programs import create_check, PROGRAMS, UserError
from create_oi_ros.sim.body.config import BodyConfig, DEFAULT_BODY
from create_oi_ros.sim.body.gyro import Gyro
from support.loop import Loop
from support.simulator import taught

TURNS = 4000
"""Turns of the loop that a move may take: 20 seconds."""


class Floor:
    """A robot in memory that makes the moves of a check."""

    def __init__(self, rounding: Rounding = Rounding.TRUNCATE,
                 config: BodyConfig = DEFAULT_BODY) -> None:
        self.notebook = Notebook()
        self.loop = Loop(Settings(gyro=GyroSettings()), rounding=rounding, config=config,
                         odometry=self.notebook)
        self.runner = Runner(self.loop.driver, self.notebook)
        self.loop.run(0.5)

    def make(self, move: Move) -> bool:
        """Make a move; False: it was disturbed."""
        self.runner.begin(move)
        for _ in range(TURNS):
            self.turn()
            if not self.runner.busy:
                return self.runner.disturbance is None
        raise AssertionError(f'{move} does not end')

    def turn(self) -> None:
        """Let a step of time pass."""
        self.loop.turn()
        self.runner.poll(self.loop.now)


def ahead(speed: int, seconds: float, reads: Reads = Reads.END) -> Move:
    """Return a straight move."""
    return Move((Segment(seconds, speed, speed),), reads)


@pytest.fixture(scope='module')
def found() -> tuple[Floor, Knowledge]:
    """Return what is found of the most likely robot, with a gyro."""
    floor = Floor(config=replace(DEFAULT_BODY, gyro=True))
    for step in STEPS:
        for move in step.moves:
            assert floor.make(move)
    known = floor.loop.driver.health(floor.loop.now).robot
    assert known is not None
    return floor, known


def test_the_program_takes_less_than_five_minutes_and_ends_where_it_began(found):
    assert sum(move.seconds for step in STEPS for move in step.moves) < 270
    truth = found[0].loop.body.truth()
    assert abs(truth.pose.x) < 0.1
    assert abs(truth.pose.y) < 0.1


def test_the_wheels_of_the_likeliest_robot_are_found(found):
    known = found[1]
    assert known.likeliest == (Rounding.TRUNCATE, SignSource.DRIVE)
    assert known.right_gain.value == pytest.approx(1.0, abs=0.01)
    assert known.left_gain.value == pytest.approx(1.0, abs=0.01)
    assert known.angle_factor.value == pytest.approx(0.258 / 0.262, abs=0.01)
    assert known.delay(0.2).value == pytest.approx(0.025 + 0.075, abs=0.01)  # coasts 15 mm
    assert known.certain


def test_scale_and_zero_of_a_gyro_are_found(found):
    floor, known = found
    gyro, true = known.gyro, Gyro(0)
    zero, scale = (sum(true.read(rate, 270.0) for _ in range(4000)) / 4000
                   for rate in (0.0, radians(100)))
    assert gyro.zero.value == pytest.approx(zero * STEP, abs=2e-3)
    assert gyro.scale.value == pytest.approx(100 / (scale - zero) / STEP, rel=2e-3)
    found_of_it = of_gyro(floor.loop.driver.health(floor.loop.now))
    assert found_of_it.answer.startswith(f'{gyro.scale.value:.2f} +- ')


def test_a_robot_without_a_gyro_has_none():
    floor = Floor()
    assert floor.make(ahead(100, 1.0))
    assert 'none that follows' in of_gyro(floor.loop.driver.health(floor.loop.now)).answer


def test_the_verdict_is_words_and_a_model(found):
    floor, known = found
    findings = of_wheels(known, floor.loop.driver.health(floor.loop.now).checksum)
    text = '\n'.join(lines(findings))
    assert 'cut off and lost at each reading' in text
    assert 'of the drive' in text
    assert 'of coasting' in text
    assert 'with the header' in text
    assert [each.answer for each in of_wheels(known, None)
            if each.name == 'checksum'] == ['not known']
    again = parsed(text_of(known, as_mapping(findings)))
    assert again == known


@pytest.mark.parametrize(('happen', 'why'), [
    (lambda loop: loop.body.lift(True), 'wheel'),
    (lambda loop: setattr(loop, 'cut', True), 'the robot does not answer any more')])
def test_a_robot_that_is_lifted_or_falls_silent_ends_the_move(happen, why):
    floor = Floor()
    floor.runner.begin(ahead(200, 2.0))
    while not floor.loop.body.truth().speed:
        floor.turn()
    happen(floor.loop)
    while floor.runner.busy:
        floor.turn()
    assert why in str(floor.runner.disturbance)


def test_a_banner_is_told_from_frames():
    assert banner_in(bytes(range(200, 256)) * 3).answer == 'nothing that can be read'
    said = b'\x13\x05bl-start 2005-01-01 revision 7\r\nbattery present\x80'
    assert 'bl-start 2005-01-01' in banner_in(said).answer


def test_ctrl_c_stops_the_wheels(tmp_path):
    with taught(tmp_path, '--guess', 'dead_band=0') as (port, control):
        program = subprocess.Popen(
            [sys.executable, '-c', PROGRAMS['create_check'], '--yes', '-o',
             tmp_path / 'robot.yaml', '--capture', tmp_path / 'all.capture', port],
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        deadline = time.monotonic() + 60
        while not control.truth()['speed']:
            assert time.monotonic() < deadline
            assert program.poll() is None
        program.send_signal(signal.SIGINT)
        told, errors = program.communicate(timeout=30)
        assert '\nStep 1 of 7 (' in told
        assert program.returncode == 130
        assert errors.strip().endswith('create_check: interrupted; the wheels stand')
        while control.truth()['speed']:
            assert time.monotonic() < deadline
    assert (tmp_path / 'all.capture').stat().st_size > 1000
    assert not (tmp_path / 'robot.yaml').exists()


@pytest.mark.filterwarnings('ignore::pytest.PytestUnhandledThreadExceptionWarning')
def test_a_port_that_fails_ends_what_waits_for_the_robot(tmp_path):
    def fail():
        raise RuntimeError('a fault on purpose')
    with taught(tmp_path) as (port, _):
        line = RobotLine(str(port), 57600, str(tmp_path / 'all.capture'))
        with line.open():
            line.wait_for_robot()
            line.session.port.read = fail
            for wait in (lambda: line.enter(oi.Mode.FULL), lambda: line.make(STEPS[0].moves[0]),
                         line.wait_for_robot):
                with pytest.raises(UserError, match='the line to the robot has failed'):
                    wait()


def test_of_a_slow_line_all_is_awaited_that_the_first_steps_ask_for(tmp_path):
    with taught(tmp_path) as (port, control):
        with closing(Port(str(port), 57600, timeout=0.02)) as host:
            host.write(oi.Start().encode() + oi.Baud(code=oi.BaudCode.B19200).encode())
            while control.truth()['baud'] != 19200:
                pass
        line = RobotLine(str(port), 19200, str(tmp_path / 'all.capture'))
        with line.open():
            line.wait_for_robot()
            assert not line.session.health().readings.charging_sources


@pytest.fixture
def refused(monkeypatch, capsys, tmp_path):
    """Return a function that runs the program and returns its errors and all else it said."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(signal, 'signal', lambda number, handler: None)

    def run(*arguments: str) -> tuple[str, str]:
        monkeypatch.setattr('sys.argv', ['create_check', '--yes', *arguments])
        try:
            code = create_check()
        except SystemExit as ended:
            code = ended.code
        assert code == 2
        said, errors = capsys.readouterr()
        return errors, said
    return run


@pytest.mark.parametrize(('arguments', 'words'), [
    (['-o', '/nowhere/robot.yaml'], 'create_check: /nowhere is no folder'),
    (['--baud', '123'], 'invalid choice'),
    (['--capture', '/nowhere/x.capture'], 'create_check: /nowhere/x.capture: it does not exist')])
def test_what_cannot_be_is_said_in_a_line(refused, arguments, words):
    assert words in refused(*arguments, 'port')[0]


@pytest.mark.parametrize(('port', 'why'), [
    ('nowhere', 'nowhere does not exist; '), ('taken', 'is in use by '),
    ('silent', 'no answer at 57600 baud: is the robot on')])
def test_the_port_is_tried_before_the_floor_is_cleared(
        refused, tmp_path, monkeypatch, port, why):
    monkeypatch.setattr(robot_line, 'ANSWER', 3.0)
    line, end = os.openpty()
    for name in ('taken', 'silent'):
        (tmp_path / name).symlink_to(os.ttyname(end))
    if port == 'taken':
        fcntl.flock(end, fcntl.LOCK_EX)
    errors, said = refused(port)
    os.close(line)
    os.close(end)
    sentence, = errors.splitlines()
    assert sentence.startswith('create_check: ') and why in sentence
    assert '`port`' not in sentence and 'parameter' not in sentence, 'it has no parameters'
    assert 'floor' not in said
    assert not list(tmp_path.glob('*.capture'))


# What a tape measure says becomes the scales of the odometry.


@pytest.fixture
def check(monkeypatch):
    """Return a function that does the step, with answers for each of its questions in turn."""
    def do(*answers):
        line, questions = Floor(), []
        told = iter(answers)

        def answer(question):
            questions.append(question)
            if question.endswith('Enter: ') and 'Mark' in question or 'back' in question:
                return ''
            given = next(told)
            return str(given(line) if callable(given) else given)
        monkeypatch.setattr('builtins.input', answer)
        return by_tape(line, Person(absent=False)), line, questions
    return do


def test_what_the_tape_says_becomes_the_scales(check):
    start = []

    def came(line):
        return line.loop.body.truth().pose.x * 1.03

    def beyond(line):  # what it reports, and ten degrees more in each direction
        turned = line.notebook.estimate.trip[1] - (start[0] if start else 0.0)
        start[:] = [line.notebook.estimate.trip[1]]
        return abs(degrees(turned)) - 1080 + 10
    found, _, _ = check('y', came, beyond, beyond)
    assert found['linear_scale'] == pytest.approx(1.03, abs=0.01)
    assert found['angular_scale'] == pytest.approx(1 + 10 / 1080, abs=0.001)
    assert found['wheel_separation'] == pytest.approx(0.258 / found['angular_scale'])
    assert in_lines(found)[1].strip().startswith('linear_scale: 1.0')


def test_what_cannot_be_is_asked_again_and_an_empty_answer_leaves_it_out(check, capsys):
    found, line, _ = check('y', 'a metre', '97', '', '')
    assert found == {} and in_lines(found) == []
    printed = capsys.readouterr().out
    assert "'a metre' is no number" in printed
    assert 'allowed is up to 20%' in printed and 'right unit' in printed
    assert abs(line.loop.body.truth().pose.x) < 0.05, 'it drove back'
