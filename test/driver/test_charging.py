# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The battery by voltage, charge and current: low, empty, charged, and not charged on its dock."""

from dataclasses import replace
from re import fullmatch

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import BatteryLevel, Charging, LowBatteryAction, Settings, Severity
from create_oi_ros.driver.battery import CHARGE_WAIT, charging, LEVEL_DELAY
from create_oi_ros.driver.goals import Code, Dock, Undock
from create_oi_ros.oi import ChargingState, Mode
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.world import parse
from support.goals import pursue
from support.loop import Loop, said, texts

BASE = parse('start 0.1655 0 180\nhome_base 0 0 0', 'base')


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
    loop = Loop(Settings(**settings), config=DEFAULT_BODY, world=BASE)
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
