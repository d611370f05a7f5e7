# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is known of a robot: when it is certain, and how late its wheels are."""

from dataclasses import replace

import pytest

from create_oi_ros.odometry import Hypothesis, Knowledge, Known, Response, Rounding, SignSource

LAG = Hypothesis(Response.LAG, 0.15, 1.0, 0.1, 1.0, 0.03, 0.01)
SURE = Known(1.0, 1e-3)
ROBOT = Knowledge(
    hypotheses={LAG: 0.9, LAG._replace(dead_time=0.02): 0.1}, rounding={Rounding.CARRY: 1.0},
    right_gain=SURE, left_gain=SURE, angle_factor=SURE)


@pytest.mark.parametrize(('row', 'late'), [
    (LAG, 0.03 + 0.075), (LAG._replace(of_speed=0.0), 0.03 + 0.15),
    (LAG._replace(response=Response.RAMP, time=1.0, of_speed=0.0), 0.03 + 0.1),
    (LAG._replace(response=Response.SPRING, time=0.06, of_speed=0.0, overshoot=0.3),
     0.03 + 2 * 0.358 * 0.06)])  # 0.358 is the damping of such an overshoot
def test_a_wheel_is_as_late_as_its_response_says(row, late):
    assert replace(ROBOT, hypotheses={row: 1.0}).delay(0.2) == pytest.approx((late, 0.0), abs=1e-4)


def test_the_delay_is_the_mean_of_the_hypotheses():
    assert ROBOT.delay(0.2).value == pytest.approx(0.104)
    assert ROBOT.delay(0.2).deviation == pytest.approx(0.003)
    assert ROBOT.wheels is LAG


@pytest.mark.parametrize('change', [
    {'rounding': {Rounding.CARRY: 0.9, Rounding.ROUND: 0.1}}, {'left_gain': Known(1.0, 0.1)},
    {'hypotheses': {LAG: 0.9, LAG._replace(sign=SignSource.MOTION): 0.1}},
    {'hypotheses': {LAG: 0.5, LAG._replace(dead_time=0.15): 0.5}}])
def test_a_robot_is_certain_where_all_of_it_is(change):
    assert ROBOT.certain
    assert not replace(ROBOT, **change).certain
