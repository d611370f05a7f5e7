# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How the driver enters modes, and how it comes back to one that the robot left."""

from itertools import pairwise

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings, Severity
from create_oi_ros.driver.mode import CLEAR_TIME, MAX_TRIES, MODE_TIMEOUT, SETTLING_TIME
from support.loop import Loop, texts

TIMEOUT = MotionLimits.timeout


def test_set_mode_does_not_believe_a_frame_from_before_it(loop):
    loop.driver.modes.set(oi.Mode.PASSIVE, loop.now)
    loop.delay = 0.02
    pending = loop.driver.modes.set(oi.Mode.SAFE, loop.now)
    for _ in range(4):
        loop.turn()
    assert pending.outcome is None
    loop.run(0.3)
    assert pending.outcome.ok
    assert loop.robot.mode is oi.Mode.SAFE


NEEDS = 'in SAFE it needs all wheels down, no cliff under it and no charger plugged in'


@pytest.mark.parametrize(('before', 'asked', 'hears', 'said'), [
    (oi.Mode.SAFE, oi.Mode.FULL, True, f'stays in SAFE instead of entering FULL: {NEEDS}'),
    (oi.Mode.FULL, oi.Mode.SAFE, True, f'stays in FULL instead of entering SAFE: {NEEDS}'),
    (oi.Mode.SAFE, oi.Mode.FULL, False, 'does not answer (no robot answers) instead of entering '
     'FULL: check cable and power, the driver keeps trying')])
def test_a_mode_that_a_deaf_robot_does_not_enter_is_given_up_after_its_time(
        loop, before, asked, hears, said):
    loop.driver.modes.set(before, loop.now)
    loop.run(0.2)
    loop.robot.receive = lambda *_: None
    loop.cut = not hears
    pending = loop.driver.modes.set(asked, loop.now)
    loop.run(MODE_TIMEOUT - 0.01)
    assert pending.outcome is None
    loop.run(0.02)
    assert pending.outcome == (False, f'robot {said}')


@pytest.mark.parametrize(('hazard', 'cause'), [
    ({'cliff_left': 1}, 'cliff left'), ({'cliff_front_left': 1}, 'cliff front left'),
    ({'cliff_front_right': 1}, 'cliff front right'), ({'cliff_right': 1}, 'cliff right'),
    ({'bumps_and_wheel_drops': 3 + 8}, 'left wheel dropped'),
    ({'bumps_and_wheel_drops': 3 + 4}, 'right wheel dropped'),
    ({'bumps_and_wheel_drops': 3 + 16}, 'caster dropped'),
    ({'charging_sources': 1}, 'charger powered'), ({'charging_sources': 2}, 'charger powered'),
    ({}, 'unknown cause'), ({'oi_mode': 0}, 'robot was switched off')])
def test_why_the_mode_was_left_is_said_once(loop, hazard, cause):
    loop.run(SETTLING_TIME)
    loop.forged = {'oi_mode': 1, **hazard}
    loop.run(1.0)
    status = loop.driver.status
    assert (status.actual, status.reason, status.can_drive) == (
        oi.Mode(loop.forged['oi_mode']), cause, False)
    said = [text for text in texts(loop.notices, Severity.WARNING) if 'robot left SAFE' in text]
    assert len(said) == 1 and said[0].endswith(f': {cause}')


def test_a_mode_that_seems_left_soon_after_it_was_entered_is_only_entered_again(loop):
    loop.forged = {'oi_mode': 1}
    loop.run(1.0)
    assert loop.commands().count(oi.Safe()) == MAX_TRIES - 1
    assert not texts(loop.notices, Severity.WARNING)


def test_a_mode_that_the_robot_misses_is_asked_for_three_times(loop):
    loop.driver.modes.set(oi.Mode.PASSIVE, loop.now)
    loop.run(1.0)
    loop.robot.receive, asked = lambda *_: None, []
    loop.driver.modes.set(oi.Mode.SAFE, loop.now)
    for _ in range(200):
        loop.turn()
        asked += [loop.now] * loop.commands().count(oi.Safe())
    assert len(asked) == MAX_TRIES == 3
    assert [b - a for a, b in pairwise(asked)] == pytest.approx([0.2, 0.2], abs=2 * oi.SLOT)


@pytest.mark.parametrize(('wanted', 'actual', 'undone'), [
    (oi.Mode.SAFE, oi.Mode.FULL, True), (oi.Mode.FULL, oi.Mode.SAFE, True),
    (oi.Mode.PASSIVE, oi.Mode.SAFE, False), (oi.Mode.SAFE, oi.Mode.PASSIVE, False)])
def test_full_for_safe_is_no_safety_stop_and_is_always_undone(loop, wanted, actual, undone):
    command = {oi.Mode.SAFE: oi.Safe(), oi.Mode.FULL: oi.Full(), oi.Mode.PASSIVE: oi.Start()}
    loop.driver.modes.set(wanted, loop.now)
    loop.run(SETTLING_TIME + 0.1)
    loop.commands()
    loop.forged = {'oi_mode': int(actual)}
    loop.run(2.0)
    sent = loop.commands().count(command[wanted])
    assert sent > 2 * MAX_TRIES if undone else not sent


@pytest.mark.parametrize(('recovers', 'gone', 'comes_back'), [
    (True, CLEAR_TIME + 0.1, True), (True, 0.0, False), (False, CLEAR_TIME + 0.1, False)])
def test_a_fresh_command_brings_the_mode_back_when_the_cause_has_been_gone_for_a_second(
        recovers, gone, comes_back):
    loop = Loop(Settings(recover_mode=recovers))
    loop.run(0.3)
    loop.body.drop(left=True)
    loop.run(TIMEOUT + 0.2)
    loop.body.drop()
    loop.run(gone)
    loop.drive(0.2, 0.0, CLEAR_TIME - 0.2)
    assert (loop.robot.mode is oi.Mode.SAFE) is comes_back
    assert (loop.body.truth().speed > 0.1) is comes_back


def test_the_mode_command_is_sent_once_however_often_the_robot_is_told_to_drive(loop):
    loop.body.drop(left=True)
    loop.run(0.2)
    loop.body.drop()
    loop.run(CLEAR_TIME + TIMEOUT + 0.1)
    loop.commands()
    for _ in range(3):
        loop.driver.drive(0.2, 0.0, loop.now)
    loop.run(0.1)
    assert [type(command) for command in loop.commands()].count(oi.Safe) == 1


def test_a_robot_put_down_under_a_stream_of_commands_does_not_leap(loop):
    loop.drive(0.2, 0.0, 0.5)
    loop.body.drop(left=True, right=True, caster=True)
    loop.drive(0.2, 0.0, 1.0)
    loop.body.drop()
    loop.drive(0.2, 0.0, 5.0)
    assert loop.robot.mode is oi.Mode.PASSIVE
    assert loop.body.truth().speed == 0
    said = texts(loop.notices, Severity.WARNING)
    assert len([text for text in said if text.startswith('not driving')]) == 1


def test_commands_that_were_zero_count_as_a_pause(loop):
    loop.body.drop(left=True)
    loop.drive(0.2, 0.0, 0.3)
    loop.body.drop()
    loop.drive(0.2, 0.0, CLEAR_TIME + 0.2)
    loop.drive(0.0, 0.0, 0.1)
    loop.drive(0.2, 0.0, 1.0)
    assert loop.robot.mode is oi.Mode.SAFE


def test_the_mode_never_comes_back_while_a_charger_is_powered(loop):
    loop.body.plug_charger(True)
    loop.run(CLEAR_TIME + TIMEOUT + 1)
    loop.drive(0.2, 0.0, 3.0)
    assert loop.robot.mode is oi.Mode.PASSIVE


# What is sent, byte for byte, and said.


LEDS = oi.Leds(bits=oi.LedBits(0), color=7, intensity=8)


@pytest.mark.parametrize(('mode', 'sent'), [
    (oi.Mode.FULL, [oi.Full(), LEDS]),
    (oi.Mode.PASSIVE, [oi.Start()])])
def test_leds_are_set_again_in_a_mode_that_has_them_and_only_there(loop, mode, sent):
    loop.driver.outputs.set_leds(LEDS)
    loop.run(0.1)
    loop.commands()
    loop.driver.modes.set(mode, loop.now)
    loop.run(0.2)
    assert [each for each in loop.commands()
            if not isinstance(each, oi.DriveDirect | oi.Stream)] == sent


@pytest.mark.parametrize(('leave', 'ends'), [
    (lambda loop: loop.robot.receive(oi.Start().encode(), loop.now), True),
    (lambda loop: loop.body.drop(left=True), False)])
def test_a_demo_is_ended_only_where_nothing_else_can_have_changed_the_mode(loop, leave, ends):
    loop.run(SETTLING_TIME)
    loop.commands()
    leave(loop)
    loop.run(0.1)
    assert loop.driver.status.actual is oi.Mode.PASSIVE
    ended = oi.Demo(demo=oi.DemoNumber.ABORT) in loop.commands()
    assert ended is ends


@pytest.mark.parametrize(('hazard', 'why'), [
    ({'internal_charger': 1}, "(charger powered); pull the charger's plug, let commands pause and "
                              'send again'),
    ({'cliff_left': 1}, '(cliff left); let commands pause and send again, or call set_mode with '
                        'SAFE')])
def test_a_refused_velocity_says_how_to_drive_again(loop, hazard, why):
    loop.body.force(**hazard)
    loop.drive(0.1, 0.0, 0.5)
    last = texts(loop.notices, Severity.WARNING)[-1]
    assert last == f'not driving: robot is in PASSIVE {why}'
