# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A goal that needs another mode gives that from before back, however it ends."""

from collections.abc import Callable

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Severity
from create_oi_ros.driver.goals import Code, Dock, Goal, Undock
from create_oi_ros.driver.state import Activity
from create_oi_ros.oi import Mode
from create_oi_ros.sim.world import parse, Pose
from support.asking import ask, in_mode
from support.goals import angle, distance, met, pursue, start, until_ended
from support.loop import Loop, said

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


@pytest.mark.parametrize('running', [leaving, searching])
def test_a_demo_that_takes_over_is_played(running):
    loop, goal = running(Mode.SAFE)
    assert ask(loop, loop.driver.modes.start_demo, oi.DemoNumber.DRIVE_FIGURE_EIGHT).ok
    loop.run(1.0)
    assert goal.code is Code.SUPERSEDED
    assert loop.robot.demo is oi.DemoNumber.DRIVE_FIGURE_EIGHT


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
