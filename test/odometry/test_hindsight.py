# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The past of a robot is followed again once it is known, and nothing of it is left out."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from math import inf
import random

import numpy as np
import pytest

from create_oi_ros.odometry import Geometry, hindsight, Increment, Odometry
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.filter import Filter
from create_oi_ros.odometry.hindsight import AFTER, Hindsight, LONGEST
from create_oi_ros.odometry.wheel_model import WheelModel
from support.bodies import LAGGING
from support.ride import assert_smooth, Ride, SLOT

SLOW_BRAKES = replace(LAGGING, braking=0.31, dead_time=0.084)
SPEEDS = -0.3, 0.0, 0.2, 0.4
DRIVES = 16


def play(ride: Ride, seed: int, seconds: int) -> None:
    """Drive at random, a new speed each second, and come to rest."""
    chance = random.Random(seed)
    for _ in range(seconds):
        ride.go(1, chance.choice(SPEEDS), chance.choice(SPEEDS))
    ride.go(3)


def test_what_went_wrong_before_a_robot_was_known_is_put_right(monkeypatch):
    missed = []
    for after in (AFTER, (inf,)):
        monkeypatch.setattr(hindsight, 'AFTER', after)
        for seed in range(DRIVES):
            ride = Ride(config=SLOW_BRAKES)
            play(ride, seed, 150)
            assert_smooth(ride.estimates)
            missed.append(ride.miss[1])
    assert sum(missed[:DRIVES]) < sum(missed[DRIVES:]) / 2


TURNING = Increment(dt=SLOT, right=0.2, left=0.1, driven=True)
STANDING = Increment(dt=SLOT, right=0.0, left=0.0, driven=True)
FRAMES = [TURNING] * 90 + [TURNING._replace(distance=180, angle=28)]
STILL = [STANDING] * 70 + [STANDING._replace(distance=10, angle=0)]


def told(now: Filter, events: list[Increment | Callable[[Filter], None]]) -> Hindsight:
    """Tell a filter what happens, and return what keeps it."""
    kept = Hindsight(Geometry())
    tell(now, events)
    for event in events:
        kept.note(event)
    return kept


def tell(now: Filter, events: list[Increment | Callable[[Filter], None]]) -> None:
    """Tell a filter what happens."""
    for event in events:
        if isinstance(event, Increment):
            now.move(event)
            now.read(event)
        else:
            event(now)


def caught_up(kept: Hindsight, now: Filter) -> Filter:
    """Return the filter that has followed all again."""
    for _ in range(5000):
        if other := kept.step(now):
            return other
    raise AssertionError('it never came to the present')


@pytest.mark.parametrize('event', [
    Filter.reset, Filter.interrupted, Filter.recounted, Filter.asked, Filter.unanswered])
def test_the_past_is_followed_as_it_was(monkeypatch, event):
    monkeypatch.setattr(hindsight, 'AFTER', (3.0,))
    events = FRAMES + STILL + [event] + FRAMES + STILL + FRAMES + STILL * 2
    first, again = Filter(Geometry()), Filter(Geometry())
    kept = told(first, events)
    again.tracks.rows = first.tracks.rows.afresh()
    again.tracks._open_window()
    tell(again, events)
    other = caught_up(kept, first)
    assert other.tracks.pose() == pytest.approx(again.tracks.pose(), abs=1e-6)
    assert other.tracks.held == pytest.approx(again.tracks.held, abs=1e-6)
    assert other.tracks.roundings == again.tracks.roundings
    assert other.tracks.requests == (0.0, 0.0)
    assert kept.over


def test_of_what_makes_new_copies_no_more_is_followed_in_a_frame_than_one(monkeypatch):
    starting = [STANDING._replace(right=speed, left=speed) for speed in (0.01, 0.2, 0.01, 0.0)]
    now = Filter(Geometry())
    kept = told(now, FRAMES + (starting + STILL) * 5)
    kept._driven = AFTER[0]
    made: list[int] = []
    spread = WheelModel.spread

    def counted(self, *args, **kwargs):
        made[-1] += 1
        spread(self, *args, **kwargs)
    monkeypatch.setattr(WheelModel, 'spread', counted)
    made.append(-1)  # with the filter itself
    while not kept.step(now):
        made.append(0)
    assert max(made) == 1
    assert sum(made) > 5 * 3


def test_nobody_looks_back_before_the_robot_is_known():
    now = Filter(Geometry())
    kept = told(now, FRAMES + STILL)
    assert all(kept.step(now) is None for _ in range(1000))
    assert not kept.over
    kept._driven = AFTER[0]
    now.tracks.rows.doubt += 10.0
    assert all(kept.step(now) is None for _ in range(1000))
    now.tracks.rows.doubt -= 10.0
    assert caught_up(kept, now).tracks.rows.readings > 0
    for driven in AFTER[1:]:
        assert not kept.over
        assert all(kept.step(now) is None for _ in range(1000))
        kept._driven = driven
        caught_up(kept, now)
    assert kept.over


def test_a_robot_that_must_be_known_anew_is_looked_back_at_anew():
    now = Filter(Geometry())
    kept = told(now, FRAMES + STILL)
    kept._driven = AFTER[0]
    now = caught_up(kept, now)
    assert kept.step(now) is None
    now.tracks.rows.readings = 0
    assert kept.step(now) is None
    now.tracks.rows.readings = 3
    assert all(kept.step(now) is None for _ in range(1000))
    kept._driven = AFTER[0]
    caught_up(kept, now)
    assert not kept.over


def test_a_filter_that_has_taken_over_with_fewer_readings_is_not_new():
    now = Filter(Geometry())
    kept = told(now, FRAMES + STILL)
    kept._driven = AFTER[0]
    now.tracks.rows.readings += 1  # one was not believed when it came again
    other = caught_up(kept, now)
    assert other.tracks.rows.readings < now.tracks.rows.readings
    for driven in AFTER[1:]:
        kept._driven = driven
        other = caught_up(kept, other)
    assert kept.over


def test_a_past_that_is_too_long_is_given_up():
    kept = Hindsight(Geometry())
    for number in range(LONGEST):
        for _ in range(2):
            kept.note(TURNING._replace(right=number * 1e-5))
    assert not kept.over
    kept.note(Filter.asked)
    assert kept.over


def test_a_robot_that_is_known_or_believed_has_no_past():
    ride = Ride()
    ride.learn()
    known = ride.odometry.knowledge
    assert Odometry(window=1.0)._hindsight is not None
    assert Odometry(window=1.0, robot=known)._hindsight is None
    assert Odometry(window=0.0)._hindsight is None


def test_a_goal_that_runs_is_let_finish(monkeypatch):
    monkeypatch.setattr(hindsight, 'AFTER', (20.0,))
    ride = Ride()
    ride.odometry.mark()
    first = ride.odometry._filter
    ride.learn()
    ride.learn()
    assert ride.odometry._filter is first
    ride.odometry.unmark()
    ride.go(30, 0.1, 0.1)
    assert ride.odometry._filter is not first
    assert ride.odometry._hindsight is None


def test_tracks_afresh_know_the_wheels_and_nothing_else():
    rows = Assumptions.all()
    rows.keep([0, 3])
    rows.means[:, s.GAIN_RIGHT], rows.means[:, s.X], rows.doubt[:] = 0.97, 2.0, 4.0
    rows.weights, rows.readings = np.array([0.9, 0.1]), 50
    prior = rows.p[0, s.LAG, s.LAG]
    rows.clear(s.GAIN_RIGHT, 0.97, 1e-8)
    before = deepcopy(rows.means)
    afresh = rows.afresh()
    kinds = {(rounding, int(kind), bool(late)) for rounding, kind, late in
             zip(afresh.roundings, afresh.signs.kinds, afresh.signs.late)}
    assert len(afresh.roundings) == 16 and len(kinds) == 15
    assert afresh.springs.tolist() == [False, True] + [False] * 14
    assert (afresh.means[:, s.GAIN_RIGHT] == 0.97).all()
    assert afresh.p[:, s.GAIN_RIGHT, s.GAIN_RIGHT] == pytest.approx(1e-8 / 0.45, rel=1e-3)
    assert afresh.p[0, s.LAG, s.LAG] == pytest.approx(prior)
    assert not afresh.means[:, s.X:].any() and not afresh.p[:, s.X:].any()
    assert afresh.weights[:2] == pytest.approx(afresh.weights[0])
    assert afresh.weights[2:] == pytest.approx(1e-3 * afresh.weights[0])
    assert (afresh.doubt == 1.0).all() and afresh.readings == 0
    assert np.linalg.eigvalsh(afresh.p).min() > -1e-12
    assert (rows.means == before).all()
