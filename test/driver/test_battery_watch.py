# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""From the battery's voltage to its level, to the second."""

from create_oi_ros import oi
from create_oi_ros.driver import BatteryLevel, Settings
from create_oi_ros.driver.battery import BatteryGuard
from create_oi_ros.driver.core import Core
from create_oi_ros.driver.mode import Modes
from create_oi_ros.driver.outputs import Outputs

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
