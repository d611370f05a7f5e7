# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensors of the simulated robot that are held at a value, and their ranges."""


from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros.sim.body.sensed import checked, RANGES, Sensed
from create_oi_ros.sim.world import shipped, World
from support.bodies import Body, run


def test_a_forced_sensor_replaces_the_physics_until_it_is_released():
    body = Body(World())
    body.force(bump_left=True, analog=700)
    run(body, 1)
    assert body.sense().bump_left is True
    assert body.sense().analog == 700
    body.unforce('bump_left')
    assert not body.sense().bump_left
    assert body.sense().analog == 700
    body.unforce()
    assert body.sense().analog == 0


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
def test_a_value_out_of_the_manuals_range_is_refused_with_its_name(name, value):
    body = Body(World())
    with pytest.raises(ValueError, match=name):
        body.force(**{'play': True, name: value})
    assert not body.sense().play


def test_a_sensor_that_is_not_there_is_refused():
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
