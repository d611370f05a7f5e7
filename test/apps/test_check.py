# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_check`: moves, what they show, and the program at a simulated robot's port."""

from dataclasses import replace
import signal
import subprocess
import sys
import time

import pytest

from create_oi_ros.apps.check import conclusion
from create_oi_ros.apps.check import fit as fits
from create_oi_ros.apps.check.conclusion import conclude, Conclusion, time_constant
from create_oi_ros.apps.check.dead_band_search import DeadBandSearch
from create_oi_ros.apps.check.fractions import roundings
from create_oi_ros.apps.check.moves import creep, duration, Move, Reads, Segment, STEPS
from create_oi_ros.apps.check.notebook import Notebook, Page
from create_oi_ros.apps.check.runner import Runner
from create_oi_ros.apps.check.trial_wheels import Sign
from create_oi_ros.apps.check.verdict import as_mapping, banner_in, lines, of_wheels
from create_oi_ros.odometry import Family, Known, Rounding, SignSource
from create_oi_ros.ros.odometry_model import parsed, text_of
from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.sim.body.config import BodyConfig
from create_oi_ros.sim.body.wheels import Response, TimeConstant
from support.bodies import LAGGING
from support.loop import Loop
from support.simulator import taught

TURNS = 4000
"""Turns of the loop that a move may take: 20 seconds."""


class Floor:
    """A robot in memory that makes the moves of a check."""

    def __init__(self, rounding: Rounding = Rounding.TRUNCATE,
                 config: BodyConfig = LAGGING) -> None:
        notebook = Notebook()
        self.loop = Loop(rounding=rounding, config=config, odometry=notebook)
        self.runner = Runner(self.loop.driver, notebook)
        self.loop.run(0.5)

    def make(self, move: Move) -> Page | None:
        """Make a move; None: it was disturbed."""
        self.runner.begin(move)
        for _ in range(TURNS):
            self.turn()
            if not self.runner.busy:
                return None if self.runner.disturbance else self.runner.pages[-1]
        raise AssertionError(f'{move} does not end')

    def turn(self) -> None:
        """Let a step of time pass."""
        self.loop.turn()
        self.runner.poll(self.loop.now)

    def made(self, move: Move) -> Page:
        """Make a move that nothing disturbs."""
        page = self.make(move)
        assert page is not None
        return page


def ahead(speed: int, seconds: float, reads: Reads = Reads.END) -> Move:
    """Return a straight move."""
    return Move((Segment(seconds, speed, speed),), reads)


def checked(config: BodyConfig = LAGGING) -> tuple[Floor, Conclusion]:
    """Return what the whole program finds of a robot."""
    floor = Floor(config=config)
    pages = [floor.made(move) for step in STEPS for move in step.moves]
    period = floor.loop.driver.health(floor.loop.now).frame_period
    return floor, conclude(pages, (0.009, 0.01), period)


@pytest.fixture(scope='module')
def found() -> tuple[Floor, Conclusion]:
    """Return what is found of the most likely robot."""
    return checked()


def test_the_program_takes_less_than_five_minutes():
    assert sum(duration(step.moves) for step in STEPS) < 270


def test_each_step_ends_where_it_began(found):
    truth = found[0].loop.body.truth()
    assert abs(truth.pose.x) < 0.1
    assert abs(truth.pose.y) < 0.1


def test_the_wheels_of_the_likeliest_robot_are_found(found):
    kind, known = found[1].wheels.kind, found[1].knowledge
    assert known.likeliest == (Rounding.TRUNCATE, SignSource.DRIVE)
    assert not found[1].is_ramp
    for speed in (0.05, 0.076):
        assert time_constant(kind, speed) == pytest.approx(
            LAGGING.time_constant.at(speed), rel=0.15)
    assert known.right_gain.value == pytest.approx(1.0, abs=0.01)
    assert known.left_gain.value == pytest.approx(1.0, abs=0.01)
    assert known.dead_time.value == pytest.approx(0.045, abs=0.01)
    assert known.separation_factor.value == pytest.approx(0.262 / 0.258, abs=0.01)
    assert known.certain


@pytest.mark.nightly
def test_wheels_that_overshoot_are_found():
    config = replace(LAGGING, response=Response.SECOND_ORDER, time_constant=TimeConstant(0.06),
                     overshoot=0.3)
    floor, conclusion = checked(config)
    findings = of_wheels(conclusion, floor.loop.driver.health(floor.loop.now))
    assert 'second order: overshoots by' in '\n'.join(lines(findings))
    known = parsed(text_of(conclusion.knowledge))
    assert known.family is Family.SPRING
    assert known.overshoot == pytest.approx(0.3, abs=0.05)
    late = 2 * 0.358 * 0.06 + config.dead_time  # 0.358 is the damping of such an overshoot
    assert known.delay(0.2).value == pytest.approx(late, abs=0.01)


SHORT = (ahead(200, 1.0, Reads.OFTEN), ahead(-200, 1.0, Reads.OFTEN), ahead(100, 1.5),
         ahead(-100, 1.5), Move((Segment(0.8, 150, 150), Segment(0.8, -150, -150)), Reads.OFTEN))
"""Moves that tell a little about wheels."""


@pytest.mark.nightly
def test_wheels_that_are_not_near_a_usual_start_are_looked_for(monkeypatch):
    monkeypatch.setattr(fits, 'TAU_FACTORS', (0.5,))
    monkeypatch.setattr(fits, 'OVERSHOOTS', fits.OVERSHOOTS[1:])
    floor = Floor(config=replace(LAGGING, response=Response.SECOND_ORDER, overshoot=0.35,
                                 time_constant=TimeConstant(0.034), braking=2.0))
    pages = [floor.made(move) for move in SHORT]
    best = fits.search(pages, Rounding.TRUNCATE, 0.015)[0]
    assert (best.start.family, best.sign) == (Family.SPRING, Sign.DRIVE)
    assert not best.is_bad
    assert time_constant(best.kind, 0.2) == pytest.approx(0.034, rel=0.15)


def test_wheels_that_explain_readings_badly_are_not_the_last_word(found, monkeypatch):
    pages, good = found[0].runner.pages, found[1].wheels
    bad, period = replace(good, cost=good.readings * 2.0), Known(0.015, 1e-6)
    monkeypatch.setattr(conclusion, 'roundings', lambda *_: {
        Rounding.TRUNCATE: 0.49, Rounding.ROUND: 0.0, Rounding.CARRY: 0.51})
    monkeypatch.setattr(conclusion, 'fit', lambda pages, rounding, period: [
        bad if rounding is Rounding.CARRY else good])
    assert conclude(pages, (0.0, 0.001), period).knowledge.rounding[Rounding.TRUNCATE] > 0.99
    monkeypatch.setattr(conclusion, 'fit', lambda *_: [bad])
    monkeypatch.setattr(conclusion, 'search', lambda *_: [good])
    assert conclude(pages, (0.0, 0.001), period).wheels is good


def test_the_verdict_is_words_and_a_model(found):
    floor, conclusion = found
    findings = of_wheels(conclusion, floor.loop.driver.health(floor.loop.now))
    text = '\n'.join(lines(findings))
    assert 'cut off and lost at each reading (over 99.9 % sure)' in text
    assert 'of the drive' in text
    assert 'first order' in text
    assert '10 mm/s (9 mm/s does not)' in text
    assert 'with the header' in text
    again = parsed(text_of(conclusion.knowledge, as_mapping(findings)))
    assert again.right_gain.value == pytest.approx(conclusion.knowledge.right_gain.value)


@pytest.mark.parametrize('rounding', Rounding)
def test_what_becomes_of_fractions_is_seen(rounding):
    floor = Floor(rounding)
    pages = [floor.made(move) for move in (
        ahead(300, 1.5), ahead(-300, 0.9), ahead(48, 2.5, Reads.EVERY),
        Move((Segment(2.0, 200, -200),), Reads.END), Move((Segment(1.0, -200, 200),), Reads.END),
        Move((Segment(2.5, 110, -110),), Reads.EVERY))]
    believed = roundings(pages, 0.015)
    assert believed[rounding] > 0.99


@pytest.mark.parametrize('band', [0.0, 0.0045, 0.0195])
def test_the_slowest_speed_that_moves_it_is_found(band):
    floor, search = Floor(config=replace(LAGGING, dead_band=band)), DeadBandSearch()
    while (move := search.next_move()) is not None:
        search.learn(floor.made(move))
    stands, moves = search.band
    assert stands <= band <= moves
    assert moves - stands == pytest.approx(0.001)


def test_all_readings_of_a_move_add_up_to_its_way():
    floor = Floor(Rounding.CARRY)
    before = floor.loop.body.distance_total
    page = floor.made(ahead(150, 1.5, Reads.OFTEN))
    assert page.counted[0] == pytest.approx(floor.loop.body.distance_total - before, abs=1)


def test_a_robot_that_is_lifted_ends_the_move():
    floor = Floor()
    floor.runner.begin(ahead(200, 2.0))
    while not floor.loop.body.truth().speed:
        floor.turn()
    floor.loop.body.lift(True)
    while floor.runner.busy:
        floor.turn()
    assert floor.runner.disturbance is not None
    assert 'wheel' in floor.runner.disturbance
    assert not floor.runner.pages


def test_a_robot_that_falls_silent_ends_the_move():
    floor = Floor()
    floor.runner.begin(ahead(200, 2.0))
    floor.loop.cut = True
    while floor.runner.busy:
        floor.turn()
    assert floor.runner.disturbance == 'the robot does not answer any more'


def test_a_banner_is_told_from_frames():
    assert banner_in(bytes(range(200, 256)) * 3).answer == 'nothing that can be read'
    said = b'\x13\x05bl-start 2005-01-01 revision 7\r\nbattery present\x80'
    assert 'bl-start 2005-01-01' in banner_in(said).answer


def test_a_creep_is_answered_by_its_opposite():
    assert creep(9, back=True).segments[0].right == -9


def test_an_unknown_checksum_is_not_claimed(found):
    health = replace(found[0].loop.driver.health(0.0), checksum=None)
    assert [each.answer for each in of_wheels(found[1], health)
            if each.name == 'checksum'] == ['not known']


def test_ctrl_c_stops_the_wheels(tmp_path):
    with taught(tmp_path) as (port, control):
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


@pytest.mark.parametrize(('arguments', 'said'), [
    (['-o', '/nowhere/robot.yaml'], 'create_check: /nowhere is no folder'),
    (['--baud', '123'], 'invalid choice'),
    (['--capture', '/nowhere/x.capture'], 'create_check: /nowhere/x.capture: it does not exist')])
def test_what_cannot_be_is_said_in_a_line(tmp_path, arguments, said):
    done = subprocess.run(
        [sys.executable, '-c', PROGRAMS['create_check'], '--yes', *arguments,
         tmp_path / 'port'], text=True, capture_output=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert 'Traceback' not in done.stderr
