# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is known of a robot's wheels."""

from dataclasses import replace
from math import exp, hypot, log, sqrt

import numpy as np
import pytest

from create_oi_ros.odometry import Family, Knowledge, Known, SignSource, states
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.dead_band import DeadBand
from create_oi_ros.odometry.encoder_signs import UPWARD
from create_oi_ros.odometry.knowledge import known, learned, PERIOD, SIGNS, STATES
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


# Two kinds of wheels, with deviations that make sums easy; nothing is correlated.
LAG = replace(
    believed(Family.LAG), right_gain=Known(1.0, 0.009), left_gain=Known(1.0, 0.008),
    time_constant=Known(0.1, 0.01), slow_part=Known(0.5, 0.02), fast_part=Known(0.25, 0.04),
    dead_time=Known(0.03, 0.003), inverse_acceleration=Known(0.4, 0.05),
    correlations=tuple((0.0,) * row for row in range(1, len(STATES))))


@pytest.mark.parametrize(('speed', 'slow', 'fast'), [
    (0.05, 1.0, 0.0), (0.01, 1.0, 0.0), (0.06, 0.5128205, 0.0), (0.076, 0.0, 0.0),
    (0.2, 0.0, 0.7311321), (0.5, 0.0, 1.0)])
def test_a_delay_depends_on_the_speed_and_is_as_sure_as_its_parts(speed, slow, fast) -> None:
    part = 1 + 0.5 * slow - 0.25 * fast
    delay = LAG.delay(speed)
    assert delay.value == pytest.approx(0.1 * part + 0.03 + 0.4 * speed / 2)
    assert delay.deviation == pytest.approx(hypot(
        part * 0.01, 0.1 * slow * 0.02, 0.1 * fast * 0.04, 0.003, speed / 2 * 0.05))


@pytest.mark.parametrize('less_sure', [
    {'rounding': {Rounding.ROUND: 0.99, Rounding.CARRY: 0.01}},
    {'encoder_sign': {SignSource.MOTION: 0.99, SignSource.DRIVE: 0.01}},
    {'right_gain': Known(1.0, 0.01)}, {'left_gain': Known(1.0, 0.01)},
    {'dead_time': Known(0.03, 0.03)}])
def test_a_robot_is_known_when_all_that_matters_is_sure(less_sure) -> None:
    robot = replace(LAG, rounding={Rounding.CARRY: 0.001, Rounding.ROUND: 0.999},
                    encoder_sign={SignSource.DRIVE: 0.001, SignSource.MOTION: 0.999})
    assert robot.certain
    assert robot.likeliest == (Rounding.ROUND, SignSource.MOTION)
    assert not replace(robot, **less_sure).certain


def test_numbers_are_those_of_the_likelier_kind_with_the_doubt_between_its_tracks() -> None:
    rows = Assumptions.all()
    rows.keep([0, 1, 3])  # two lags and a spring
    rows.weights = np.array([0.3, 0.1, 0.2])
    rows.means[:, states.GAIN_RIGHT] = 1.0, 1.2, 9.0
    rows.means[:, states.GAIN_LEFT] = 1.0, 0.8, 9.0
    rows.p[:] = 0.0
    rows.p[:, states.GAIN_RIGHT, states.GAIN_RIGHT] = 0.01, 0.05, 9.0
    rows.readings = 77
    robot = learned(rows, DeadBand(0.01, 0.02))
    assert robot.response == pytest.approx({Family.LAG: 4 / 6, Family.SPRING: 2 / 6})
    assert robot.right_gain.value == pytest.approx(1.05)
    assert robot.right_gain.deviation == pytest.approx(sqrt(0.02 + 0.75 * 0.25 * 0.04))
    assert robot.left_gain.deviation == pytest.approx(sqrt(0.75 * 0.25 * 0.04))
    assert robot.correlations[0] == pytest.approx(
        (-0.0075 / (robot.right_gain.deviation * robot.left_gain.deviation),))
    assert (robot.dead_band, robot.readings) == ((0.01, 0.02), 77)
    assert robot.braking.value == pytest.approx(1.0)
    assert robot.separation_factor.value == pytest.approx(1.0)


def test_a_known_robot_may_have_changed_and_may_be_another_one() -> None:
    robot = replace(LAG, rounding={Rounding.ROUND: 1.0}, braking=Known(2.0, 0.1),
                    encoder_sign={SignSource.LATE_REQUEST: 1.0},
                    correlations=((0.5,), *LAG.correlations[1:]))
    rows = known(robot)
    believed_in = rows.weights[:KINDS]
    assert believed_in.sum() == pytest.approx(1 - 2e-3)
    best = int(believed_in.argmax())
    assert rows.roundings[best] is Rounding.ROUND
    assert (int(rows.signs.kinds[best]), bool(rows.signs.late[best])) == (UPWARD, True)
    others = np.delete(believed_in, best)
    assert others / believed_in[best] == pytest.approx(np.full(KINDS - 1, 5e-5))
    p = rows.p[best]
    for index, deviation in ((states.GAIN_RIGHT, 0.009), (states.DEAD_TIME, 0.003),
                             (states.BRAKING, 0.05)):
        assert p[index, index] == pytest.approx((1.5 * deviation) ** 2 + 1e-8)
    assert p[states.GAIN_RIGHT, states.GAIN_LEFT] == pytest.approx(2.25 * 0.5 * 0.009 * 0.008)
    assert rows.means[best, states.BRAKING] == pytest.approx(log(2))
    assert rows.means[best, states.MOVES_LEFT] == 1.0
    assert not rows.p[best, states.X:].any()
    assert len(rows.weights) == KINDS + len(Assumptions.all().weights)


def test_every_number_has_the_range_of_its_state() -> None:
    lag, spring = believed(Family.LAG).numbers, believed(Family.SPRING).numbers
    assert lag['separation_factor'].range == pytest.approx((0.85, 1.15))
    assert lag['braking'].range == pytest.approx((exp(-1.3), exp(1.3)))
    assert lag['inverse_acceleration'].range == (0.0, 4.0)
    assert spring['damping'].range == (0.15, 0.95)
    assert set(lag) - set(spring) == {'inverse_acceleration'}
    for numbers in (lag, spring):
        for number in numbers.values():
            assert number.to_state(number.of_state(0.3)) == pytest.approx(0.3)


def test_slots_of_15_and_15_625_ms_were_seen() -> None:
    assert PERIOD.value == 0.015
    assert PERIOD.value + 3 * PERIOD.deviation > 0.015625 > PERIOD.value + PERIOD.deviation


def test_how_late_a_wheel_is_is_less_sure_where_its_numbers_go_together() -> None:
    """A longer lag at all speeds may be a shorter one of fast wheels: their errors add up."""
    robot = believed(Family.LAG)
    names = list(robot.numbers)
    lag, fast = names.index('time_constant'), names.index('fast_part')
    deviations = []
    for together in (-0.5, 0.0, 0.5):
        matrix = np.eye(len(names))
        matrix[lag, fast] = matrix[fast, lag] = together
        rows = tuple(tuple(float(each) for each in row[:place])
                     for place, row in enumerate(matrix) if place)
        deviations.append(replace(robot, correlations=rows).delay(0.3).deviation)
    assert deviations[0] > deviations[1] > deviations[2]


def test_no_source_of_signs_is_likelier_than_at_first_before_one_has_mattered():
    assert (learned(Assumptions.new(), DeadBand()).encoder_sign
            == pytest.approx(learned(Assumptions.all(), DeadBand()).encoder_sign))
