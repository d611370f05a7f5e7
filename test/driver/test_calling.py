# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How the driver finds its robot, and what it says of a line that is not well."""

from collections.abc import Callable
from itertools import cycle

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver, Settings, Severity
from create_oi_ros.driver.listening import QUESTIONS
from create_oi_ros.driver.outbox import HALT
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.world import shipped
from support.loop import Loop, said, texts

RATES = [code.rate for code in oi.BaudCode]
TRIED = [57600, 19200, 115200]
"""Rates at which a robot is looked for."""


@pytest.mark.parametrize('baud', TRIED)
def test_the_robot_is_found_at_its_rate(baud):
    loop = Loop(Settings(baud=0), robot_baud=baud)
    loop.run(1)
    assert loop.driver.state.answered
    assert loop.driver.baud == loop.robot.baud == baud
    assert loop.robot.mode is oi.Mode.SAFE
    assert not said(loop, Severity.WARNING, '')
    assert not said(loop, Severity.ERROR, 'baud 0')


@pytest.mark.parametrize(('baud', 'limit'), [(57600, 1.0), (0, 1.5)])
@pytest.mark.parametrize('off', [0.5, 1.5, 4.0, 8.0])
def test_a_robot_that_was_off_is_back_in_time(baud, limit, off):
    loop = Loop(Settings(baud=baud), robot_baud=57600)
    loop.run(0.5)
    loop.robot.power(False, loop.now)
    loop.run(off)
    loop.robot.power(True, loop.now)
    loop.run(loop.robot.guesses.boot_seconds + limit)
    assert loop.robot.mode is oi.Mode.SAFE
    assert not said(loop, Severity.WARNING, '')


@pytest.mark.parametrize('baud', [0, *RATES])
def test_a_call_has_left_before_the_next_one_begins_or_the_rate_changes(baud):
    driver, rate, free_at, tried = Driver(Settings(baud=baud)), None, 0.0, set()
    driver.connected(0.0)
    for now in (step * 0.005 for step in range(6000)):
        driver.poll(now)
        sent = driver.data_to_send()
        if driver.baud != rate or sent.startswith(HALT.encode()):
            assert free_at <= now
        if sent:
            rate = driver.baud
            tried.add(rate)
            free_at = max(free_at, now) + len(sent) * oi.BITS_PER_BYTE / rate
    assert tried == (set(TRIED) if baud == 0 else {baud})


def test_a_port_that_is_opened_again_in_the_search_goes_on_with_the_same_rate():
    loop = Loop(Settings(baud=0), robot_baud=115200)
    loop.cut = True
    while loop.driver.baud != 115200:
        loop.turn()
    loop.cut = False
    loop.driver.disconnected('cable out')
    loop.driver.connected(loop.now)
    loop.run(0.3)
    assert loop.driver.state.answered and loop.driver.baud == 115200


def test_a_silent_robot_is_told_of_once_with_what_to_look_at():
    loop = Loop(Settings(baud=0))
    loop.cut = True
    loop.run(20)
    assert said(loop, Severity.ERROR, 'no answer at 57600, 19200, 115200 baud') == 1
    loop.driver.disconnected('cable out')
    loop.driver.connected(loop.now)
    for _ in range(20):
        loop.run(0.1)
        loop.driver.receive(b'$GPGGA,123519,4807' * 2, loop.now)
    assert said(loop, Severity.ERROR, 'is it another device? The driver keeps') == 1
    assert not said(loop, Severity.ERROR, 'baud 0')


@pytest.mark.parametrize('baud', [9600, 14400])
def test_frames_that_are_cut_for_lack_of_room_are_told_of_in_words(baud):
    loop = Loop(Settings(baud=baud), robot_baud=baud)
    loop.run(10)
    assert said(loop, Severity.ERROR, f'{baud} baud is too slow') == 1


def each_frame_of(loop: Loop, count: int, becomes: Callable[[bytes], bytes]) -> None:
    """Let something become of each second, third, ... frame."""
    take, one_of = loop.robot.data_to_send, cycle([*[False] * (count - 1), True])

    def changed() -> bytes:
        frame = take()
        return becomes(frame) if frame and next(one_of) else frame
    loop.robot.data_to_send = changed


@pytest.mark.parametrize('becomes', [
    lambda frame: b'', lambda frame: frame[:-1] + bytes([frame[-1] ^ 1])], ids=['lost', 'damaged'])
@pytest.mark.parametrize(('count', 'arrive'), [(2, 33), (4, 50), (6, None)])
def test_a_line_with_too_few_whole_frames_is_told_of_once_and_when_it_is_well_again(
        count, arrive, becomes):
    loop = Loop()
    loop.run(5)
    whole = loop.robot.data_to_send
    each_frame_of(loop, count, becomes)
    loop.run(20)
    if arrive is None:  # more than four fifths
        assert not said(loop, Severity.WARNING, '')
        return
    problem = (f'only {arrive} of 67 frames a second arrive whole at 57600 baud: look at plug, '
               'cable, adapter and network')
    assert texts(loop.notices, Severity.WARNING) == [problem]
    assert loop.driver.health(loop.now).line_problem == problem
    loop.robot.data_to_send = whole
    loop.run(10)
    assert said(loop, Severity.INFO, 'frames arrive in time again') == 1
    assert texts(loop.notices, Severity.WARNING) == [problem]
    assert not loop.driver.health(loop.now).line_problem


@pytest.mark.parametrize('baud', [19200, 57600])
def test_of_a_line_that_is_well_nothing_is_said(baud):
    loop = Loop(Settings(baud=baud), robot_baud=baud, delay=0.05)
    loop.run(1)
    loop.drive(0.2, 0.3, 30)
    assert [notice.text for notice in loop.notices] == ['robot answers; entering SAFE']


def test_noise_in_place_of_frames_is_not_taken_for_a_robot_that_is_off(loop):
    loop.robot.data_to_send = lambda: bytes(60)
    loop.run(1)
    assert said(loop, Severity.ERROR, 'but no frame among them') == 1


def reset(loop: Loop) -> None:
    """Restart the robot by the opcode that the manual does not have."""
    loop.robot.receive(b'\x07', loop.now)


def brown_out(loop: Loop) -> None:
    """Let the battery give way for a moment."""
    loop.robot.lose_battery(loop.now)


def switch_on_late(loop: Loop) -> None:
    """Switch a robot on that has not answered for a while."""
    loop.robot.power(False, loop.now)
    loop.run(0.3)
    loop.robot.power(True, loop.now)


@pytest.mark.parametrize('baud', [0, 57600])
@pytest.mark.parametrize('happens', [reset, brown_out, switch_on_late])
@pytest.mark.parametrize('met', [True, False])
def test_a_robot_that_restarts_is_said_to_and_is_no_other_device(happens, baud, met):
    loop = Loop(Settings(baud=baud), robot_baud=57600)
    if met:
        loop.run(1.0)
        loop.drive(0.2, 0.0, 0.5)
    happens(loop)
    loop.run(1.2)
    assert said(loop, Severity.ERROR, 'the robot restarts, by its boot text: it was switched') == 1
    assert 'the robot restarts' in loop.driver.health(loop.now).line_problem
    loop.run(5.0)
    assert not said(loop, Severity.ERROR, 'not like a Create')
    assert not said(loop, Severity.ERROR, 'no answer at')
    assert len(texts(loop.notices, Severity.ERROR)) == 1
    assert loop.robot.mode is oi.Mode.SAFE


@pytest.mark.parametrize('met', [True, False])
def test_a_robot_that_restarts_and_does_not_answer_is_told_of_after_all(met):
    loop = Loop()
    loop.run(1.0 if met else 0.0)
    reset(loop) if met else brown_out(loop)
    loop.run(0.8)
    loop.cut = True
    loop.run(9.0)
    told = texts(loop.notices, Severity.ERROR)
    assert len(told) == 2 and 'the robot restarts' in told[0]
    assert told[1].startswith('no answer at 57600 baud')


@pytest.mark.parametrize('opened', range(1, 1 + len(QUESTIONS)))
@pytest.mark.parametrize('robot_baud', RATES)
def test_a_call_at_another_rate_neither_restarts_the_robot_nor_starts_a_demo(robot_baud, opened):
    robot, driver = Create(Body(shipped('empty'))), Driver(Settings(baud=0))
    rate = oi.Baud(code=oi.BaudCode[f'B{robot_baud}'])
    robot.receive(oi.Start().encode() + rate.encode(), 0.0)
    for _ in range(opened):  # each time another list is asked for
        driver.connected(1.0)
        driver.disconnected('cable out')
    driver.connected(1.0)
    for now in (1 + step * 0.005 for step in range(3000)):
        driver.poll(now)
        sent = driver.data_to_send()
        if driver.baud != robot.baud:
            robot.receive(sent, now, driver.baud)
            assert robot.mode is oi.Mode.PASSIVE and robot.demo is None and not robot.waiting


@pytest.mark.parametrize('begun', [b'', bytes([oi.Song.opcode, 0, 16])])
def test_a_robot_that_drives_is_stopped_when_the_driver_connects(begun):
    loop = Loop()
    loop.robot.receive(b''.join(command.encode() for command in (
        oi.Start(), oi.Full(), oi.DriveDirect(right=300, left=300))) + begun, loop.now)
    loop.run(0.3)  # the first call
    assert loop.body.truth().speed == 0
