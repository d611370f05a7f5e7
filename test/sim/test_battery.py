# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The battery: drain, charging states, temperature, overcurrent of the drivers."""

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros.oi import ChargingState
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.battery import Battery, CAPACITY
from create_oi_ros.sim.world import World

HOUR = 3600.0


def charging(charge=0.5):
    body = Body(World())
    body.set_battery(charge=charge)
    body.plug_charger(True)
    body.step(1)
    return body


def test_the_battery_drains_while_the_robot_stands():
    body = Body(World())
    before = body.sense().charge
    body.step(HOUR)
    assert body.sense().charge == before - 200
    assert body.sense().current == -200


def test_an_empty_battery_is_flat_and_stays_at_zero():
    body = Body(World())
    body.set_battery(charge=0.01)
    assert not body.battery_flat
    body.step(HOUR)
    assert body.battery_flat
    assert body.sense().charge == 0


def test_charging_goes_through_reconditioning_full_trickle_and_waiting():
    body, seen = charging(charge=0.0), []
    for _ in range(int(4.5 * HOUR / 10)):
        body.step(10)
        if not seen or seen[-1] != body.sense().charging_state:
            seen.append(body.sense().charging_state)
    assert seen == [ChargingState.RECONDITIONING, ChargingState.FULL_CHARGING,
                    ChargingState.TRICKLE, ChargingState.WAITING]
    assert 0.9 < body.sense().charge / body.sense().capacity <= 1


@pytest.mark.parametrize('acts', [
    [(lambda body: body.allow_charging(False), ChargingState.NOT_CHARGING),  # Safe and Full do
     (lambda body: body.allow_charging(True), ChargingState.FULL_CHARGING)],
    [(lambda body: body.set_battery(fault=True), ChargingState.FAULT),
     (lambda body: body.set_battery(fault=False), ChargingState.FULL_CHARGING)],
    [(lambda body: body.set_battery(temperature=46), ChargingState.WAITING),
     (lambda body: body.set_battery(temperature=42), ChargingState.WAITING),
     (lambda body: body.set_battery(temperature=39), ChargingState.FULL_CHARGING)]],
    ids=['mode', 'fault', 'heat'])
def test_charging_stops_for_a_mode_a_fault_and_heat_and_goes_on(acts):
    body = charging()
    for act, state in acts:
        act(body)
        body.step(1)
        sense = body.sense()
        assert sense.charging_state == state and sense.internal_charger
        assert (sense.current > 0) is (state == ChargingState.FULL_CHARGING)


@pytest.mark.parametrize(('driver', 'limit'), [('ld0', 0.5), ('ld1', 0.5), ('ld2', 1.5)])
def test_an_overloaded_low_side_driver_limits_its_current_and_says_so(driver, limit):
    body = Body(World())
    body.low_side(duty0=1, duty1=1, duty2=1)
    body.load(**{driver: limit})
    body.step(1)
    just_right = body.sense()
    assert not getattr(just_right, f'overcurrent_{driver}')
    body.load(**{driver: limit + 1})
    body.step(1)
    for each in ('ld0', 'ld1', 'ld2'):
        assert getattr(body.sense(), f'overcurrent_{each}') is (each == driver)
    assert body.sense().current == just_right.current
    body.low_side(duty0=0, duty1=0, duty2=0)
    assert not getattr(body.sense(), f'overcurrent_{driver}')


@given(st.lists(st.tuples(st.floats(0, 2000), st.floats(0, 5), st.booleans()), max_size=20))
@settings(max_examples=50, deadline=None)
def test_charge_stays_between_empty_and_full(times):
    battery = Battery()
    for seconds, drawn, charger in times:
        battery.step(seconds, drawn, charger)
        assert 0 <= battery.charge <= CAPACITY
        assert 10 < battery.voltage < 18
        assert (battery.state is ChargingState.NOT_CHARGING) == (not charger) or seconds == 0
