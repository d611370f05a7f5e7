# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Simulated wheels that do not run steadily, as those of several real robots do."""

from dataclasses import replace
from itertools import pairwise
from statistics import fmean, pstdev

import pytest

from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.firmware.guesses import parse_guesses
from create_oi_ros.sim.world import World

ASKED = 0.2


def ways(seconds: int, *, seed: int = 1, cuts: int = 10, asked: float = ASKED,
         **unsteadiness: float) -> list[float]:
    """Return what a wheel travels in each second of steady driving, over what was asked."""
    body = Body(World(), config=replace(DEFAULT_BODY, encoder_tick=0.0, **unsteadiness), seed=seed)
    body.drive(right=asked, left=asked)
    body.step(3.0)
    found, before = [], body.truth().travelled
    for _ in range(seconds):
        for _ in range(cuts):
            body.step(1.0 / cuts)
        now = body.truth().travelled
        found.append((now - before) / asked)
        before = now
    return found


def test_the_likeliest_robot_runs_steadily():
    assert (DEFAULT_BODY.speed_jitter, DEFAULT_BODY.speed_wander) == (0.0, 0.0)
    assert ways(20) == pytest.approx([1.0] * 20, abs=1e-4)


def test_jitter_is_what_the_mean_speed_of_a_second_strays_by():
    """Both wheels stray on their own: their mean does by less, by the root of two."""
    found = ways(400, speed_jitter=0.02)
    assert fmean(found) == pytest.approx(1.0, abs=0.003)
    assert pstdev(found) * 2 ** 0.5 == pytest.approx(0.02, rel=0.15)
    assert pstdev(b - a for a, b in pairwise(found)) == pytest.approx(0.02, rel=0.15)


def test_wander_comes_within_half_a_minute():
    found = [ways(31, seed=seed, cuts=2, speed_wander=0.05) for seed in range(40)]
    assert pstdev(each[0] for each in found) * 2 ** 0.5 == pytest.approx(0.05, rel=0.35)
    soon = [abs(each[1] - each[0]) for each in found]
    late = [abs(each[30] - each[0]) for each in found]
    assert fmean(soon) < 0.02 < fmean(late)


def test_the_same_seed_is_the_same_robot_however_time_is_cut():
    fine, coarse = (ways(20, cuts=cuts, speed_jitter=0.02, speed_wander=0.05)
                    for cuts in (67, 4))
    assert fine == pytest.approx(coarse, abs=1e-6)
    assert fine != pytest.approx(ways(20, seed=2, speed_jitter=0.02, speed_wander=0.05), abs=1e-3)


def test_a_pushed_wheel_has_the_speed_of_the_floor():
    body = Body(World(), config=replace(DEFAULT_BODY, speed_jitter=0.1))
    body.push(speed=0.2, rate=0.0, seconds=1.0)
    body.step(0.5)
    assert body.truth().measured_travelled == pytest.approx(0.1, abs=0.001)
    assert body.truth().speed == 0.2


@pytest.mark.parametrize('name', ['speed_jitter', 'speed_wander'])
def test_it_is_a_guess_of_the_command_line(name):
    config, _ = parse_guesses([f'{name}=0.02'])
    assert getattr(config, name) == 0.02
    for value in (-0.01, 0.2):
        with pytest.raises(ValueError, match=f'{name} is {value}; allowed: 0 to 0.1'):
            parse_guesses([f'{name}={value}'])
