# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated robot: how it moves, what it counts, touches and feels by hand; its battery."""

from dataclasses import replace
from itertools import pairwise
from math import cos, degrees, inf, nan, radians, remainder, sin, tau
from random import Random
from statistics import fmean, mean, pstdev, stdev

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros.oi import ChargingState
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body import Body as AnyBody
from create_oi_ros.sim.body.battery import Battery, CAPACITY
from create_oi_ros.sim.body.config import BodyConfig, DEFAULT_BODY, EncoderSign, IDEAL
from create_oi_ros.sim.body.gyro import Gyro
from create_oi_ros.sim.body.mechanics import Accumulator
from create_oi_ros.sim.body.sensed import checked, RANGES, Sensed
from create_oi_ros.sim.world import parse, Pose, shipped, World

B = IDEAL.wheel_separation
FRAME = 0.015


def Body(world, *, config=IDEAL, **kwargs):
    """Return a body whose wheels ramp without delay, so that sums are easy."""
    return AnyBody(world, config=config, **kwargs)


def run(body, seconds):
    for _ in range(round(seconds / FRAME)):
        body.step(FRAME)


def body_at_speed(right, left, **kwargs):
    """Return a body that drives at these speeds and whose accumulators are empty."""
    body = Body(World(), **kwargs)
    body.drive(right=right, left=left)
    body.step(1.2)
    body.take_distance(), body.take_angle()
    return body


@pytest.fixture
def body():
    """Return a robot on an endless floor."""
    return Body(World())


@pytest.mark.parametrize(('right', 'left'), [
    (0.3, 0.1), (-0.1, -0.3), (0.2, -0.2)])
def test_an_arc_at_constant_speed_is_the_closed_form(right, left):
    body = body_at_speed(right, left)
    (x, y, yaw), seconds = body.truth().pose, 3.0
    body.step(seconds)
    v, w = (right + left) / 2, (right - left) / B
    end = body.truth().pose
    assert end.x == pytest.approx(x + v / w * (sin(yaw + w * seconds) - sin(yaw)),
                                  abs=1e-7)
    assert end.y == pytest.approx(y - v / w * (cos(yaw + w * seconds) - cos(yaw)),
                                  abs=1e-7)
    assert remainder(end.yaw - yaw - w * seconds, tau) == pytest.approx(0, abs=1e-9)


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


@pytest.mark.parametrize('dt', [-0.001, inf, nan])
def test_a_step_of_no_sensible_length_is_refused(dt):
    with pytest.raises(ValueError, match='dt is'):
        Body(World()).step(dt)


@pytest.mark.parametrize(('name', 'value'), [
    ('wheel_separation', 0.0), ('wheel_acceleration', -1.0), ('left_slip', 1.5),
    ('right_speed_gain', nan)])
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


# Wheels that do not run steadily, as those of several real robots.


def ways(seconds: int, *, seed: int = 1, cuts: int = 10, **unsteadiness: float) -> list[float]:
    """Return what a wheel travels in each second of steady driving, over what was asked."""
    body = Body(World(), config=replace(DEFAULT_BODY, encoder_tick=0.0, **unsteadiness), seed=seed)
    body.drive(right=0.2, left=0.2)
    body.step(3.0)
    found, before = [], body.truth().travelled
    for _ in range(seconds):
        for _ in range(cuts):
            body.step(1.0 / cuts)
        now = body.truth().travelled
        found.append((now - before) / 0.2)
        before = now
    return found


def test_jitter_is_what_the_mean_speed_of_a_second_strays_by():
    """Both wheels stray on their own: their mean does by less, by the root of two."""
    found = ways(400, speed_jitter=0.02)
    assert fmean(found) == pytest.approx(1.0, abs=0.003)
    assert pstdev(found) * 2 ** 0.5 == pytest.approx(0.02, rel=0.15)
    assert pstdev(b - a for a, b in pairwise(found)) == pytest.approx(0.02, rel=0.15)


def test_the_same_seed_is_the_same_robot_however_time_is_cut():
    fine, coarse = (ways(20, cuts=cuts, speed_jitter=0.02, speed_wander=0.05)
                    for cuts in (67, 4))
    assert fine == pytest.approx(coarse, abs=1e-6)
    assert fine != pytest.approx(ways(20, seed=2, speed_jitter=0.02, speed_wander=0.05), abs=1e-3)


# The gyro: an ADXRS613 on ten bits.


UNITS = 1023 / 5 * 0.0125
"""Of packet 33, for each degree a second."""
SEEDS = range(40)


def read(seed: int, rate: float, time: float = 0.0, count: int = 400) -> list[int]:
    gyro = Gyro(seed)
    return [gyro.read(radians(rate), time) for _ in range(count)]


def test_each_robot_has_another_zero_and_scale_within_the_tolerances_of_the_part():
    zeros = [mean(read(seed, 0.0)) for seed in SEEDS]
    scales = [(mean(read(seed, 100.0)) - zero) / 100 / UNITS for seed, zero in zip(SEEDS, zeros)]
    assert 490 < min(zeros) < 505 < 519 < max(zeros) < 534
    assert 0.948 < min(scales) < 0.98 < 1.02 < max(scales) < 1.052


def test_it_is_noisy_drifts_and_ends_at_its_range():
    assert stdev(read(1, 0.0)) == pytest.approx(1.0, abs=0.2)
    drift = (mean(read(1, 0.0, time=3600.0)) - mean(read(1, 0.0))) / UNITS
    assert abs(drift) == pytest.approx(0.02 * 60, abs=0.05)
    assert mean(read(1, 200.0)) == pytest.approx(mean(read(1, 150.0)), abs=0.2)
    assert mean(read(1, -200.0)) == pytest.approx(mean(read(1, -150.0)), abs=0.2)


def test_it_feels_wheels_and_hands_and_is_there_only_on_request():
    body = Body(World(), config=replace(DEFAULT_BODY, gyro=True))
    zero = body.sense().analog
    body.drive(right=0.1, left=-0.1)
    body.step(2.0)
    turning = body.sense().analog - zero
    assert turning / UNITS == pytest.approx(degrees(0.2 / 0.262), rel=0.1)
    body.drive(right=0.0, left=0.0)
    body.lift(True)
    body.push(speed=0.0, rate=-1.0, seconds=1.0)
    body.step(0.5)
    assert (body.sense().analog - zero) / UNITS == pytest.approx(-degrees(1.0), rel=0.1)
    assert Body(World(), config=DEFAULT_BODY).sense().analog == 0


# The accumulators behind packets 19 and 20, under the three roundings.


@pytest.mark.parametrize(('rounding', 'amount', 'first', 'second'), [
    # After the first reading a further 0.5 is added and read.
    (Rounding.TRUNCATE, 2.9, 2, 0), (Rounding.TRUNCATE, -2.9, -2, 0),
    (Rounding.ROUND, 2.9, 3, 1), (Rounding.ROUND, 2.4, 2, 1), (Rounding.ROUND, -2.5, -3, 1),
    (Rounding.CARRY, 2.9, 2, 1), (Rounding.CARRY, 2.4, 2, 0), (Rounding.CARRY, -2.9, -2, 0),
])
def test_a_reading_rounds_and_keeps_or_loses_the_rest(rounding, amount, first, second):
    accumulator = Accumulator(rounding)
    accumulator.add(amount)
    assert accumulator.take() == first
    accumulator.add(0.5)
    assert accumulator.take() == second


@pytest.mark.parametrize('rounding', Rounding)
@pytest.mark.parametrize(('amount', 'cap'), [(1e5, 32767), (-1e5, -32768)])
def test_what_waits_is_capped_at_16_bits(rounding, amount, cap):
    accumulator = Accumulator(rounding)
    accumulator.add(amount)
    assert accumulator.take() == cap
    assert abs(accumulator.take()) <= 0


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
    body = body_at_speed(before, before, config=replace(IDEAL, encoder_sign=sign))
    x = body.truth().pose.x
    body.drive(right=asked, left=asked)
    body.step(0.3)
    assert body.truth().speed == pytest.approx(0)
    assert (body.truth().pose.x > x) is (before > 0)
    assert body.take_distance() == counted


# Obstacles.

def test_a_wall_stops_the_robot_and_the_wheels_slip():
    body = Body(parse('wall 1 -5 1 5', 'wall'))
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
    bearing = radians(degrees)
    far = 0.165 + 0.05
    world = parse(f'post {far * cos(bearing)} {far * sin(bearing)} 0.05', 'post')
    sense = Body(world).sense()
    assert (sense.bump_left, sense.bump_right) == (left, right)


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


def test_a_held_wheel_draws_too_much_only_when_told_to_turn(body):
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
    lambda body: body.place(Pose(nan, 0, 0)),
    lambda body: body.push(speed=inf, rate=0, seconds=1),
    lambda body: body.push(speed=0, rate=0, seconds=-1),
    lambda body: body.slip(right=0, left=0, seconds=inf),
    lambda body: body.load(ld0=nan),
    lambda body: body.set_battery(temperature=inf),
    lambda body: body.force(seconds=-1, play=True)])
def test_the_outside_cannot_break_the_physics(act):
    with pytest.raises(ValueError, match='allowed'):
        act(Body(World()))


# Sensors that are held at a value, and their ranges.


def test_a_forced_sensor_can_end_by_itself_to_the_millisecond(body):
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
def test_a_value_out_of_the_manuals_range_or_of_no_sensor_is_refused(body, name, value):
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


# The battery: drain, charging states, temperature, overcurrent of the drivers.


HOUR = 3600.0


def charging(charge=0.5):
    body = Body(World())
    body.set_battery(charge=charge)
    body.plug_charger(True)
    body.step(1)
    return body


def test_the_battery_drains_while_the_robot_stands(body):
    before = body.sense().charge
    body.step(HOUR)
    assert body.sense().charge == before - 200
    assert body.sense().current == -200


def test_an_empty_battery_is_flat_and_stays_at_zero(body):
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
def test_an_overloaded_low_side_driver_limits_its_current_and_says_so(body, driver, limit):
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
