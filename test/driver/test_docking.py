# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The Home Base: found, felt, left; robots that Safe holds there, or that do not charge."""

from math import cos, inf, nan, pi, remainder, sin, tau

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Settings
from create_oi_ros.driver.battery import CHARGE_WAIT
from create_oi_ros.driver.goals import Code, Dock, Phase, Undock
from create_oi_ros.driver.state import Activity
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import parse, Pose, shipped
from support.asking import ask
from support.goals import distance, met, pursue, start, until_ended
from support.loop import Loop

BASE = parse('start 0.8 0 180\nhome_base 0 0 0', 'base')
ON_BASE = Pose(0.1655, 0.0, pi)


def docked(guesses: Guesses | None = None, mode: oi.Mode = oi.Mode.PASSIVE) -> Loop:
    """Return a robot on a Home Base and its driver."""
    loop = met(world=BASE)
    loop.robot.guesses = guesses or Guesses()
    loop.body.place(ON_BASE)
    loop.run(0.1)
    assert loop.driver.modes.set(mode, loop.now) and loop.body.sense().home_base
    loop.run(0.3)
    return loop


def said(loop: Loop) -> str:
    """Return all notices."""
    return '\n'.join(notice.text for notice in loop.notices)


def test_the_dock_is_found_and_the_battery_charges():
    loop = met(world=BASE)
    running, phases, beams = start(loop, Dock(0.0)), [], set()
    while running.outcome is None:
        loop.turn()
        beams.add(running.progress.infrared)
        if running.progress.phase not in phases[-1:]:
            phases.append(running.progress.phase)
    assert running.code is Code.NONE
    assert running.docked
    assert 'the battery charges' in running.outcome.text
    assert {Phase.SEES_DOCK, Phase.CHARGING} <= set(phases)
    assert any(beam > 240 for beam in beams)
    assert loop.robot.mode is oi.Mode.PASSIVE
    assert loop.driver.state.activity is Activity.IDLE


def test_a_robot_that_is_docked_is_docked_at_once_even_if_it_is_full():
    loop = docked(mode=oi.Mode.FULL)
    loop.body.set_battery(charge=1.0)
    ending = pursue(loop, Dock(0.0))
    assert (ending.code, ending.docked) == (Code.NONE, True)
    assert loop.robot.mode is oi.Mode.PASSIVE
    loop.run(2.0)
    again = pursue(loop, Dock(0.0))
    assert again.docked and 'is full' in again.text


def test_without_a_dock_the_search_ends_with_that_reason_and_the_mode_before():
    loop = met(world=shipped('table'))
    ending = pursue(loop, Dock(6.0))
    assert ending.code is Code.NO_DOCK
    assert 'no beam of a Home Base was seen in 6 s' in ending.text
    loop.run(0.3)
    assert loop.robot.demo is None
    assert loop.robot.mode is oi.Mode.SAFE


def test_a_dock_that_is_seen_but_not_reached_is_a_timeout():
    loop = met(world=BASE)
    loop.body.force(home_base=0)
    ending = pursue(loop, Dock(5.0))
    assert ending.code is Code.TIMEOUT
    assert 'the Home Base was seen, but not reached in 5 s' in ending.text


def test_a_velocity_ends_a_search_and_drives_once_the_mode_is_back():
    loop = met(world=BASE)
    running = start(loop, Dock(0.0))
    loop.run(3.0)
    loop.drive(-0.1, 0.0, 1.0)
    assert running.code is Code.SUPERSEDED
    assert loop.body.truth().speed == pytest.approx(-0.1, abs=0.01)
    assert 'not driving' not in said(loop)


@pytest.mark.parametrize(('happens', 'code', 'says'), [
    (lambda loop: loop.driver.stop(loop.now), Code.STOPPED, 'the service stop'),
    (lambda loop: loop.driver.modes.set(oi.Mode.FULL, loop.now), Code.SUPERSEDED, 'another mode'),
    (lambda loop: loop.driver.modes.start_demo(oi.DemoNumber.TAG), Code.SUPERSEDED, 'a demo'),
    (lambda loop: loop.driver.modes.stop_demo(), Code.SUPERSEDED, 'the service stop_demo'),
    (lambda loop: loop.body.lift(True), Code.WHEEL_DROP, 'put the robot on the floor'),
    (lambda loop: setattr(loop, 'forged', {'oi_mode': 9}), Code.MODE,
     'switch the robot off and on')])
def test_what_ends_a_search(happens, code, says):
    loop = met(world=BASE)
    running = start(loop, Dock(0.0))
    loop.run(3.0)
    happens(loop)
    loop.run(0.3)
    assert running.code is code and says in running.outcome.text
    assert loop.robot.demo in (None, oi.DemoNumber.TAG)


def test_a_robot_that_safe_lets_go_leaves_in_safe():
    loop = docked(Guesses(dock_holds_safe=False))
    ending = pursue(loop, Undock(0.0))
    assert (ending.code, ending.docked) == (Code.NONE, False)
    assert loop.body.truth().pose.x == pytest.approx(0.4655, abs=0.01)
    assert loop.robot.mode is oi.Mode.SAFE
    assert 'FULL' not in ending.text + said(loop)


@pytest.mark.parametrize('guesses', [Guesses(dock_holds_safe=True), Guesses(dock_ends_safe=True)])
@pytest.mark.parametrize('mode', [oi.Mode.PASSIVE, oi.Mode.SAFE])
def test_a_robot_that_safe_holds_leaves_by_full_says_so_and_returns_to_safe(guesses, mode):
    loop = docked(guesses, mode)
    running, in_full_off_dock = start(loop, Undock(0.0)), 0.0
    while running.outcome is None:
        loop.turn()
        if loop.robot.mode is oi.Mode.FULL and not loop.body.sense().home_base:
            in_full_off_dock += 0.005
    assert running.code is Code.NONE
    assert 'by FULL, now in SAFE again' in running.outcome.text
    assert 'leaves the dock in FULL, then returns to SAFE' in said(loop)
    assert in_full_off_dock < 0.1
    assert 0.44 < loop.body.truth().pose.x < 0.6, 'it was held while it believed to leave'
    loop.run(0.1)
    assert loop.robot.mode is loop.driver.status.wanted is oi.Mode.SAFE
    assert pursue(loop, distance(-0.1)).code is Code.NONE


def test_a_robot_that_hears_nothing_is_not_undocked():
    loop = docked()
    loop.robot.receive = lambda *_: None
    ending = pursue(loop, Undock(0.0))
    assert (ending.code, ending.docked) == (Code.MODE, True)
    assert 'does not enter FULL' in ending.text


def test_a_robot_that_is_held_on_its_dock_stalls():
    loop = docked()
    loop.body.hold(right=True, left=True)
    ending = pursue(loop, Undock(0.0))
    assert ending.code is Code.STALL
    assert ending.docked


def test_a_bump_ends_the_way_from_the_dock():
    loop = docked(Guesses(dock_holds_safe=False))
    running = start(loop, Undock(0.0))
    loop.run(1.0)
    loop.body.force(bump_left=1)
    loop.run(0.1)
    assert running.code is Code.BUMP
    assert running.outcome.text.startswith('stopped after 0.0')


def test_a_dock_that_presses_the_bumper_again_does_not_end_it():
    """A robot that has just docked still settles when it is told to leave."""
    loop = docked()
    running = start(loop, Undock(0.0))
    loop.run(0.1)
    for pressed in (0, 1):
        loop.body.force(seconds=0.1, bump_left=pressed, bump_right=pressed)
        loop.run(0.1)
    until_ended(loop, running)
    assert running.code is Code.NONE, running.outcome.text


def test_a_command_to_a_docked_robot_is_answered_with_undock():
    for mode, guesses in ((oi.Mode.PASSIVE, Guesses()), (oi.Mode.SAFE, Guesses(
            dock_ends_safe=True))):
        loop = docked(guesses, mode)
        ending = pursue(loop, distance(0.1))
        assert ending.code is Code.MODE
        assert 'send the goal undock, it is on its dock' in ending.text
        loop.drive(0.1, 0.0, 0.3)
        assert 'send the goal undock, it is on its dock' in said(loop)
    pending = loop.driver.modes.set(oi.Mode.SAFE, loop.now)
    loop.run(1.0)
    assert 'send the goal undock' in pending.outcome.text


@pytest.mark.parametrize('state', [oi.ChargingState.NOT_CHARGING, oi.ChargingState.FAULT])
def test_a_robot_that_does_not_charge_is_reported_once_each_time_that_it_docks(state):
    loop = docked(Guesses(dock_charges=False), mode=oi.Mode.SAFE)
    loop.body.force(charging_state=int(state))
    ending = pursue(loop, Dock(0.0))
    assert ending.code is Code.NONE
    assert 'docked, but the battery does not charge' in ending.text
    loop.run(3 * CHARGE_WAIT)
    assert said(loop).count(f'does not charge (state {state.name})') == 1
    assert 'set reset_when_not_charging' in said(loop)
    assert loop.body.sense().current < 0
    loop.body.place(Pose(0.8, 0.0, pi))
    loop.run(1.0)
    loop.body.place(ON_BASE)
    loop.run(2 * CHARGE_WAIT)
    assert said(loop).count(f'does not charge (state {state.name})') == 2


# The odometry goes on from a place that somebody knows: a user's, or the dock's.


PLACE = (2.0, -3.0, 2.5)


def pose(loop: Loop) -> tuple[float, float, float]:
    """Return x, y and yaw of the estimate."""
    return loop.estimate[:3]


def moved_from(loop: Loop, begun: Pose, place: tuple[float, float, float]) -> None:
    """See that the estimate is where its motion, since it truly began, leads from a place."""
    true, turned = loop.body.truth().pose, place[2] - begun.yaw
    dx, dy = true.x - begun.x, true.y - begun.y
    assert pose(loop)[:2] == pytest.approx((
        place[0] + cos(turned) * dx - sin(turned) * dy,
        place[1] + sin(turned) * dx + cos(turned) * dy), abs=0.03)
    assert remainder(pose(loop)[2] - turned - true.yaw, tau) == pytest.approx(0, abs=0.03)


def test_the_odometry_goes_on_from_a_place(loop):
    loop.drive(0.2, 0.7, 1.0)
    begun = loop.body.truth().pose
    answer = ask(loop, loop.driver.reset_pose, *PLACE, seconds=0.02)
    assert answer == (True, 'odom goes on from x 2 m, y -3 m, yaw 2.5 rad')
    moved_from(loop, begun, PLACE)
    assert pursue(loop, distance(0.5)).code is Code.NONE
    moved_from(loop, begun, PLACE)
    assert ask(loop, loop.driver.reset_odometry).ok
    assert pose(loop) == pytest.approx((0, 0, 0), abs=1e-3)


@pytest.mark.parametrize('place', [(nan, 0, 0), (0, inf, 0), (0, 0, nan), (0, 1.1e6, 0)])
def test_an_impossible_place_is_refused(loop, place):
    answer = ask(loop, loop.driver.reset_pose, *place)
    assert not answer.ok
    assert 'allowed: up to 1e+06 m from the origin, and a finite yaw' in answer.text
    assert pose(loop) == (0, 0, 0)


def test_a_robot_that_docks_is_where_its_dock_is():
    loop = met(settings=Settings(dock_pose=PLACE), world=BASE)
    assert pose(loop) == (0, 0, 0)
    assert pursue(loop, Dock(0.0)).docked
    assert pose(loop) == pytest.approx(PLACE, abs=0.02)
    assert [each.text for each in loop.notices].count(
        'on the dock: odom goes on from dock_pose') == 1
    begun = loop.body.truth().pose
    assert pursue(loop, Undock(0.0)).code is Code.NONE
    moved_from(loop, begun, PLACE)


def test_a_robot_that_starts_on_its_dock_is_there():
    loop = Loop(Settings(dock_pose=PLACE), config=DEFAULT_BODY, world=BASE)
    loop.body.place(ON_BASE)
    loop.run(1.0)
    assert pose(loop) == pytest.approx(PLACE, abs=0.01)
