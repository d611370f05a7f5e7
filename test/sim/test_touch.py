# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated robot against obstacles, and in the hands of somebody."""

import math
from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros.sim.body.sensed import checked, RANGES, Sensed
from create_oi_ros.sim.world import parse, Pose, shipped, World
from support.bodies import Body, body_at_speed, FRAME, run, WALL_AHEAD

# Obstacles.

def test_a_wall_stops_the_robot_and_the_wheels_slip():
    body = Body(WALL_AHEAD)
    body.drive(right=0.4, left=0.4)
    body.step(4)
    truth = body.truth()
    assert truth.pose.x == pytest.approx(1 - 0.165, abs=1e-6)
    assert truth.measured_travelled == pytest.approx(0.4 * 4 - 0.08)
    assert truth.speed == pytest.approx(0, abs=1e-6)
    assert body.sense().bump_left and body.sense().bump_right
    assert not body.sense().overcurrent_left_wheel


@pytest.mark.parametrize(('degrees', 'left', 'right'), [
    (0, True, True), (14, True, True), (-14, True, True), (16, True, False), (-16, False, True),
    (80, True, False), (-80, False, True), (100, False, False), (180, False, False)])
def test_the_bumper_tells_the_side_by_where_it_touched(degrees, left, right):
    body = Body(World())
    bearing = math.radians(degrees)
    far = 0.165 + 0.05
    world = parse(f'post {far * math.cos(bearing)} {far * math.sin(bearing)} 0.05', 'post')
    sense = Body(world).sense()
    assert (sense.bump_left, sense.bump_right) == (left, right)
    assert not body.sense().bump_left


@given(st.integers(0, 2 ** 32), st.sampled_from(['room', 'apartment']))
@settings(max_examples=15, deadline=None)
def test_no_drive_leaves_the_walls(seed, name):
    dice, world = Random(seed), shipped(name)
    body = Body(world)
    for _ in range(12):
        body.drive(right=dice.uniform(-.5, .5), left=dice.uniform(-.5, .5))
        run(body, 1.5)
        x, y, _ = body.truth().pose
        assert all(each.gap(x, y) >= 0.165 - 1e-3 for each in world.obstacles)


# By hand.

def test_lifted_all_wheels_drop_all_cliffs_show_and_nothing_moves():
    body = body_at_speed(0.2, 0.2)
    body.lift(True)
    before = body.truth().pose
    run(body, 1)
    sense = body.sense()
    assert sense.drop_left and sense.drop_right and sense.drop_caster
    assert sense.cliff_left and sense.cliff_front_left
    assert sense.cliff_right and sense.cliff_front_right
    assert sense.cliff_left_signal < 16
    assert body.truth().pose == before
    assert body.take_distance() == pytest.approx(200, abs=1)
    body.lift(False)
    assert not body.sense().drop_left
    run(body, 1)
    assert body.truth().pose.x > before.x


def test_a_held_wheel_draws_too_much_only_when_told_to_turn():
    body = Body(World())
    body.hold(left=True)
    body.step(FRAME)
    assert not body.sense().overcurrent_left_wheel
    body.drive(right=0.1, left=0.1)
    assert body.sense().overcurrent_left_wheel
    run(body, 1)
    assert body.sense().overcurrent_left_wheel
    assert not body.sense().overcurrent_right_wheel
    assert body.truth().turned > 0
    assert body.truth().measured_turned == pytest.approx(body.truth().turned)
    body.hold()
    assert not body.sense().overcurrent_left_wheel


@pytest.mark.parametrize('act', [
    lambda body: body.place(Pose(math.nan, 0, 0)),
    lambda body: body.push(speed=math.inf, rate=0, seconds=1),
    lambda body: body.push(speed=0, rate=0, seconds=-1),
    lambda body: body.slip(right=0, left=0, seconds=math.inf),
    lambda body: body.load(ld0=math.nan),
    lambda body: body.set_battery(temperature=math.inf),
    lambda body: body.force(seconds=-1, play=True)])
def test_the_outside_cannot_break_the_physics(act):
    with pytest.raises(ValueError, match='allowed'):
        act(Body(World()))


# Sensors that are held at a value, and their ranges.


def test_a_forced_sensor_can_end_by_itself_to_the_millisecond():
    body = Body(World())
    body.force(seconds=0.2, play=True)
    body.force(seconds=0.4, infrared=130)
    body.step(0.199)
    assert body.sense().play
    body.step(0.001)
    assert not body.sense().play
    assert body.sense().infrared == 130
    body.step(0.2)
    assert body.sense().infrared == 255


@pytest.mark.parametrize(('name', 'value'), [
    ('bump_left', 2), ('analog', 1024), ('infrared', -1), ('wall_signal', 4096),
    ('charging_state', 6), ('voltage', 1.5)])
def test_a_value_out_of_the_manuals_range_or_of_no_sensor_is_refused(name, value):
    body = Body(World())
    with pytest.raises(ValueError, match=name):
        body.force(**{'play': True, name: value})
    assert not body.sense().play
    with pytest.raises(ValueError, match='no sensor .*bump_centre'):
        Body(World()).force(bump_centre=1)
    with pytest.raises(ValueError, match='no sensor'):
        Body(World()).unforce('bump_centre')


@given(st.dictionaries(st.sampled_from(sorted(RANGES)), st.integers(-70000, 70000)),
       st.floats(-1, 2), st.floats(-300, 300),
       st.lists(st.floats(0, 50), min_size=3, max_size=3), st.booleans(),
       st.sampled_from(['room', 'apartment', 'table', 'empty']))
@settings(max_examples=80, deadline=None)
def test_sensors_stay_in_the_manuals_ranges(forced, charge, temperature, loads, lifted, name):
    body = Body(shipped(name), seed=3)
    for field, value in forced.items():
        low, high = RANGES[field]
        body.force(**{field: min(high, max(low, value))})
    body.set_battery(charge=charge, temperature=temperature)
    body.load(ld0=loads[0], ld1=loads[1], ld2=loads[2])
    body.low_side(duty0=1, duty1=0.5, duty2=2)
    body.lift(lifted)
    body.drive(right=0.5, left=0.3)
    body.plug_charger(temperature > 0)
    for _ in range(4):
        body.step(0.4)
        for field, value in body.sense()._asdict().items():
            assert checked(field, value) == value
            assert isinstance(value, type(Sensed._field_defaults[field]))
