# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""When a mode may be entered again, to the edges of its times; fractions are binary, so exact."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Cause, ModeStatus, Settings
from create_oi_ros.driver.core import Core
from create_oi_ros.driver.mode import (
    causes_in,
    CLEAR_TIME,
    MAX_TRIES,
    Modes,
    RETRY_INTERVAL,
    SETTLING_TIME,
)
from create_oi_ros.driver.outputs import Outputs
from create_oi_ros.driver.state import StateEvent

OFF, PASSIVE, SAFE, FULL = oi.Mode.OFF, oi.Mode.PASSIVE, oi.Mode.SAFE, oi.Mode.FULL
LITTLE = 1e-6


def frame(mode: oi.Mode, *, drops: int = 0, cliff: int = 0, charger: int = 0) -> oi.Readings:
    """Return the readings that it takes to watch the mode."""
    return oi.Readings({
        'oi_mode': mode, 'bumps_and_wheel_drops': drops, 'cliff_left': 0, 'cliff_front_left': 0,
        'cliff_front_right': 0, 'cliff_right': cliff, 'charging_sources': charger})


class Watch:
    """The modes of a robot that answers."""

    def __init__(self, wanted: oi.Mode, *, recover: bool) -> None:
        self.core = Core(Settings(mode_on_start=wanted, recover_mode=recover), lambda _: None)
        self.modes = Modes(self.core, Outputs(self.core))
        self.core.handle(StateEvent.OPENED)
        self.core.handle(StateEvent.ANSWERED)

    @property
    def status(self) -> ModeStatus:
        """What is known of the mode."""
        return self.core.status

    def observe(self, readings: oi.Readings, now: float) -> bool:
        """Take a frame in; return whether the robot is said to have left its mode."""
        self.core.events.clear()
        self.core.readings = readings
        self.modes.observe(readings, now)
        return bool(self.core.events)

    def enter(self, now: float) -> None:
        """Tell the robot to enter the wanted mode."""
        self.modes.enter(self.status.wanted, now)


def entered(wanted: oi.Mode = SAFE, *, recover: bool = True) -> Watch:
    """Return the modes of a robot that entered its mode at second 8."""
    watch = Watch(wanted, recover=recover)
    watch.enter(8.0)
    assert not watch.observe(frame(wanted), 8.0)
    return watch


def fallen(at: float = 16.0, *, recover: bool = True) -> Watch:
    """Return the modes of a robot that fell to Passive at a cliff that is gone since."""
    watch = entered(recover=recover)
    assert watch.observe(frame(PASSIVE, cliff=1), at)
    return watch


# What takes the robot out of its mode.


@pytest.mark.parametrize(('name', 'value', 'cause'), [
    ('cliff_left', 1, Cause.CLIFF_LEFT), ('cliff_front_left', 1, Cause.CLIFF_FRONT_LEFT),
    ('cliff_front_right', 1, Cause.CLIFF_FRONT_RIGHT), ('cliff_right', 1, Cause.CLIFF_RIGHT),
    ('bumps_and_wheel_drops', 8, Cause.WHEEL_DROP_LEFT),
    ('bumps_and_wheel_drops', 4, Cause.WHEEL_DROP_RIGHT),
    ('bumps_and_wheel_drops', 16, Cause.WHEEL_DROP_CASTER),
    ('charging_sources', 1, Cause.CHARGER), ('charging_sources', 2, Cause.CHARGER)])
def test_each_hazard_is_named_alone(name: str, value: int, cause: Cause) -> None:
    readings = oi.Readings({
        'bumps_and_wheel_drops': 3, 'cliff_left': 0, 'cliff_front_left': 0,
        'cliff_front_right': 0, 'cliff_right': 0, 'charging_sources': 0, name: value})
    assert causes_in(readings) == (cause,)


@pytest.mark.parametrize(('mode', 'cause'), [(OFF, Cause.POWER), (PASSIVE, Cause.UNKNOWN)])
def test_a_mode_that_was_left_without_a_hazard_has_a_cause_all_the_same(
        mode: oi.Mode, cause: Cause) -> None:
    watch = entered()
    assert watch.observe(frame(mode), 16.0)
    assert watch.status.causes == (cause,)
    assert watch.status.reason == cause.value
    assert not watch.status.can_drive
    assert not watch.observe(frame(mode), 16.5), 'it is told once'


# A frame from before the mode was entered.


def test_a_mode_that_seems_left_soon_after_it_was_asked_for_is_only_entered_again() -> None:
    watch = entered()
    assert not watch.observe(frame(PASSIVE), 8.0 + SETTLING_TIME)
    assert watch.status.causes == ()
    assert watch.modes.must_retry(8.0 + SETTLING_TIME)
    watch = entered()
    assert watch.observe(frame(PASSIVE), 8.0 + SETTLING_TIME + LITTLE)
    watch = entered()
    assert watch.observe(frame(PASSIVE, cliff=1), 8.5), 'a hazard needs no second frame'


def test_a_mode_that_only_seemed_left_is_entered_again_at_most_twice() -> None:
    watch, tries, now = entered(), 0, 9.0
    watch.observe(frame(PASSIVE), now)
    while watch.modes.must_retry(now):
        watch.enter(now)
        tries, now = tries + 1, now + 1.0
    assert tries == MAX_TRIES - 1


# A robot that missed the command.


def test_a_mode_that_the_robot_missed_is_entered_again_after_a_while_and_not_for_ever() -> None:
    watch = Watch(SAFE, recover=True)
    watch.observe(frame(PASSIVE), 1.0)
    assert not watch.modes.must_retry(2.0), 'nobody has asked for it yet'
    for number in range(1, MAX_TRIES + 1):
        watch.enter(8.0 * number)
        watch.observe(frame(PASSIVE), 8.0 * number + RETRY_INTERVAL / 2)
        assert not watch.modes.must_retry(8.0 * number + RETRY_INTERVAL - LITTLE)
        again = watch.modes.must_retry(8.0 * number + RETRY_INTERVAL + LITTLE)
        assert again is (number < MAX_TRIES)
        if again:
            watch.observe(frame(PASSIVE), 8.0 * number + RETRY_INTERVAL + LITTLE)
        assert watch.status.causes == ()
    watch.observe(frame(PASSIVE), 24.0 + RETRY_INTERVAL - LITTLE)
    assert watch.status.causes == ()
    watch.observe(frame(PASSIVE), 24.0 + RETRY_INTERVAL + LITTLE)
    assert watch.status.causes == (Cause.UNKNOWN,)


def test_the_times_to_wait_are_those_of_the_pages() -> None:
    assert (RETRY_INTERVAL, MAX_TRIES, SETTLING_TIME, CLEAR_TIME) == (0.2, 3, 2.0, 1.0)


@pytest.mark.parametrize(('wanted', 'actual', 'again'), [
    (SAFE, FULL, True), (FULL, SAFE, True), (PASSIVE, SAFE, False), (PASSIVE, FULL, False),
    (SAFE, PASSIVE, False), (FULL, OFF, False)])
def test_full_for_safe_is_no_safety_stop_and_is_always_undone(
        wanted: oi.Mode, actual: oi.Mode, again: bool) -> None:
    watch = entered(wanted)
    assert watch.observe(frame(actual), 16.0)
    assert watch.modes.must_retry(16.0) is again
    assert watch.modes.may_recover(17.0)


# Coming back.


def test_the_mode_comes_back_a_second_after_the_hazard() -> None:
    watch = fallen(16.0)
    assert not watch.modes.may_recover(17.0 - LITTLE)
    assert watch.modes.may_recover(17.0)
    watch.observe(frame(PASSIVE, cliff=1), 18.0)
    assert not watch.modes.may_recover(18.5)
    assert watch.modes.may_recover(19.0)
