# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What ends a motion, frame by frame: the bumper, a cliff, a wheel in the air, a stall."""


import pytest

from create_oi_ros import oi
from create_oi_ros.driver.goals import Code, Phase, WallFollow
from create_oi_ros.driver.goals.goal import Hazards, Over, Stall
from create_oi_ros.driver.motion import Velocity
from create_oi_ros.odometry import Estimate
from support.views import view

BUMP = {'bumps_and_wheel_drops': int(oi.BumpsAndWheelDrops.BUMP_LEFT)}
CLIFF = {'cliff_front_right': 1}
def code(over: Over | None) -> Code:
    """Return how a motion ended; NONE if it goes on."""
    return Code.NONE if over is None else over.code


def test_a_cliff_that_comes_after_a_bump_is_new():
    hazards = Hazards()
    assert code(hazards.check(view(**BUMP), forward=False)) is Code.NONE
    assert code(hazards.check(view(**BUMP, **CLIFF), forward=False)) is Code.CLIFF


@pytest.mark.parametrize('wheel', [oi.Overcurrents.LEFT_WHEEL, oi.Overcurrents.RIGHT_WHEEL])
def test_a_wheel_that_draws_too_much_for_half_a_second_is_held(wheel):
    stall, loaded = Stall(), view(0.125, overcurrents=int(wheel))
    for _ in range(2):
        assert [code(stall.check(loaded, Velocity())) for _ in range(4)] == 4 * [Code.NONE]
        stall.check(view(0.125, overcurrents=0), Velocity())
    assert [code(stall.check(loaded, Velocity())) for _ in range(5)] == (
        4 * [Code.NONE] + [Code.STALL])


def test_low_side_drivers_that_draw_too_much_are_no_wheels():
    drivers = oi.Overcurrents.DRIVER_0 | oi.Overcurrents.DRIVER_1 | oi.Overcurrents.DRIVER_2
    stall = Stall()
    for _ in range(40):
        assert stall.check(view(overcurrents=int(drivers)), Velocity()) is None


def first_stall(told: Velocity, went: Velocity, dt: float = 0.125, frames: int = 40) -> int:
    """Return in which frame wheels count as stalled; 0: in none."""
    stall, estimate = Stall(), Estimate(linear=went.linear, angular=went.angular)
    for frame in range(1, frames + 1):
        if stall.check(view(dt, estimate=estimate), told) is not None:
            return frame
    return 0


@pytest.mark.parametrize(('told', 'went', 'frame'), [
    (Velocity(0.2, 0.0), Velocity(), 16),  # after two seconds
    (Velocity(-0.2, 0.0), Velocity(), 16),
    (Velocity(0.04, 0.0), Velocity(), 30),  # after 15 cm
    (Velocity(0.0, 0.32), Velocity(), 30), (Velocity(0.0, -0.32), Velocity(), 30),
    (Velocity(0.02, 0.16), Velocity(), 30),  # of the faster wheel
    (Velocity(0.2, 0.0), Velocity(0.0599, 0.0), 16), (Velocity(0.2, 0.0), Velocity(0.06, 0.0), 0),
    (Velocity(0.2, 0.0), Velocity(-0.06, 0.0), 0),
    (Velocity(0.0, 1.6), Velocity(0.0, 0.479), 16), (Velocity(0.0, 1.6), Velocity(0.0, -0.48), 0),
    (Velocity(0.1, 0.8), Velocity(0.03, 0.24), 0), (Velocity(), Velocity(), 0)])
def test_wheels_that_go_less_than_a_third_of_what_they_were_told_stall(told, went, frame):
    assert first_stall(told, went) == frame


def test_each_stretch_counts_anew():
    stall, told, stands = Stall(), Velocity(0.2, 0.0), Estimate()
    follows = Estimate(linear=0.2)
    for estimate in 16 * [follows] + 15 * [stands]:
        assert stall.check(view(0.125, estimate=estimate), told) is None
    assert stall.check(view(0.125, estimate=stands), told).code is Code.STALL


# Following a wall.


def follower(runtime: float = 60.0) -> WallFollow:
    """Return a goal that has begun at 0 s."""
    goal = WallFollow(-1, runtime, 0.0)
    assert goal.begin(view()) is None
    return goal


def steps(goal: WallFollow, until: float, since: float = 0.0, **readings: int):
    """Return what a goal orders, ten times a second."""
    estimate = Estimate(linear=0.15)
    return [goal.step(view(now=tick / 10, estimate=estimate, **readings))
            for tick in range(round(10 * since), round(10 * until))]


def test_before_it_sees_a_wall_it_drives_straight_on():
    goal = follower()
    assert set(steps(goal, 5.0)) == {Velocity(0.15, 0.0)}
    assert goal.progress.phase is Phase.SEARCHING


def test_it_bends_away_from_the_wall_and_back_and_round_its_end():
    goal = follower()
    assert set(steps(goal, 1.0, wall=1)) == {Velocity(0.15, 0.35)}
    assert goal.progress.phase is Phase.ENGAGED
    told = steps(goal, 6.0, since=1.0, wall=0)  # it was last seen at 0.9 s
    assert told.count(Velocity(0.15, -0.35)) == 5
    assert told[5:] == 45 * [Velocity(0.15, -0.6)]
    assert goal.progress.phase is Phase.SEARCHING


@pytest.mark.parametrize(('now', 'phase'), [(2.0, Phase.ENGAGED), (2.1, Phase.SEARCHING)])
def test_a_wall_is_followed_until_it_was_not_seen_for_two_seconds(now, phase):
    goal = follower()
    goal.step(view(now=0.0, wall=1))
    goal.step(view(now=now, wall=0))
    assert goal.progress.phase is phase


def test_at_a_touch_it_backs_off_and_turns_left():
    goal = follower()
    told = steps(goal, 0.1, **BUMP) + steps(goal, 1.0, since=0.1)
    assert told == (4 * [Velocity(-0.1, 0.0)] + 5 * [Velocity(0.0, 1.2)]
                    + [Velocity(0.15, -0.6)])
    assert goal.progress.phase is Phase.ENGAGED


def test_a_touch_while_it_backs_off_does_not_begin_that_anew():
    told = steps(follower(), 1.0, **BUMP)
    assert told[:9] == 4 * [Velocity(-0.1, 0.0)] + 5 * [Velocity(0.0, 1.2)]


def test_it_ends_after_its_time():
    goal = follower(runtime=2.0)
    *told, = steps(goal, 2.1)
    assert set(told[:-1]) == {Velocity(0.15, 0.0)}
    assert told[-1] == Over(Code.NONE, 'followed for 2 s')
