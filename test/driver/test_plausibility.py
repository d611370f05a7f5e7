# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The edges of what a reading can be."""

from math import degrees

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.plausibility import JumpCheck, TurnCheck


def moved(distance: int, angle: int) -> oi.Readings:
    """Return a reading of mm and degrees."""
    return oi.Readings({'distance': distance, 'angle': angle})


@pytest.mark.parametrize(('distance', 'angle', 'possible'), [
    (550, 245, True), (-550, -245, True), (551, 0, False), (-551, 0, False), (0, 246, False),
    (0, -246, False), (551, 246, False)])
def test_a_jump_is_refused_from_the_first_unit_on_that_nothing_could_have_made(
        distance: int, angle: int, possible: bool) -> None:
    check = JumpCheck()
    assert check.possible(moved(32767, 32767), 8.0), 'the first spans an unknown time'
    assert check.possible(moved(distance, angle), 8.5) is possible
    assert not check.possible(moved(100, 0), 8.5), 'no time has passed since'
    assert not check.possible(moved(0, 100), 8.5)


def test_frames_that_may_be_missing_count_as_time() -> None:
    check = JumpCheck()
    check.possible(moved(0, 0), 8.0)
    assert check.possible(moved(550, 0), 8.25, gap=0.25)
    assert not check.possible(moved(550, 0), 8.5)
    check.restart()
    assert check.possible(moved(550, 0), 8.5)


def test_nothing_turns_faster_than_twice_what_wheels_can_do() -> None:
    for angle, possible in ((1820, True), (1821, False)):
        check = JumpCheck()
        check.possible(moved(0, 0), 8.0)
        assert check.possible(moved(0, angle), 12.0) is possible


def turning(right: int, left: int, angle: int = 0) -> oi.Readings:
    """Return a reading of a robot that was told to turn."""
    return oi.Readings({
        'requested_right_velocity': right, 'requested_left_velocity': left, 'angle': angle})


@pytest.mark.parametrize('side', [1, -1])
def test_an_angle_is_stuck_after_one_turn_that_was_asked_for(side: int) -> None:
    check = TurnCheck(0.25)
    degree = 1 / degrees(2.0)  # seconds, at 500 mm/s between wheels 0.25 m apart
    reading = turning(250 * side, -250 * side)
    for _ in range(2):
        assert not check.observe(reading, 0.5 * degree, drives=True)
        assert not check.observe(reading, 359.4 * degree, drives=True) and not check.stuck
        assert check.observe(reading, 0.2 * degree, drives=True) and check.stuck
        again = check.observe(reading, 0.2 * degree, drives=True)
        assert not again and check.stuck, 'it is told once'
        changed = check.observe(turning(250, -250, angle=1), 1.0, drives=True)
        assert not changed and not check.stuck, 'the turn begins anew'


def test_turns_to_and_fro_need_not_change_the_angle() -> None:
    check = TurnCheck(0.25)
    for _ in range(10):
        assert not check.observe(turning(250, -250), 2.0, drives=True)
        assert not check.observe(turning(-250, 250), 2.0, drives=True)


@pytest.mark.parametrize(('right', 'left', 'drives'), [(250, 250, True), (250, -250, False)])
def test_a_robot_that_does_not_turn_keeps_its_angle(right: int, left: int, drives: bool) -> None:
    check = TurnCheck(0.25)
    assert not check.observe(turning(right, left), 100.0, drives=drives)
    assert not check.stuck
