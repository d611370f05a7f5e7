# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How the driver finds its robot; a line that is not well or silent, and what is true after."""

from itertools import cycle, pairwise
from math import hypot, radians

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Driver, Settings, Severity
from create_oi_ros.driver.connection import SILENCE
from create_oi_ros.driver.listening import QUESTIONS
from create_oi_ros.driver.outbox import HALT
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.world import shipped
from support.goals import angle, distance, met, reach
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


@pytest.mark.parametrize('becomes', [
    lambda frame: b'', lambda frame: frame[:-1] + bytes([frame[-1] ^ 1])], ids=['lost', 'damaged'])
@pytest.mark.parametrize(('count', 'arrive'), [(2, 33), (4, 50), (6, None)])
def test_a_line_with_too_few_whole_frames_is_told_of_once_and_when_it_is_well_again(
        count, arrive, becomes):
    loop = Loop()
    loop.run(5)
    whole, one_of = loop.robot.data_to_send, cycle([*[False] * (count - 1), True])

    def changed() -> bytes:
        frame = whole()
        return becomes(frame) if frame and next(one_of) else frame
    loop.robot.data_to_send = changed
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


@pytest.mark.parametrize('off', [1.5, 2.0, 3.0, 6.0])
def test_a_robot_that_was_off_is_told_of_once_though_it_restarts_then(off):
    loop = Loop()
    loop.run(1.0)
    loop.robot.power(False, loop.now)
    loop.run(off)
    loop.robot.power(True, loop.now)
    loop.run(9.0)
    assert loop.robot.mode is oi.Mode.SAFE
    assert said(loop, Severity.ERROR, 'no answer at 57600 baud') == 1


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


# A line that falls silent, ends or is slow; what is true after it.


def test_silence_is_said_once_and_the_robot_is_called_until_it_answers(loop):
    loop.drive(0.2, 0.0, 0.3)
    loop.cut = True
    loop.run(5 * SILENCE)
    assert loop.driver.state.activity is Activity.CALLING
    assert loop.driver.status.actual is None
    said = [text.partition(':')[0] for text in texts(loop.notices, Severity.ERROR)]
    assert said == [f'no frame for {SILENCE} s', 'no answer at 57600 baud']
    assert loop.body.truth().speed > 0, 'the last Drive holds for ever'
    loop.cut = False
    loop.run(1.0)
    assert loop.driver.state.answered
    assert loop.robot.mode is oi.Mode.SAFE
    loop.run(0.5)
    assert loop.body.truth().speed == 0


@pytest.mark.parametrize('gap', [0.1, 0.2, 0.3, 0.4, 0.45])
def test_odometry_says_what_was_driven_while_frames_were_lost(loop, gap):
    loop.drive(0.2, 0.0, 3.0)
    off = loop.estimate.x - loop.body.truth().pose.x
    seen = len(loop.moved)
    loop.cut = True
    loop.drive(0.2, 0.0, gap)
    loop.cut = False
    loop.drive(0.2, 0.0, 1.0)
    assert loop.estimate.x - loop.body.truth().pose.x == pytest.approx(off, abs=0.002)
    for before, after in pairwise(loop.moved[seen - 1:]):
        seconds = after.stamp - before.stamp
        assert after.estimate.x - before.estimate.x == pytest.approx(0.2 * seconds, abs=0.003)


@pytest.fixture(scope='module')
def taught():
    """Return a driver that knows its robot: the first seconds have errors of their own."""
    made = Loop()
    made.run(0.3)
    for lesson in ((0.3, 0.0), (-0.2, 0.0), (0.0, 1.5), (0.0, -1.0), (0.2, 0.5), (0.0, 0.0)) * 3:
        made.drive(*lesson, 2.0)
    return made


@pytest.mark.parametrize(('speeds', 'gap', 'still'), [
    ((0.3, 0.0), 0.1, 0.0), ((0.3, 0.0), 0.45, 0.05), ((0.0, 2.0), 0.2, 0.0),
    ((0.0, 2.0), 0.45, 0.2), ((0.2, 1.0), 0.3, 0.05), ((0.2, 1.0), 0.45, 0.0)])
def test_what_was_driven_while_frames_were_lost_is_not_what_is_driven_now(
        taught, gap, speeds, still):
    loop = taught

    def miss():
        estimate, truth = loop.estimate, loop.body.truth()
        return estimate.x - truth.pose.x, estimate.y - truth.pose.y, estimate.yaw - truth.turned

    def off():
        now = miss()
        return hypot(now[0] - before[0], now[1] - before[1]), abs(now[2] - before[2])
    loop.drive(*speeds, 3.0)
    before = miss()
    loop.cut = True
    loop.drive(*speeds, gap)
    loop.cut = False
    loop.drive(*speeds, still)
    most = [each + 0.15 for each in off()]
    for _ in range(6):
        loop.drive(-speeds[0], -speeds[1], 0.1)
        assert all(now < limit for now, limit in zip(off(), most, strict=True))
    loop.drive(0.0, 0.0, 1.0)
    assert off() == pytest.approx((0.0, 0.0), abs=0.1)


# Frames that come late, as on a busy computer, say what was: the driver must not act on it.


@pytest.mark.parametrize('delay', [0.05, 0.2, 0.3, 0.45])
def test_a_robot_that_answers_late_is_not_said_to_have_left_its_mode(loop, delay):
    loop.run(3.0)
    loop.cut, loop.delay = True, delay
    loop.run(0.6)  # the driver calls again, and the robot's last frames in Safe come first
    loop.cut = False
    loop.run(4.0)
    assert loop.driver.status.actual is oi.Mode.SAFE
    assert not [notice.text for notice in loop.notices if 'robot left' in notice.text]


# After gaps, held wheels and waits: goals measure their own way, and the pose says its doubt.


HONEST = 3.5
"""Standard deviations by which an estimate may be off."""


def cut(loop: Loop, seconds: float, linear: float, angular: float) -> None:
    """Drive, and cut the line for a while; the robot drives on."""
    loop.drive(linear, angular, 4.0)
    loop.cut = True
    loop.drive(linear, angular, seconds)
    loop.cut = False


def off(loop: Loop) -> tuple[float, float]:
    """Return by how many of its deviations the estimate is off in place and yaw."""
    truth, e = loop.body.truth(), loop.estimate
    xx, _, _, _, yy, _, _, _, aa = e.pose_covariance
    return (hypot(e.x - truth.pose.x, e.y - truth.pose.y) / (xx + yy) ** 0.5,
            abs(e.yaw - truth.turned) / aa ** 0.5)


@pytest.mark.parametrize('turn', [90, -60])
@pytest.mark.parametrize(('gap', 'linear', 'angular'), [
    (10.0, 0.2, 0.3), (1.2, 0.2, 0.3), (4.0, 0.1, -0.8), (25.0, 0.15, 0.1)])
def test_a_turn_after_a_gap_is_as_long_as_was_asked(gap, linear, angular, turn):
    loop = met()
    cut(loop, gap, linear, angular)
    loop.run(2.0)
    assert reach(loop, angle(turn))[1] == pytest.approx(turn, abs=3.0)


def test_a_distance_after_a_gap_is_as_long_as_was_asked():
    loop = met()
    cut(loop, 6.0, 0.2, 0.0)
    loop.run(2.0)
    assert reach(loop, distance(1.0))[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(('turn', 'straight'), [(90.0, 0.0), (0.0, -0.5)])
@pytest.mark.parametrize('missing', [Loop.lose_line, Loop.lose_port, Loop.stand_still])
@pytest.mark.parametrize(('gap', 'linear', 'angular'), [(5.0, 0.2, 0.5), (13.0, 0.1, 0.7)])
def test_a_goal_at_once_after_a_gap_is_as_long_as_was_asked(
        gap, linear, angular, missing, turn, straight):
    loop = met()
    loop.drive(linear, angular, 3.0)
    missing(loop, gap)
    loop.turn()
    while not loop.driver.state.answered:
        loop.run(0.1)
    loop.run(0.05)  # it enters its mode
    way, turned = reach(loop, angle(turn) if turn else distance(straight))
    assert way == pytest.approx(straight, abs=0.03) and turned == pytest.approx(turn, abs=5.0)


@pytest.mark.parametrize(('seconds', 'rate'), [(1.5, 1.0), (2.5, -0.6)])
def test_a_turn_right_after_wheels_were_held_is_as_long_as_was_asked(seconds, rate):
    loop = met()
    loop.drive(0.0, rate, 3.0)
    loop.body.hold(right=True, left=True)
    loop.drive(0.0, rate, seconds)
    loop.body.hold(right=False, left=False)
    assert reach(loop, angle(90))[1] == pytest.approx(90, abs=5.0)


@pytest.mark.parametrize(('gap', 'linear', 'angular'), [
    (10.0, 0.2, 0.3), (30.0, 0.2, 0.3), (3.0, 0.3, -1.0), (20.0, 0.25, 0.0)])
def test_after_a_gap_the_pose_is_not_surer_than_it_is_right(gap, linear, angular):
    loop = met()
    cut(loop, gap, linear, angular)
    seen = len(loop.moved)
    for _ in range(40):
        loop.run(0.1)
        if len(loop.moved) > seen:
            assert max(off(loop)) < HONEST


def test_a_computer_that_slept_knows_that_it_does_not_know():
    loop = met()
    loop.drive(0.2, 0.2, 3.0)
    loop.stand_still(20.0)
    loop.robot.data_to_send()
    loop.run(0.5)
    assert max(off(loop)) < HONEST
    loop.run(4.0)
    assert max(off(loop)) < HONEST


@pytest.mark.parametrize('mode', [oi.Mode.PASSIVE, oi.Mode.SAFE])
def test_a_robot_that_stands_keeps_its_heading_in_each_mode(mode):
    loop = met()
    loop.drive(0.2, 0.5, 4.0)
    loop.run(2.0)
    loop.driver.modes.set(mode, loop.now)
    before = loop.estimate
    loop.run(180.0)
    assert loop.estimate.yaw == pytest.approx(before.yaw, abs=radians(0.5))
    assert loop.estimate.pose_covariance[8] < max(
        radians(1.5) ** 2, 1.5 * before.pose_covariance[8])
