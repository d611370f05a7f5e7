# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How the driver enters modes, and comes back to one that the robot or a goal left."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings, Severity
from create_oi_ros.driver.events import Cause
from create_oi_ros.driver.goals import Code, Dock, Goal, Undock
from create_oi_ros.driver.mode import CLEAR_TIME, MAX_TRIES, MODE_TIMEOUT, SETTLING_TIME
from create_oi_ros.driver.state import Activity
from create_oi_ros.oi import Mode
from create_oi_ros.sim.world import parse, Pose
from support.asking import ask, in_mode
from support.goals import angle, distance, met, pursue, start, until_ended
from support.loop import Loop, said, texts

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


# A goal that needs another mode gives that from before back, however it ends.


BASE = parse('start 0.8 0 180\nhome_base 0 0 0', 'base')
ON_BASE = Pose(0.1655, 0.0, 3.14159)


def leaving(before: Mode) -> tuple[Loop, Goal]:
    """Return a robot that leaves its dock in Full, though it was in another mode."""
    loop = met(world=BASE)
    loop.body.place(ON_BASE)
    in_mode(loop, before)
    loop.run(2.5)
    goal = start(loop, Undock(0.0))
    while not (loop.robot.mode is Mode.FULL and any(loop.robot.actuators.wheels)):
        loop.turn()
    loop.run(0.3)
    return loop, goal


def searching(before: Mode) -> tuple[Loop, Goal]:
    """Return a robot that looks for its dock in Passive, though it was in another mode."""
    loop = met(world=BASE)
    in_mode(loop, before)
    loop.run(2.5)
    goal = start(loop, Dock(0.0))
    loop.run(2.7)
    assert loop.robot.demo is oi.DemoNumber.COVER_AND_DOCK and loop.robot.mode is Mode.PASSIVE
    return loop, goal


WAYS: dict[str, Callable[[Loop, Goal], object]] = {
    'cancel': lambda loop, goal: loop.driver.goals.cancel(goal, loop.now),
    'stop': lambda loop, goal: loop.driver.stop(loop.now),
    'velocity': lambda loop, goal: loop.driver.drive(-0.05, 0.0, loop.now),
    'another goal': lambda loop, goal: start(loop, angle(15)),
    'lifted': lambda loop, goal: (loop.body.lift(True), loop.run(0.4), loop.body.lift(False)),
    'held': lambda loop, goal: (loop.body.hold(right=True, left=True), loop.run(9.0),
                                loop.body.hold()),
    'port lost': lambda loop, goal: loop.lose_port(0.7),
    'line lost': lambda loop, goal: loop.lose_line(1.4),
    'standstill': lambda loop, goal: loop.stand_still(1.7)}


@pytest.mark.parametrize('way', WAYS)
@pytest.mark.parametrize('before', [Mode.PASSIVE, Mode.SAFE])
def test_an_undock_that_does_not_succeed_gives_the_mode_back(way, before):
    loop, goal = leaving(before)
    second = WAYS[way](loop, goal)
    loop.run(3.0)
    if isinstance(second, Goal) and before is Mode.PASSIVE:  # it could not run
        assert second.code is Code.MODE and until_ended(loop, goal).code is Code.NONE
        return
    assert goal.outcome is not None and not goal.outcome.ok
    assert loop.driver.status.wanted is before
    assert loop.robot.mode is (Mode.PASSIVE if way == 'lifted' else before)


@pytest.mark.parametrize('way', [way for way in WAYS if way != 'held'])
@pytest.mark.parametrize('before', [Mode.PASSIVE, Mode.SAFE, Mode.FULL])
def test_a_dock_that_does_not_succeed_gives_the_mode_back(way, before):
    loop, goal = searching(before)
    second = WAYS[way](loop, goal)
    loop.run(3.0)
    if isinstance(second, Goal) and before is Mode.PASSIVE:  # it could not run
        assert second.code is Code.MODE and loop.driver.state.pursues
        return
    assert goal.outcome is not None and not goal.outcome.ok
    assert loop.driver.status.wanted is before
    assert loop.robot.demo is None
    assert loop.robot.mode in (before, *[Mode.PASSIVE] * (way == 'lifted'))


# What somebody asked for later stays.


@pytest.mark.parametrize('mode', [Mode.PASSIVE, Mode.SAFE, Mode.FULL])
@pytest.mark.parametrize('running', [leaving, searching])
def test_a_mode_that_is_set_meanwhile_stays_when_the_goal_has_ended(running, mode):
    loop, goal = running(Mode.SAFE)
    assert ask(loop, loop.driver.modes.set, mode, loop.now, seconds=0.3).ok
    loop.driver.goals.cancel(goal, loop.now)
    loop.run(1.0)
    assert goal.outcome is not None
    assert loop.robot.mode is loop.driver.status.wanted is mode


def test_a_velocity_that_ends_a_goal_from_passive_is_refused_with_what_to_do():
    loop, goal = searching(Mode.PASSIVE)
    loop.drive(0.2, 0.0, 0.6)
    assert goal.code is Code.SUPERSEDED and loop.robot.demo is None
    assert said(loop, Severity.WARNING, 'not driving: robot is in PASSIVE; call set_mode') == 1
    assert loop.robot.mode is Mode.PASSIVE


def test_a_hazard_that_ended_the_mode_is_not_overruled():
    loop = met(world=BASE)
    loop.body.place(ON_BASE)
    in_mode(loop, Mode.SAFE)
    loop.robot.guesses = loop.robot.guesses.__class__(dock_holds_safe=False)
    loop.run(2.5)
    goal = start(loop, Undock(0.0))
    loop.run(1.0)
    loop.commands()
    loop.body.drop(left=True)
    loop.run(0.1)
    assert goal.outcome is not None and not goal.outcome.ok
    loop.run(2.0)
    assert loop.robot.mode is Mode.PASSIVE and loop.driver.status.wanted is Mode.SAFE
    assert loop.commands().count(oi.Safe()) <= 1


# A robot that a hazard took out of its mode before the goal began.


def carried(**settings: object) -> Loop:
    """Return a robot that was lifted out of Safe, and stands where it was."""
    loop = met(world=BASE, settings=Settings(**settings))
    loop.body.lift(True)
    loop.run(0.4)
    loop.body.lift(False)
    loop.run(1.2)
    assert loop.robot.mode is Mode.PASSIVE and loop.driver.status.wanted is Mode.SAFE
    return loop


@pytest.mark.parametrize('gap', [Loop.lose_line, Loop.lose_port, Loop.stand_still])
def test_a_robot_that_was_carried_to_its_dock_charges_on_after_a_gap(gap):
    loop = carried()
    loop.body.place(ON_BASE)
    loop.run(0.5)
    assert pursue(loop, Dock(0.0)).text == 'docked; the battery charges'
    assert loop.driver.status.wanted is Mode.PASSIVE
    gap(loop, 6.0)
    loop.run(3.0)
    assert loop.robot.mode is Mode.PASSIVE


@pytest.mark.parametrize('way', ['cancel', 'stop', 'velocity'])
def test_a_search_for_the_dock_brings_back_no_mode_that_a_hazard_had_ended(way):
    loop = carried(recover_mode=False)
    goal = start(loop, Dock(0.0))
    loop.run(3.0)
    loop.commands()
    WAYS[way](loop, goal)
    loop.run(2.0)
    assert goal.outcome is not None and loop.robot.demo is None
    assert loop.robot.mode is Mode.PASSIVE and oi.Safe() not in loop.commands()
    assert loop.driver.status.wanted is Mode.SAFE
    assert Cause.WHEEL_DROP_LEFT in loop.driver.status.causes


def test_a_velocity_after_a_search_that_a_hazard_came_before_enters_safe_again():
    loop = carried()
    loop.driver.goals.cancel(start(loop, Dock(0.0)), loop.now)
    loop.run(0.5)
    loop.drive(-0.1, 0.0, 1.0)
    assert loop.robot.mode is Mode.SAFE and loop.robot.actuators.wheels == (-100, -100)


# What is refused changes nothing.


def test_a_goal_that_cannot_begin_ends_no_other_goal():
    loop = met()
    loop.body.force(bump_right=1)
    loop.run(0.1)
    goal = start(loop, distance(-0.4))
    loop.run(0.5)
    assert pursue(loop, Undock(0.0)).code is Code.NO_DOCK
    assert pursue(loop, distance(0.2)).code is Code.BUMP
    assert until_ended(loop, goal).code is Code.NONE


def test_a_script_ends_no_search_for_the_dock():
    loop, goal = searching(Mode.SAFE)
    assert ask(loop, loop.driver.scripts.define, oi.Script(script=oi.WaitTime(time=3).encode())).ok
    refused = loop.driver.scripts.play(loop.now, force=False)
    assert 'cancel it' in refused.outcome.text
    assert until_ended(loop, goal).docked


# A mode that is set while a dock goal waits for its pause.


@pytest.mark.parametrize('mode', [Mode.SAFE, Mode.FULL, Mode.PASSIVE])
@pytest.mark.parametrize('after', [0.0, 0.02, 0.7])
@pytest.mark.parametrize('delay', [0.0, 0.04])
def test_a_mode_does_not_wait_for_the_pause_of_a_search_that_it_calls_off(mode, after, delay):
    loop = met(world=BASE, delay=delay)
    loop.run(2.0)
    start(loop, Dock(0.0))
    while loop.driver.state.activity is not Activity.DOCKING:
        loop.turn()
    loop.run(after)
    loop.commands()
    asked = loop.driver.modes.set(mode, loop.now)
    loop.run(0.25)
    assert asked.outcome is not None and asked.outcome.ok, asked.outcome
    loop.run(2.0)
    assert loop.robot.demo is None and loop.robot.mode is mode
    sent = [each for each in loop.commands() if each.enters is not None]
    assert len(sent) <= 2 and not any(isinstance(each, oi.Demo) for each in sent)
