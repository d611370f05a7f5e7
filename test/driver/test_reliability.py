# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the driver does when something is wrong with line or robot, in memory."""

from re import fullmatch

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import BatteryLevel, Settings, Severity
from create_oi_ros.driver.battery import BatteryGuard, LEVEL_DELAY
from create_oi_ros.driver.core import Core
from create_oi_ros.driver.mode import CLEAR_TIME, Modes
from create_oi_ros.driver.outbox import DEAD_MAN_STOP
from create_oi_ros.driver.outputs import Outputs
from support.loop import Loop, said, texts

# What cannot be.


def test_an_impossible_jump_is_dropped_and_counted():
    loop = Loop()
    loop.run(1)
    before = loop.estimate
    forged = loop.driver.plan.full
    values = [0] * len(forged.packets)
    values[forged.names.index('distance')] = 4000
    values[forged.names.index('oi_mode')] = oi.Mode.SAFE
    loop.driver.receive(forged.pack_frame(values), loop.now)
    loop.run(0.1)
    assert loop.driver.counts.impossible_jumps == 1
    assert loop.estimate.x == pytest.approx(before.x, abs=1e-6)


# The battery.


def test_a_low_battery_is_told_of_once_and_nothing_is_done_unasked():
    loop = Loop(Settings(battery_low=14.0, battery_empty=13.9))
    loop.run(0.5)
    loop.body.set_battery(charge=0.02)
    loop.run(LEVEL_DELAY + 2)
    assert loop.driver.health(loop.now).battery is BatteryLevel.EMPTY
    assert said(loop, Severity.WARNING, 'battery') in (1, 2)
    for text in texts(loop.notices, Severity.WARNING):
        assert fullmatch(r'battery (low|nearly empty) \(1[0-4]\.\d V\): charge it', text)
    assert loop.robot.mode is oi.Mode.SAFE


# A driver that was stopped.


def test_after_a_standstill_what_came_long_ago_is_dropped_and_the_robot_called_anew():
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    frames = len(loop.moved)
    stale = loop.driver.plan.short.pack_frame([0] * len(loop.driver.plan.short.packets))
    loop.robot.receive(DEAD_MAN_STOP, loop.now)
    loop.cut, receive, poll = True, loop.driver.receive, loop.driver.poll
    loop.driver.poll = lambda now: None
    loop.run(5.0)
    loop.cut, loop.driver.poll = False, poll
    receive(stale * 60, loop.now)
    assert len(loop.moved) == frames
    loop.run(2.0)
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.01)
    assert said(loop, Severity.WARNING, 'stood still for 5.0 s') == 1
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.driver.state.answered
    assert loop.body.truth().speed == 0


def test_a_robot_that_cannot_enter_its_mode_at_first_is_not_pestered_and_may_later():
    loop = Loop()
    loop.body.plug_charger(True)
    loop.run(2.0)
    assert loop.driver.status.reason == 'charger powered'
    assert loop.robot.mode is oi.Mode.PASSIVE
    assert sum(isinstance(each, oi.Safe) for each in loop.commands()) <= 2
    loop.body.plug_charger(False)
    loop.run(CLEAR_TIME + 1.0)
    loop.drive(0.2, 0.0, 0.5)
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.body.truth().speed > 0


# From the battery's voltage to its level, to the second.


FINE, LOW, EMPTY = BatteryLevel


def readings(millivolts: int, sources: int = 0) -> oi.Readings:
    """Return what a frame says of the battery."""
    return oi.Readings({'voltage': millivolts, 'charging_sources': sources})


class Watch:
    """Who watches the battery of a robot."""

    def __init__(self) -> None:
        self.core = Core(Settings(battery_low=13.5, battery_empty=12.5), lambda _: None)
        self.guard = BatteryGuard(self.core, Modes(self.core, Outputs(self.core)))

    @property
    def level(self) -> BatteryLevel:
        """The level by now."""
        return self.guard.level

    def observe(self, frame: oi.Readings, now: float) -> bool:
        """Take a frame in; return whether somebody is told."""
        self.core.events.clear()
        self.guard.observe(frame, now)
        return bool(self.core.events)


def test_a_level_is_reached_after_five_seconds_and_told_once():
    watch = Watch()
    seen = [(watch.observe(readings(13500), now), watch.level)
            for now in (1.0, 5.99, 6.0, 7.0)]
    assert seen == [(False, FINE), (False, FINE), (True, LOW), (False, LOW)]
    seen = [(watch.observe(readings(12500), now), watch.level) for now in (8.0, 12.99, 13.0, 14.0)]
    assert seen == [(False, LOW), (False, LOW), (True, EMPTY), (False, EMPTY)]


def test_a_battery_is_better_again_above_its_limit_and_a_bit():
    watch = Watch()
    for now in (0.0, 5.0):
        watch.observe(readings(12400), now)
    assert watch.level is EMPTY
    for millivolts, level in ((12800, EMPTY), (12801, LOW), (13800, LOW), (13801, FINE)):
        assert not watch.observe(readings(millivolts), 6.0)
        assert watch.level is level
    assert not watch.observe(readings(13501), 99.0)
    assert not watch.observe(readings(13501), 999.0)
    assert watch.level is FINE


def test_a_dip_that_ends_before_begins_anew():
    watch = Watch()
    for now, millivolts in ((0.0, 13000), (4.0, 14000), (4.5, 13000), (9.4, 13000)):
        assert not watch.observe(readings(millivolts), now)
    assert watch.observe(readings(13000), 9.5)


def test_a_battery_that_is_charged_is_fine():
    watch = Watch()
    for now in (0.0, 5.0):
        watch.observe(readings(12000), now)
    for sources in (1, 2):
        watch.observe(readings(12000, sources), 6.0)
        assert watch.level is FINE
    assert not watch.observe(readings(12000), 6.5)


def test_a_voltage_that_is_not_known_is_no_low_one():
    watch = Watch()
    for now in (0.0, 5.0):
        watch.observe(readings(12400), now)
    unknown = readings(12400).corrected(['voltage'])
    assert not watch.observe(unknown, 6.0) and watch.level is FINE
    assert not watch.observe(readings(12400), 7.0), 'it begins anew'
    assert not watch.observe(readings(15000), 8.0) and watch.level is FINE
