# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals that do not reach their end: each code, what it says, and that the wheels stand then."""

from math import inf, nan
from re import fullmatch

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import (
    LowBatteryAction,
    MotionLimits,
    Settings,
    Severity,
)
from create_oi_ros.driver.goal_control import CLIENT_GONE, COMMANDED, MODE_WAIT
from create_oi_ros.driver.goals import Code, Dock, Undock
from support.goals import (
    angle,
    arc,
    distance,
    ended,
    FRAME,
    met,
    moving,
    place,
    pursue,
    reach,
    start,
    until_ended,
)
from support.loop import Loop, said, STEP

loop = pytest.fixture(met)
"""A robot and a driver that have met."""
running = pytest.fixture(moving)
"""A goal of this robot, which moves."""

# What an ending says.


@pytest.mark.parametrize(('make', 'says'), [
    (lambda: distance(3.0), r'after 0\.[1-3]\d m'),
    (lambda: distance(-3.0), r'after 0\.[1-3]\d m'),
    (lambda: angle(900), r'after [2-9]\d degrees'),
    (lambda: angle(-900), r'after [2-9]\d degrees'),
    (lambda: arc(-200, 0.5), r'after [1-3]\d degrees'),
    (lambda: place(3.0, 0.0), r'2\.[6-9]\d m from the goal')])
def test_an_ending_says_how_far_the_robot_has_got(loop, make, says):
    running = moving(loop, make())
    loop.driver.goals.cancel(running, loop.now)
    assert fullmatch(f'stopped {says}; canceled', running.outcome.text)


def test_a_goal_that_moves_on_or_never_moved_is_not_said_to_have_stopped(loop):
    first, second = moving(loop), moving(loop)
    assert first.outcome.text.startswith('ended after 0.')
    assert 'wait for the first result' in first.outcome.text
    loop.driver.drive(0.1, 0.0, loop.now)
    assert second.outcome.text.startswith('ended after 0.')
    assert 'cmd_vel_interrupts' in second.outcome.text
    loop.body.force(bump_left=1)
    loop.run(0.1)
    assert pursue(loop, distance(0.1)).text.startswith('not started; the bumper is pressed')
    loop.cut = True
    loop.run(2.0)
    assert pursue(loop, distance(0.1)).text.startswith('not started; no answer yet')


# What the robot is.


GOALS = {
    'drive_distance': lambda: distance(0.03), 'rotate_angle': lambda: angle(10),
    'drive_arc': lambda: arc(10, 0.2), 'navigate_to_position': lambda: place(0.03, 0.0),
    'dock': lambda: Dock(1.0), 'undock': lambda: Undock(0.0)}


@pytest.mark.parametrize('make', GOALS.values(), ids=GOALS)
@pytest.mark.parametrize('mode', [oi.Mode.OFF, oi.Mode.PASSIVE, oi.Mode.SAFE, oi.Mode.FULL])
def test_every_goal_ends_in_every_mode(mode, make):
    loop, goal = met(), make()
    if mode is oi.Mode.OFF:
        loop.robot.power(False, loop.now)
        loop.run(2.0)
    else:
        loop.driver.modes.set(mode, loop.now)
        loop.run(0.2)
    if mode is oi.Mode.OFF:
        expected = Code.NO_ROBOT
    elif isinstance(goal, (Dock, Undock)):
        expected = Code.NO_DOCK
    else:
        expected = Code.MODE if mode is oi.Mode.PASSIVE else Code.NONE
    assert pursue(loop, goal).code is expected
    loop.run(0.5)
    assert loop.robot.mode is mode
    assert loop.robot.actuators.wheels == (0, 0)


def test_full_instead_of_safe_changes_nothing(loop):
    running = moving(loop, distance(0.5))
    loop.driver.modes.set(oi.Mode.FULL, loop.now)
    assert until_ended(loop, running).code is Code.NONE


def test_a_charger_ends_a_motion_with_the_reason(loop, running):
    loop.body.plug_charger(True)
    ending = ended(loop, running)
    assert ending.code is Code.MODE
    assert 'charger' in ending.text
    loop.run(2.0)
    again = pursue(loop, distance(0.1))
    assert again.code is Code.MODE
    assert "pull the charger's plug" in again.text


def test_a_goal_brings_back_the_mode_once_the_hazard_has_gone(loop, running):
    loop.body.force(seconds=0.5, cliff_left=1)
    assert ended(loop, running).code is Code.CLIFF
    assert loop.robot.mode is oi.Mode.PASSIVE
    loop.run(2.0)
    assert pursue(loop, distance(0.1)).code is Code.NONE
    assert loop.robot.mode is oi.Mode.SAFE


def test_a_demo_keeps_goals_away_and_takes_over_from_one(loop, running):
    loop.driver.modes.start_demo(oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    assert running.outcome is not None
    assert running.code is Code.SUPERSEDED
    loop.run(0.5)
    ending = pursue(loop, distance(0.1))
    assert ending.code is Code.MODE
    assert 'stop_demo' in ending.text


def test_a_script_keeps_goals_away(loop):
    loop.driver.scripts.define(oi.Script(script=oi.WaitTime(time=20).encode()))
    loop.driver.scripts.play(loop.now, force=False)
    ending = pursue(loop, distance(0.1))
    assert ending.code is Code.MODE
    assert 'a script plays' in ending.text


@pytest.mark.parametrize(('happens', 'says'), [
    (lambda loop: setattr(loop, 'cut', True), 'the robot no longer answers'),
    (lambda loop: loop.driver.disconnected('cable pulled'), 'the port is gone'),
    (lambda loop: loop.driver.shut_down(loop.now), 'the driver ends')])
def test_a_robot_port_or_driver_that_is_gone_ends_a_goal(loop, running, happens, says):
    happens(loop)
    ending = until_ended(loop, running)
    assert ending.code is Code.LINK and says in ending.text


# When it begins, and for how long.


def test_a_goal_ends_when_its_time_is_over_and_not_before(loop):
    running = start(loop, distance(9.0, allowance=0.5))
    loop.run(0.5 - STEP)
    assert running.outcome is None
    loop.run(2 * FRAME)
    assert running.code is Code.TIMEOUT
    assert 'time_allowance of 0.5 s is over' in running.outcome.text
    assert loop.robot.actuators.wheels == (0, 0)


def in_passive_by_another() -> Loop:
    """Return a robot that another program has put into Passive; a goal would bring Safe back."""
    loop = met()
    loop.run(2.0)
    loop.robot.receive(oi.Start().encode(), loop.now)
    loop.run(1.5)
    return loop


def test_a_goal_waits_for_its_mode_and_then_has_all_its_time():
    loop = in_passive_by_another()
    hear, loop.robot.receive = loop.robot.receive, lambda *_: None
    running = start(loop, distance(9.0, allowance=0.5))
    loop.run(0.3)
    loop.robot.receive = hear
    hear(oi.Safe().encode(), loop.now)  # only now the robot takes what it was sent
    loop.run(0.45)
    assert running.outcome is None
    loop.run(0.5)
    assert running.code is Code.TIMEOUT


@pytest.mark.parametrize('delay', [0.01, 0.03, 0.1])
def test_a_goal_at_once_after_modes_were_set_waits_for_the_last_of_them(delay):
    loop = met(delay=delay)
    for mode in oi.Mode.PASSIVE, oi.Mode.SAFE:
        loop.driver.modes.set(mode, loop.now)
    assert reach(loop, distance(0.2))[0] == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize('wait', [0.0, 0.02, 0.06])
def test_a_goal_at_once_after_a_gap_waits_until_the_mode_is_entered_again(wait):
    loop = met(delay=0.1)
    loop.lose_line(3.0)
    while not loop.driver.state.answered:
        loop.turn()
    loop.run(wait)
    assert reach(loop, distance(0.2))[0] == pytest.approx(0.2, abs=0.01)


def test_a_goal_whose_mode_does_not_come_is_given_up():
    loop = in_passive_by_another()
    loop.robot.receive = lambda *_: None
    running = start(loop, distance(9.0))
    loop.run(MODE_WAIT - 0.01)
    assert running.outcome is None
    loop.run(0.03)
    assert running.code is Code.MODE
    assert running.outcome.text.startswith('not started; robot is in PASSIVE')


# Who else gives orders.


def test_time_that_the_driver_chose_is_said_to_be_twice_what_it_should_take():
    loop, goal = met(), distance(1.0)
    running = moving(loop, goal)
    goal.allowance = 1.5
    ending = ended(loop, running, within=0.6)
    assert ending.code is Code.TIMEOUT
    assert '1.5 s are over, twice what it should take' in ending.text


def test_an_empty_battery_ends_a_goal_with_that_reason():
    loop = met(settings=Settings(low_battery_action=LowBatteryAction.STOP))
    running = moving(loop, distance(9.0))
    loop.body.force(voltage=11000)
    ending = until_ended(loop, running)
    assert ending.code is Code.STOPPED
    assert 'the battery is nearly empty (low_battery_action): charge it' in ending.text


@pytest.mark.parametrize(('action', 'does'), [
    (LowBatteryAction.DOCK, 'looks for its dock'),
    (LowBatteryAction.STOP, 'stops and stays in Passive')])
def test_what_an_empty_battery_asks_for_is_done_as_soon_as_the_robot_takes_it(
        action, does, monkeypatch):
    loop = met(settings=Settings(low_battery_action=action))
    monkeypatch.setattr(loop.driver.core, 'refusal', lambda _: 'not now')
    loop.body.force(voltage=11000)
    loop.run(12.0)
    assert said(loop, Severity.ERROR, 'as soon as it can (not now)') == 1
    assert said(loop, Severity.ERROR, 'as low_battery_action says') == 0
    monkeypatch.undo()
    loop.run(4.0)
    assert said(loop, Severity.ERROR, f'the robot {does}, as low_battery_action says') == 1
    assert loop.robot.mode is loop.driver.status.wanted is oi.Mode.PASSIVE
    assert (loop.robot.demo is oi.DemoNumber.COVER_AND_DOCK) is (action is LowBatteryAction.DOCK)


def test_a_goal_ends_when_the_robot_does_not_enter_another_mode_to_drive_in(loop, running):
    loop.driver.modes.set(oi.Mode.FULL, loop.now)
    loop.forged = {'oi_mode': int(oi.Mode.PASSIVE)}
    assert ended(loop, running, within=0.2).code is Code.MODE


def test_what_comes_after_the_end_changes_nothing(loop, running):
    loop.driver.goals.cancel(running, loop.now)
    before, second = running.outcome, moving(loop)
    loop.driver.goals.cancel(running, loop.now, CLIENT_GONE)
    assert running.outcome is before and second.outcome is None
    loop.driver.goals.cancel(second, loop.now, CLIENT_GONE)
    assert second.code is Code.STOPPED and 'its client has gone' in second.outcome.text
    before = second.outcome
    loop.driver.goals.finish(COMMANDED, loop.now)
    loop.driver.shut_down(loop.now)
    assert second.outcome is before and second.code is Code.STOPPED


def test_a_stop_always_wins():
    for interrupt in (True, False):
        loop = met(MotionLimits(commands_interrupt=interrupt))
        running = moving(loop)
        loop.driver.stop(loop.now)
        assert ended(loop, running, within=0.0).code is Code.STOPPED


@pytest.mark.parametrize('velocity', [(nan, 0.0), (0.2, nan), (inf, 0.0)])
def test_a_velocity_that_is_not_finite_changes_nothing_while_a_goal_runs(loop, velocity):
    running = start(loop, distance(0.3))
    loop.run(0.3)
    loop.driver.drive(*velocity, loop.now)
    loop.run(FRAME)
    assert said(loop, Severity.WARNING, 'is not finite: ignored, since a goal runs') == 1
    assert until_ended(loop, running).code is Code.NONE


def test_the_odometry_is_not_reset_while_a_goal_needs_it(loop, running):
    answer = loop.driver.reset_odometry().outcome
    assert not answer.ok and 'cancel it first' in answer.text
    loop.driver.goals.cancel(running, loop.now)
    assert loop.driver.reset_odometry().outcome.ok
