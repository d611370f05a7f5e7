# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The battery and the Home Base: how full, how it charges; found, felt, left."""

from dataclasses import replace
from math import cos, inf, nan, pi, remainder, sin, tau
from re import fullmatch

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import BatteryLevel, Charging, LowBatteryAction, Settings, Severity
from create_oi_ros.driver.battery import CHARGE_WAIT, charging, LEVEL_DELAY
from create_oi_ros.driver.goals import Code, Dock, Phase, Undock
from create_oi_ros.driver.state import Activity
from create_oi_ros.oi import ChargingState, Mode
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import parse, Pose, shipped
from support.asking import ask
from support.goals import distance, met, pursue, start, until_ended
from support.loop import Loop, said, texts

FINE, LOW, EMPTY = BatteryLevel


def test_a_level_is_reached_after_five_seconds_and_left_above_its_limit_and_a_bit():
    loop = Loop(Settings(battery_low=13.5, battery_empty=12.5))
    for millivolts, seconds, level in (
            (13500, LEVEL_DELAY - 1.0, FINE), (14000, 1.5, FINE), (13500, LEVEL_DELAY - 1.0, FINE),
            (13500, 2.0, LOW), (12500, LEVEL_DELAY - 1.0, LOW), (12500, 2.0, EMPTY),
            (12800, 1.5, EMPTY), (12801, 1.5, LOW), (13800, 1.5, LOW), (13801, 1.5, FINE)):
        loop.body.force(voltage=millivolts)
        loop.run(seconds)
        assert loop.driver.health(loop.now).battery is level, (millivolts, seconds)
    assert texts(loop.notices, Severity.WARNING) == [
        'battery low (13.5 V, charge 90%): charge it',
        'battery nearly empty (12.5 V, charge 90%): charge it']
    assert loop.robot.mode is oi.Mode.SAFE, 'nothing is done unasked'
    loop.forged = {'voltage': 65535}
    loop.run(2 * LEVEL_DELAY)
    assert loop.driver.health(loop.now).battery is FINE, 'it is not known'


# What a charger does, by all that is known.


@pytest.mark.parametrize(('state', 'current', 'charge', 'does'), [
    (4, -250, 80, Charging.FAILS), (4, -250, 2300, Charging.FAILS), (4, -250, 2500, Charging.FULL),
    (4, 0, 2700, Charging.FULL), (4, None, 2600, Charging.FULL), (4, None, 500, Charging.FAILS),
    (2, 1250, 80, Charging.CHARGES), (1, 250, 80, Charging.CHARGES), (3, 50, 2700, Charging.FULL),
    (3, 50, 1000, Charging.CHARGES), (2, -200, 1000, Charging.FAILS),
    (0, -200, 2600, Charging.FAILS), (0, 900, 1000, Charging.CHARGES),
    (5, 900, 1000, Charging.FAILS), (None, 900, 10, Charging.CHARGES),
    (None, -20, 2700, Charging.FAILS), (2, None, 10, Charging.CHARGES),
    (None, None, 10, Charging.UNKNOWN), (4, -250, None, Charging.FAILS)])
def test_what_a_charger_does(state, current, charge, does):
    values = {'charging_sources': 2, 'battery_capacity': 2700}
    given = {'charging_state': state, 'current': current, 'battery_charge': charge}
    unknown = [name for name, value in given.items() if value is None]
    seen = oi.Readings(values | {name: value or 0 for name, value in given.items()})
    assert charging(seen.corrected(unknown)) is does
    apart = oi.Readings({**values, 'charging_sources': 0})
    assert charging(apart) is Charging.NO_CHARGER


def on_dock(seconds: float = 1.0, **settings) -> Loop:
    """Return a robot that stood on its dock when its driver started."""
    world = parse('start 0.1655 0 180\nhome_base 0 0 0', 'base')
    loop = Loop(Settings(**settings), config=DEFAULT_BODY, world=world)
    loop.run(seconds)
    assert loop.body.sense().home_base
    return loop


@pytest.mark.parametrize(('charge', 'level'), [
    (0.03, BatteryLevel.EMPTY), (0.12, BatteryLevel.LOW), (0.5, BatteryLevel.FINE)])
def test_a_robot_whose_charger_waits_is_as_empty_as_elsewhere(charge, level):
    loop = on_dock(mode_on_start=Mode.PASSIVE)
    loop.body.set_battery(charge=charge, waits=True)
    loop.run(2 * LEVEL_DELAY + 2)
    assert loop.body.sense().charging_state == ChargingState.WAITING
    assert loop.body.sense().current < 0
    health = loop.driver.health(loop.now)
    assert (health.battery, health.charging) == (level, Charging.FAILS)
    ending = pursue(loop, Dock(0.0))
    assert ending.code is Code.NONE
    assert ending.text == 'docked, but the battery does not charge: see the log'
    assert said(loop, Severity.WARNING, 'does not charge (state WAITING): clean the contacts') == 1


@pytest.mark.parametrize('helps', [True, False])
def test_a_robot_whose_charger_waits_is_restarted_once_if_it_may_be(helps):
    loop = on_dock(mode_on_start=Mode.PASSIVE, reset_when_not_charging=True)
    loop.body.set_battery(charge=0.4, waits=True)
    loop.run(CHARGE_WAIT + 1)
    assert said(loop, Severity.WARNING, 'restarting it (opcode 7)') == 1
    loop.body.set_battery(waits=not helps)
    loop.run(25.0)
    assert said(loop, Severity.WARNING, 'restarting it (opcode 7)') == 1
    assert said(loop, Severity.WARNING, 'even after a restart') == (not helps)
    assert (loop.body.sense().current > 0) is helps


def test_a_robot_that_is_full_is_said_to_be_and_not_restarted():
    loop = on_dock(mode_on_start=Mode.PASSIVE, reset_when_not_charging=True)
    loop.body.set_battery(charge=0.95, waits=True)
    loop.run(3 * CHARGE_WAIT)
    assert not texts(loop.notices, Severity.WARNING)
    assert pursue(loop, Dock(0.0)).text == 'docked; the battery is full'


@pytest.mark.parametrize('mode', [Mode.SAFE, Mode.FULL])
def test_a_docked_robot_that_its_mode_keeps_from_charging_is_told_of_once(mode):
    loop = on_dock(mode_on_start=mode)
    loop.run(60.0)
    warned = texts(loop.notices, Severity.WARNING)
    assert len(warned) == 1 and fullmatch(
        r'the robot is on its dock and does not charge \(state NOT_CHARGING\), for it is in '
        f'{mode.name}: call set_mode with PASSIVE', warned[0])
    loop.driver.modes.set(Mode.PASSIVE, loop.now)
    loop.run(10.0)
    assert loop.body.sense().current > 0
    assert len(texts(loop.notices, Severity.WARNING)) == 1


@pytest.mark.parametrize('action', [LowBatteryAction.DOCK, LowBatteryAction.STOP])
def test_an_empty_robot_that_its_mode_keeps_from_charging_enters_passive(action):
    loop = on_dock(low_battery_action=action)
    loop.body.set_battery(charge=0.04)
    loop.run(3 * LEVEL_DELAY)
    assert said(loop, Severity.ERROR, 'the robot enters Passive on its dock, as low_battery') == 1
    assert loop.robot.mode is loop.driver.status.wanted is Mode.PASSIVE and not loop.robot.demo
    assert loop.body.sense().current > 0
    assert loop.driver.health(loop.now).battery is BatteryLevel.FINE


def test_an_undock_of_a_robot_that_does_not_charge_is_no_warning():
    loop = on_dock(mode_on_start=Mode.PASSIVE)
    loop.run(2.0)
    assert pursue(loop, Undock(0.0)).code is Code.NONE
    loop.run(10.0)
    assert not said(loop, Severity.WARNING, 'does not charge')


def test_the_charge_of_an_alkaline_pack_says_nothing():
    loop = Loop(Settings(charge_known=False), config=DEFAULT_BODY)
    loop.body.force(charge=0, capacity=2700)
    loop.run(15.0)
    assert loop.driver.health(loop.now).battery is BatteryLevel.FINE
    loop.body.force(voltage=12300)
    loop.run(LEVEL_DELAY + 1)
    assert loop.driver.health(loop.now).battery is BatteryLevel.EMPTY


def test_a_charge_is_judged_where_the_voltage_is_not_known():
    loop = Loop(config=DEFAULT_BODY)
    loop.forged = {'voltage': 65535, 'battery_charge': 100}
    loop.run(3.0)
    assert loop.driver.health(loop.now).battery is BatteryLevel.EMPTY
    assert said(loop, Severity.WARNING, 'battery nearly empty (charge 4%): charge it') == 1


def test_a_charge_at_its_limit_is_told_of_once():
    loop = Loop(config=replace(DEFAULT_BODY))
    loop.run(1.0)
    for charge in (541, 539, 541, 538, 560, 539):
        loop.body.force(charge=charge, capacity=2700)
        loop.run(3.0)
    assert said(loop, Severity.WARNING, 'battery low') == 1


def test_a_robot_that_may_not_listen_is_not_restarted_before_it_does():
    loop = on_dock(mode_on_start=Mode.PASSIVE, reset_when_not_charging=True)
    loop.body.set_battery(charge=0.4, waits=True)
    loop.run(1.0)
    loop.robot.receive(oi.WaitTime(time=150).encode(), loop.now)
    loop.run(2 * CHARGE_WAIT)
    assert loop.robot.waiting and loop.driver.core.listening.open
    assert not said(loop, Severity.WARNING, 'restarting it (opcode 7)')
    loop.run(5.0 + CHARGE_WAIT + 1)
    assert said(loop, Severity.WARNING, 'restarting it (opcode 7)') == 1


# The Home Base: found, felt, left; robots that Safe holds there, or that do not charge.


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


def all_said(loop: Loop) -> str:
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
    assert 'not driving' not in all_said(loop)


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
    assert 'FULL' not in ending.text + all_said(loop)


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
    assert 'leaves the dock in FULL, then returns to SAFE' in all_said(loop)
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
        assert 'send the goal undock, it is on its dock' in all_said(loop)
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
    assert all_said(loop).count(f'does not charge (state {state.name})') == 1
    assert 'set reset_when_not_charging' in all_said(loop)
    assert loop.body.sense().current < 0
    loop.body.place(Pose(0.8, 0.0, pi))
    loop.run(1.0)
    loop.body.place(ON_BASE)
    loop.run(2 * CHARGE_WAIT)
    assert all_said(loop).count(f'does not charge (state {state.name})') == 2


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
