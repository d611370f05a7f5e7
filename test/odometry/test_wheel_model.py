# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How modelled wheels follow requests, against sums that are done in small steps."""

from collections.abc import Sequence
from math import exp
from typing import NamedTuple

import numpy as np
import pytest

from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.encoder_signs import LAST, NONE
from create_oi_ros.odometry.wheel_model import WheelModel
from support.ride import SLOT
from support.wheels import roll

FINE = 2e-5
"""Seconds of a small step."""
LAG, DAMPING = 0.08, 0.4
AS_ASKED = 1.0, 1.0


class Way(NamedTuple):
    """How far a wheel rolled, what its encoder counted, and its speed at the end."""

    travel: float
    counted: float
    speed: float


def track(*, spring: bool, sign: int = NONE, braking: float = 0.0, ramp: float = 0.0,
          dead_time: float = 0.0) -> WheelModel:
    """Return wheels of which one track is sure."""
    rows = Assumptions.all()
    rows.keep([next(i for i in range(len(rows.springs))
                    if rows.springs[i] == spring and rows.signs.kinds[i] == sign)])
    for index, value in {s.LAG: LAG, s.SLOW_LAG: 0.0, s.FAST_LAG: 0.0,
                         s.DEAD_TIME: dead_time, s.BRAKING: braking,
                         s.RAMP: DAMPING if spring else ramp}.items():
        rows.clear(index, value)
    wheels = WheelModel(0.0)
    wheels.spread(rows, np.full((1, s.UNKNOWNS), 1e-6))
    return wheels


def rolled(wheels: WheelModel, requests: Sequence[tuple[float, float]]) -> Way:
    """Let wheels follow requests: seconds and m/s."""
    for seconds, speed in requests:
        wheels.ask(speed, speed, [False, False])
        for _ in range(round(seconds / SLOT)):
            roll(wheels, SLOT, AS_ASKED)
    return Way(float(wheels.poses[0, 0, 0]), float(wheels.counts[0, 0, 0]),
               float(wheels.speed[0, 0, 0]))


def summed(requests: Sequence[tuple[float, float]], braking: float = 0.0, *,
           ramp: float | None = None) -> Way:
    """Return the same in small steps: of a spring, or of a lag with a bounded acceleration."""
    travel = counted = speed = rate = 0.0
    up = 1.0
    for seconds, goal in requests:
        up = float(np.sign(goal)) or up
        for _ in range(round(seconds / FINE)):
            haste = exp(braking) if (goal - speed) * speed < 0 else 1.0
            lag = LAG / haste
            omega = 2 * DAMPING / lag
            if ramp is None:
                rate += (omega ** 2 * (goal - speed) - 2 * DAMPING * omega * rate) * FINE
            else:
                most = haste / ramp if ramp else np.inf
                rate = max(-most, min(most, (goal - speed) / lag))
            speed += rate * FINE
            travel, counted = travel + speed * FINE, counted + up * abs(speed) * FINE
    return Way(travel, counted, speed)


UPS_AND_DOWNS = [(0.3, 0.3), (0.15, -0.2), (0.045, 0.1), (0.6, 0.0)]


@pytest.mark.parametrize('most', range(1, 5))
def test_a_spring_is_where_small_steps_lead(most: int) -> None:
    requests = UPS_AND_DOWNS[:most]
    way, expected = rolled(track(spring=True), requests), summed(requests)
    assert way.travel == pytest.approx(expected.travel, abs=1e-5)
    assert way.speed == pytest.approx(expected.speed, abs=2e-4)


@pytest.mark.parametrize('braking', [-1.0, 0.5])
def test_a_spring_that_brakes_in_another_way_stays_near_the_small_steps(braking: float) -> None:
    """Speed and rate turn round within a step, where it changes how fast the wheel is."""
    way = rolled(track(spring=True, braking=braking), UPS_AND_DOWNS)
    assert way.travel == pytest.approx(summed(UPS_AND_DOWNS, braking).travel, abs=5e-4)


@pytest.mark.parametrize('slots', [1, 2, 3])
@pytest.mark.parametrize('ramp', [0.0, 1.0, 3.0])
@pytest.mark.parametrize('braking', [-1.0, 0.0, 0.5])
def test_a_lag_turns_back_where_small_steps_do_however_long_its_steps(
        slots: int, ramp: float, braking: float) -> None:
    """A step of the request reaches the wheel within a step of the sums, and it stops in one."""
    wheels, dead_time = track(spring=False, braking=braking, ramp=ramp, dead_time=0.052), 0.052
    for seconds, speed in UPS_AND_DOWNS:
        wheels.ask(speed, speed, [False, False])
        for _ in range(round(seconds / SLOT)):
            wheels.wait(SLOT)
            if wheels.behind > (slots - 0.5) * SLOT:
                wheels.catch_up(slots * SLOT, AS_ASKED)
    wheels.catch_up(slots * SLOT, AS_ASKED)
    *before, (seconds, speed) = UPS_AND_DOWNS
    expected = summed([*before, (seconds - dead_time, speed)], braking, ramp=ramp)
    assert float(wheels.poses[0, 0, 0]) == pytest.approx(expected.travel, abs=5e-4)
    assert float(wheels.speed[0, 0, 0]) == pytest.approx(expected.speed, abs=1e-3)


@pytest.mark.parametrize('spring', [False, True], ids=['lag', 'spring'])
def test_a_change_of_request_costs_the_lag_whatever_happens_in_between(spring: bool) -> None:
    wheels = track(spring=spring)
    assert rolled(wheels, [(0.3, 0.3), (0.6, -0.1), (3.0, 0.2)]).travel == pytest.approx(
        0.3 * 0.3 - 0.6 * 0.1 + 3.0 * 0.2 - LAG * 0.2, abs=1e-9)
    assert wheels.settled
    assert rolled(wheels, [(3.0, 0.0)]).travel == pytest.approx(
        0.3 * 0.3 - 0.6 * 0.1 + 3.0 * 0.2, abs=1e-9)
    assert wheels.standing


def test_a_spring_that_stops_rolls_back_and_counts_that_forwards() -> None:
    requests = [(1.5, 0.3), (1.5, 0.0)]
    true, kept = (rolled(track(spring=True, sign=sign), requests) for sign in (NONE, LAST))
    assert true.counted == pytest.approx(true.travel)
    assert kept.travel == pytest.approx(true.travel)
    assert kept.counted == pytest.approx(summed(requests).counted, abs=2e-5)
    assert kept.counted > true.counted + 0.002


def test_rates_outlive_new_copies() -> None:
    """A reading within a swing changes nothing of it."""
    wheels, copied = track(spring=True), track(spring=True)
    for each in (wheels, copied):
        rolled(each, [(0.09, 0.3)])
    rows = Assumptions.all()
    rows.keep([next(i for i in range(len(rows.springs)) if rows.springs[i])])
    for index, value in {s.LAG: LAG, s.SLOW_LAG: 0.0, s.FAST_LAG: 0.0, s.DEAD_TIME: 0.0,
                         s.DAMPING: DAMPING}.items():
        rows.clear(index, value)
    rows.means[:, s.SPEEDS] = copied.speed[:, :, 0].T
    rows.rates = copied.rates
    copied.spread(rows, np.full((1, s.UNKNOWNS), 1e-6))
    for each in (wheels, copied):
        for _ in range(5):
            roll(each, SLOT, AS_ASKED)
    assert copied.speed[:, :, 0] == pytest.approx(wheels.speed[:, :, 0], abs=1e-9)
