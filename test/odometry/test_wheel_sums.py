# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps of modelled wheels, by sums done by hand; copies that are off in one unknown."""

from collections.abc import Mapping
from math import cos, exp, log, sin

import numpy as np
import pytest

from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.encoder_signs import LAST, NONE, UPWARD
from create_oi_ros.odometry.wheel_model import WheelModel
from create_oi_ros.robot import FIRMWARE_SEPARATION
from support.wheels import roll

AS_COUNTED = 1.0, 1.0
H = 0.03
PLAIN = {s.LAG: 0.08, s.SLOW_LAG: 0.0, s.FAST_LAG: 0.0, s.DEAD_TIME: 0.0, s.BRAKING: 0.0,
         s.RAMP: 0.0}
STEP = 1e-3


def rows_of(unknowns: Mapping[int, float], kind: int = NONE, late: bool = False,
            spring: bool = False) -> Assumptions:
    """Return one track that believes these."""
    rows = Assumptions.all()
    rows.keep([next(i for i in range(len(rows.springs))
                    if rows.springs[i] == spring and rows.signs.kinds[i] == kind
                    and bool(rows.signs.late[i]) == late)])
    for index, value in {**PLAIN, **unknowns}.items():
        rows.clear(index, value)
    return rows


def wheels(unknowns: Mapping[int, float], slowest: float = 0.0, **kind) -> WheelModel:
    """Return wheels of which one track believes these."""
    made = WheelModel(slowest)
    made.spread(rows_of(unknowns, **kind), np.full((1, s.UNKNOWNS), STEP))
    return made


def asked(made: WheelModel, right: float, left: float, *steps: float) -> WheelModel:
    """Let wheels follow a request for some steps, seconds each."""
    made.ask(right, left, [False, False])
    for seconds in steps:
        roll(made, seconds, AS_COUNTED)
    return made


def speeds(made: WheelModel) -> list[float]:
    """Return the speeds of both wheels."""
    return made.speed[:, 0, 0].tolist()


def test_gains_and_offsets_make_goals_and_offsets_fade_towards_zero():
    believed = {s.GAIN_RIGHT: 1.1, s.GAIN_LEFT: 0.9, s.OFFSET_RIGHT: 0.01, s.OFFSET_LEFT: -0.02}
    for request, whole in ((0.2, 1.0), (0.005, 1.0), (0.0025, 0.5), (-0.0025, -0.5), (-0.2, -1.0),
                           (0.0, 0.0)):
        made = asked(wheels(believed), request, request, *(400 * [H]))
        assert speeds(made) == pytest.approx(
            [1.1 * request + 0.01 * whole, 0.9 * request - 0.02 * whole])
        assert made.settled and made.standing == (request == 0)


@pytest.mark.parametrize(('speed', 'part'), [
    (0.05, 1.5), (0.02, 1.5), (0.06, 1 + 0.5 * 0.5128205), (0.076, 1.0),
    (0.2, 1 - 0.25 * 0.7311321), (0.5, 0.75)])
def test_a_lag_shrinks_the_way_by_a_part_that_depends_on_the_speed(speed, part):
    made = asked(wheels({s.SLOW_LAG: 0.5, s.FAST_LAG: 0.25}), speed, -speed, H)
    lag = 0.08 * part
    assert speeds(made) == pytest.approx(
        [speed * (1 - exp(-H / lag)), -speed * (1 - exp(-H / lag))], rel=1e-6)
    way = speed * H - speed * (1 - exp(-H / lag)) * lag
    assert made.path[:, 0].tolist() == pytest.approx([way, way], rel=1e-6)


def test_a_lag_is_never_shorter_than_a_twentieth_nor_than_four_milliseconds():
    for believed, lag in (({s.FAST_LAG: 2.0}, 0.004), ({s.LAG: 0.4, s.FAST_LAG: 2.0}, 0.02),
                          ({s.LAG: 0.001}, 0.004)):
        made = asked(wheels(believed), 0.5, 0.5, 0.01)
        assert speeds(made)[0] == pytest.approx(0.5 * (1 - exp(-0.01 / lag)))


@pytest.mark.parametrize(('seconds', 'speed', 'travel'), [
    (0.03, 0.015, 0.000225), (0.52, 0.26, 0.25 * 0.52 ** 2),
    (0.6, 0.3 - 0.04 * exp(-1), 0.25 * 0.52 ** 2 + 0.3 * 0.08 - 0.04 * 0.08 * (1 - exp(-1)))])
def test_a_bounded_acceleration_ends_as_a_lag(seconds, speed, travel):
    """Half a metre per second squared, until what is left is what a lag of 0.08 s leaves."""
    for sign in (1, -1):
        made = asked(wheels({s.RAMP: 2.0}), sign * 0.3, sign * 0.3, seconds)
        assert speeds(made)[0] == pytest.approx(sign * speed)
        assert made.poses[0, 0, 0] == pytest.approx(sign * travel)


def test_brakes_may_be_quicker():
    for ramp, quick in ((0.0, 0.5 * 0.08), (2.0, 0.0)):
        made = wheels({s.BRAKING: log(2), s.RAMP: ramp, s.SPEED_RIGHT: 0.4, s.SPEED_LEFT: 0.1})
        asked(made, 0.1, 0.4, H)
        if ramp:  # 1 m/s² down, 0.5 up
            assert speeds(made) == pytest.approx([0.4 - 1.0 * H, 0.1 + 0.5 * H])
        else:
            assert speeds(made) == pytest.approx([
                0.1 + 0.3 * exp(-H / quick), 0.4 - 0.3 * exp(-H / 0.08)])


def test_a_wheel_that_starts_to_run_does_not_brake():
    made = asked(wheels({s.BRAKING: log(2), s.RAMP: 2.0}), 0.3, -0.3, H)
    assert speeds(made) == pytest.approx([0.5 * H, -0.5 * H])


def test_a_request_reaches_wheels_after_the_dead_time():
    made = asked(wheels({s.DEAD_TIME: 0.05}), 0.3, 0.3, H)
    assert speeds(made) == [0.0, 0.0]
    roll(made, H, AS_COUNTED)
    assert speeds(made)[0] == pytest.approx(0.3 * (1 - exp(-(2 * H - 0.05) / 0.08)))


def test_slow_requests_move_wheels_by_the_part_that_is_believed():
    for speed, moved in ((0.019, 0.25), (0.021, 1.0)):
        made = wheels({s.MOVES_RIGHT: 0.25}, slowest=0.02)
        asked(made, speed, speed, *(400 * [H]))
        assert speeds(made) == pytest.approx([moved * speed, speed])


def test_poses_follow_arcs_with_the_scales_of_true_motion():
    believed = {s.SPEED_RIGHT: 0.3, s.SPEED_LEFT: 0.1, s.SEPARATION: 0.05, s.YAW: 0.4, s.X: 1.0,
                s.Y: 2.0}
    made = wheels(believed)
    made.free = True
    for settled in (False, True):
        made.settled = settled
        x, y, yaw = made.poses[:, 0, 0]
        roll(made, 2.0, (1.1, 0.9))
        turn = 0.4 / (FIRMWARE_SEPARATION * 1.05)
        chord = 0.4 * 1.1 * (sin(0.45 * turn) / (0.45 * turn) if settled else 1.0)
        assert made.poses[:, 0, 0].tolist() == pytest.approx([
            x + chord * cos(yaw + 0.45 * turn), y + chord * sin(yaw + 0.45 * turn),
            yaw + 0.9 * turn])
    assert made.counts[:, 0, 0].tolist() == pytest.approx([0.8, 2 * turn])
    assert made.path[:, 0].tolist() == pytest.approx([1.2, 0.4])
    assert not made.miscounted.any()


def test_wheels_that_arrive_are_put_at_their_goals_and_nothing_of_the_way_is_lost():
    made = asked(wheels({}), 0.2, 0.1, *(14 * [H]))
    assert not made.settled
    for _ in range(26):
        roll(made, H, AS_COUNTED)
    assert made.settled and speeds(made) == pytest.approx([0.2, 0.1], rel=1e-12)
    lags = made._lag[:, 0, 0]
    assert made.path[:, 0] == pytest.approx(np.array([0.2, 0.1]) * (1.2 - lags))


@pytest.mark.parametrize(('kind', 'late', 'request_', 'sign'), [
    (NONE, False, -0.3, 1), (LAST, False, -0.3, -1), (LAST, True, -0.3, 1),
    (UPWARD, False, -0.3, -1), (UPWARD, True, -0.3, 1), (UPWARD, False, 0.0, 1),
    (LAST, False, 0.0, 1)])
def test_an_encoder_takes_its_sign_from_where_its_track_says(kind, late, request_, sign):
    """Within the dead time the wheels go on as before."""
    made = wheels({s.DEAD_TIME: 0.2}, kind=kind, late=late)
    asked(made, 0.3, 0.3, *(40 * [H]))
    before, path = made.counts[0, 0, 0], made.path[0, 0]
    asked(made, request_, request_, H)
    went = made.path[0, 0] - path
    assert went == pytest.approx(0.3 * H, rel=1e-3)
    assert made.counts[0, 0, 0] - before == pytest.approx(sign * went)
    assert made.miscounted[0, 0] == pytest.approx(went - sign * went)
    changed = {NONE: False, LAST: request_ < 0, UPWARD: request_ < 0}[kind]
    assert made.turned[0, 0] == pytest.approx(0.09 * changed, rel=1e-3)


@pytest.mark.parametrize('spring', [False, True], ids=['lag', 'spring'])
@pytest.mark.parametrize('kind', [(NONE, False), (LAST, True), (UPWARD, False)])
def test_each_copy_is_a_track_that_is_off_in_one_unknown(spring, kind):
    believed = {
        s.GAIN_RIGHT: 1.1, s.OFFSET_LEFT: 0.003, s.DEAD_TIME: 0.04,
        s.RAMP: 0.5 if spring else 1.0, s.BRAKING: 0.2, s.MOVES_LEFT: 0.5,
        s.SPEED_RIGHT: 0.1, s.SPEED_LEFT: -0.1}

    def ride(made: WheelModel) -> np.ndarray:
        for right, left, steps in ((0.3, 0.05, 4), (-0.2, 0.01, 5), (0.0, 0.2, 30)):
            asked(made, right, left, *(steps * [H]))
        return np.concatenate([made.speed, made.poses, made.counts])[:, 0]
    options = {'slowest': 0.02, 'kind': kind[0], 'late': kind[1], 'spring': spring}
    copies = ride(wheels(believed, **options))
    for unknown in range(s.UNKNOWNS):
        base = {**PLAIN, **{index: prior.mean for index, prior in s.COMMON.items()}, **believed}
        off = {**base, unknown: base[unknown] + STEP}
        # Lags are those at the speeds of the track itself, also in its copies.
        assert copies[:, unknown + 1] == pytest.approx(
            ride(wheels(off, **options))[:, 0], abs=2e-6)
