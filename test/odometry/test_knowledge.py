# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is known of a robot's wheels."""

import numpy as np
import pytest

from create_oi_ros.odometry import Family, Knowledge, states
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.dead_band import DeadBand
from create_oi_ros.odometry.knowledge import known, learned, SIGNS
from create_oi_ros.robot import Rounding

KINDS = len(Rounding) * len(SIGNS)
PART = 0.7
"""Probability that the wheels are of the likelier family."""


def believed(family: Family) -> Knowledge:
    """Return what is learned of wheels that are likely of a family."""
    rows = Assumptions.all()
    likelier = rows.springs == (family is Family.SPRING)
    rows.weights = np.where(likelier, PART / likelier.sum(), (1 - PART) / (~likelier).sum())
    numbers = {states.LAG: 0.05, states.SLOW_LAG: 0.0, states.FAST_LAG: 0.0,
               states.DEAD_TIME: 0.03, states.RAMP: 0.4}
    for index, value in numbers.items():
        rows.means[likelier, index] = value
    return learned(rows, DeadBand())


def test_a_spring_has_a_damping_and_overshoots() -> None:
    robot = believed(Family.SPRING)
    assert robot.family is Family.SPRING
    assert robot.response == pytest.approx({Family.SPRING: PART, Family.LAG: 1 - PART})
    assert robot.damping is not None
    assert robot.damping.value == pytest.approx(0.4)
    assert robot.inverse_acceleration is None
    assert robot.overshoot == pytest.approx(0.254, abs=0.001)
    assert robot.delay(0.1).value == pytest.approx(0.05 + 0.03)


def test_a_lag_may_have_a_bound_and_does_not_overshoot() -> None:
    robot = believed(Family.LAG)
    assert robot.family is Family.LAG
    assert robot.inverse_acceleration is not None
    assert robot.inverse_acceleration.value == pytest.approx(0.4)
    assert (robot.damping, robot.overshoot) == (None, 0.0)
    assert robot.delay(0.1).value == pytest.approx(0.05 + 0.03 + 0.4 * 0.1 / 2)


@pytest.mark.parametrize('family', Family)
def test_tracks_begin_with_what_is_known(family: Family) -> None:
    robot = believed(family)
    rows = known(robot)
    assert (rows.springs[:KINDS] == (family is Family.SPRING)).all()
    assert rows.means[0, states.RAMP] == pytest.approx(0.4)
    again = learned(rows, DeadBand())
    assert again.family is family
    for name in robot.numbers:
        before, after = getattr(robot, name), getattr(again, name)
        assert after.value == pytest.approx(before.value, abs=0.01)
        assert after.deviation > before.deviation  # it may have changed since
