# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The accumulators behind packets 19 and 20, under the three roundings."""

from dataclasses import replace
import math

import pytest

from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY, EncoderSign
from create_oi_ros.sim.body.drivetrain import Drivetrain
from create_oi_ros.sim.body.mechanics import Accumulator
from create_oi_ros.sim.world import World
from support.bodies import Body, body_at_speed, ideal


def filled(rounding, *amounts):
    accumulator = Accumulator(rounding)
    for amount in amounts:
        accumulator.add(amount)
    return accumulator


@pytest.mark.parametrize(('rounding', 'amount', 'first', 'second'), [
    # After the first reading a further 0.5 is added and read.
    (Rounding.TRUNCATE, 2.9, 2, 0), (Rounding.TRUNCATE, -2.9, -2, 0),
    (Rounding.ROUND, 2.9, 3, 1), (Rounding.ROUND, 2.4, 2, 1), (Rounding.ROUND, -2.5, -3, 1),
    (Rounding.CARRY, 2.9, 2, 1), (Rounding.CARRY, 2.4, 2, 0), (Rounding.CARRY, -2.9, -2, 0),
])
def test_a_reading_rounds_and_keeps_or_loses_the_rest(rounding, amount, first, second):
    accumulator = filled(rounding, amount)
    assert accumulator.take() == first
    accumulator.add(0.5)
    assert accumulator.take() == second


@pytest.mark.parametrize('rounding', Rounding)
@pytest.mark.parametrize(('amount', 'cap'), [(1e5, 32767), (-1e5, -32768)])
def test_what_waits_is_capped_at_16_bits(rounding, amount, cap):
    accumulator = filled(rounding, amount)
    assert accumulator.take() == cap
    assert abs(accumulator.take()) <= 0


@pytest.mark.parametrize('rounding', Rounding)
def test_a_sum_of_floats_that_means_a_whole_number_is_one(rounding):
    assert filled(rounding, *[0.1] * 10).take() == 1


def reversed_count(sign: EncoderSign, slot: float) -> float:
    """Return what a wheel that reverses counts, metres, when time is cut into such slots."""
    wheel = Drivetrain(replace(DEFAULT_BODY, encoder_sign=sign, encoder_tick=0.0)).right
    counted, slots = 0.0, round(1.2 / slot)
    for number in range(2 * slots):
        if number % slots == 0:
            wheel.command(-0.25 if number else 0.25)
        left = slot
        while left > 1e-12:
            piece = wheel.horizon(left)
            counted += wheel.count(wheel.roll(piece))
            left -= piece
    return counted


@pytest.mark.parametrize('sign', EncoderSign)
def test_what_a_reversing_wheel_counts_does_not_depend_on_how_time_is_cut(sign):
    assert reversed_count(sign, 0.04) == pytest.approx(reversed_count(sign, 0.001), abs=1e-4)


# What distance and angle report of them.


def test_pushed_by_hand_either_way_the_distance_counts_up():
    for speed in (0.2, -0.2):
        body = Body(World())
        body.push(speed=speed, rate=0, seconds=1)
        body.step(2)
        assert body.take_distance() == 200
        assert body.truth().pose.x == pytest.approx(speed)


@pytest.mark.parametrize(('sign', 'before', 'asked', 'counted'), [
    (EncoderSign.UNTIL_REST, 0.3, -0.3, -45), (EncoderSign.TRUE, 0.3, -0.3, 45),
    (EncoderSign.UNTIL_REST, -0.3, 0, -45), (EncoderSign.COMMAND, -0.3, 0, 45)])
def test_what_a_wheel_counts_while_it_rolls_out_against_its_command(
        sign, before, asked, counted):
    body = body_at_speed(before, before, config=ideal(encoder_sign=sign))
    x = body.truth().pose.x
    body.drive(right=asked, left=asked)
    body.step(0.3)
    assert body.truth().speed == pytest.approx(0)
    assert (body.truth().pose.x > x) is (before > 0)
    assert body.take_distance() == counted


def test_once_the_wheels_rest_a_push_counts_up_again():
    body = body_at_speed(-0.3, -0.3, config=ideal(encoder_sign=EncoderSign.UNTIL_REST))
    body.drive(right=0, left=0)
    body.step(1)
    body.take_distance()
    body.push(speed=-0.1, rate=0, seconds=1)
    body.step(1)
    assert body.take_distance() == 100


def test_the_firmwares_own_wheel_separation_scales_its_angle():
    body = body_at_speed(0.129, -0.129, config=ideal(encoder_separation=0.516))
    body.step(math.pi / 2)
    assert body.take_angle() == 45
