# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated robot's encoders, as distance and angle report them."""

import math

import pytest

from create_oi_ros.sim.body.config import EncoderSign
from create_oi_ros.sim.world import World
from support.bodies import Body, body_at_speed, ideal


def test_pushed_by_hand_either_way_the_distance_counts_up():
    for speed in (0.2, -0.2):
        body = Body(World())
        body.push(speed=speed, rate=0, seconds=1)
        body.step(2)
        assert body.take_distance() == 200
        assert body.truth().pose.x == pytest.approx(speed)


def test_rolling_on_forwards_after_a_reverse_command_counts_as_reverse():
    body = body_at_speed(0.3, 0.3)
    body.drive(right=-0.3, left=-0.3)
    body.step(0.3)
    assert body.truth().speed == pytest.approx(0)
    assert body.take_distance() == -45
    assert body.truth().pose.x > 0.3


def rolled_out_after_reverse(sign):
    body = body_at_speed(-0.3, -0.3, config=ideal(encoder_sign=sign))
    body.drive(right=0, left=0)
    body.step(1)
    return body


def test_rolling_out_of_reverse_keeps_the_sign_until_the_wheels_rest():
    body = rolled_out_after_reverse(EncoderSign.UNTIL_REST)
    assert body.take_distance() == -45
    body.push(speed=-0.1, rate=0, seconds=1)
    body.step(1)
    assert body.take_distance() == 100


def test_rolling_out_of_reverse_counts_up_where_zero_means_forwards():
    assert rolled_out_after_reverse(EncoderSign.COMMAND).take_distance() == 45


def test_true_encoders_know_the_direction():
    body = body_at_speed(0.3, 0.3, config=ideal(encoder_sign=EncoderSign.TRUE))
    body.drive(right=-0.3, left=-0.3)
    body.step(0.3)
    assert body.take_distance() == 45


def test_the_firmwares_own_wheel_separation_scales_its_angle():
    body = body_at_speed(0.129, -0.129, config=ideal(encoder_separation=0.516))
    body.step(math.pi / 2)
    assert body.take_angle() == 45
