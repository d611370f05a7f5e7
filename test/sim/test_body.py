# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated robot's motion."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros.sim.body.config import BodyConfig
from create_oi_ros.sim.world import shipped, World
from support.bodies import B, Body, body_at_speed, FRAME, ideal


@pytest.mark.parametrize(('right', 'left'), [
    (0.3, 0.1), (-0.1, -0.3), (0.2, -0.2)])
def test_an_arc_at_constant_speed_is_the_closed_form(right, left):
    body = body_at_speed(right, left)
    (x, y, yaw), seconds = body.truth().pose, 3.0
    body.step(seconds)
    v, w = (right + left) / 2, (right - left) / B
    end = body.truth().pose
    assert end.x == pytest.approx(x + v / w * (math.sin(yaw + w * seconds) - math.sin(yaw)),
                                  abs=1e-7)
    assert end.y == pytest.approx(y - v / w * (math.cos(yaw + w * seconds) - math.cos(yaw)),
                                  abs=1e-7)
    assert math.remainder(end.yaw - yaw - w * seconds, math.tau) == pytest.approx(0, abs=1e-9)


@given(st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.integers(1, 40)),
                max_size=6))
@settings(max_examples=40, deadline=None)
def test_motion_does_not_depend_on_how_time_is_cut(legs):
    fine, coarse, whole = Body(World()), Body(World()), Body(World())
    for right, left, frames in legs:
        for body, dt, count in ((fine, 0.005, 3 * frames), (coarse, FRAME, frames),
                                (whole, FRAME * frames, 1)):
            body.drive(right=right, left=left)
            for _ in range(count):
                body.step(dt)
    for other in (coarse, whole):
        assert other.truth().pose[:2] == pytest.approx(fine.truth().pose[:2], abs=1e-7)
        assert other.truth()[1:] == pytest.approx(fine.truth()[1:], abs=1e-7)


def test_wheels_brake_at_their_limit_and_rest():
    body = body_at_speed(0.4, 0.4)
    body.drive(right=0, left=0)
    body.step(0.3)
    assert body.truth().speed == pytest.approx(0.1)
    body.step(0.2)
    assert body.truth().speed == 0


def test_unequal_wheels_bend_the_way_and_hide_it_from_the_encoders():
    body = body_at_speed(0.3, 0.3, config=ideal(right_wheel_scale=1.02))
    body.step(5)
    assert body.truth().turned == pytest.approx(0.3 * 0.02 / B * body.truth().measured_travelled
                                                / 0.3, rel=1e-6)
    assert body.truth().measured_turned == 0


def test_a_slip_burst_ends_by_itself():
    body = body_at_speed(0.3, 0.3)
    before = body.truth()
    body.slip(right=1.0, left=1.0, seconds=0.5)
    body.step(1.0)
    after = body.truth()
    assert after.measured_travelled - before.measured_travelled == pytest.approx(0.3)
    assert after.travelled - before.travelled == pytest.approx(0.15)


@pytest.mark.parametrize('dt', [-0.001, math.inf, math.nan])
def test_a_step_of_no_sensible_length_is_refused(dt):
    with pytest.raises(ValueError, match='dt is'):
        Body(World()).step(dt)


@pytest.mark.parametrize(('name', 'value'), [
    ('wheel_separation', 0.0), ('wheel_acceleration', -1.0), ('left_slip', 1.5),
    ('right_speed_gain', math.nan)])
def test_impossible_constants_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        BodyConfig(**{name: value})


# Determinism.

def story(seed):
    body = Body(shipped('room'), seed=seed)
    body.drive(right=0.3, left=0.25)
    told = []
    for _ in range(300):
        body.step(FRAME)
        told.append((body.sense(), body.truth().pose))
    return told


def test_the_same_seed_gives_the_same_robot():
    assert story(5) == story(5)
    assert story(5) != story(6)
