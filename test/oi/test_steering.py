# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Wheel speeds of Drive, against the manual's description and its special cases."""

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.oi.commands import wheel_speeds

SEPARATION = 258.0


@pytest.mark.parametrize('radius', [-32768, 32767, 0])
def test_straight_turns_both_wheels_alike(radius: int) -> None:
    assert wheel_speeds(-200, radius, SEPARATION) == (-200, -200)


def test_in_place_turns_the_wheels_against_each_other() -> None:
    assert wheel_speeds(200, -1, SEPARATION) == (-200, 200), 'clockwise: the left wheel forward'
    assert wheel_speeds(200, 1, SEPARATION) == (200, -200)


def test_a_positive_radius_turns_left() -> None:
    assert wheel_speeds(200, 258, SEPARATION) == (300, 100)
    assert wheel_speeds(200, -258, SEPARATION) == (100, 300)
    assert wheel_speeds(-200, 258, SEPARATION) == (-300, -100)
    assert wheel_speeds(1, 2, 257.0) == (65.25, -63.25), 'nothing is rounded'


@given(st.integers(-500, 500), st.integers(2, 2000))
def test_the_centre_keeps_velocity_and_radius(velocity: int, radius: int) -> None:
    right, left = wheel_speeds(velocity, radius, SEPARATION)
    assert (right + left) / 2 == pytest.approx(velocity)
    assert (right - left) * radius == pytest.approx(velocity * SEPARATION)
