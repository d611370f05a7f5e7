# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The laws of odometry: no step, honest covariance, exact where the robot is exact."""

from collections.abc import Iterator
from dataclasses import replace
from math import atan2, cos, degrees, radians, sin, tau
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros.odometry import Increment, Odometry
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import IDEAL, Response, TimeConstant
from support.bodies import LAGGING
from support.ride import assert_smooth, assert_sound, LESSON, Request, Ride, ROUNDINGS, SLOT

WHEEL = st.integers(-500, 500).map(lambda mm: mm / 1000)
REQUESTS = st.lists(st.tuples(st.sampled_from((0.03, 0.3, 1.5)), WHEEL, WHEEL), max_size=12)


@given(REQUESTS, st.sampled_from(ROUNDINGS), st.sampled_from((0.25, 1.0, 3.0)))
@settings(max_examples=40, deadline=None)
def test_never_jumps_and_always_knows_how_sure_it_is(
        requests: list[Request], rounding: Rounding, window: float) -> None:
    ride = Ride(rounding, window=window)
    for seconds, right, left in requests:
        ride.go(seconds, right, left)
    assert_smooth(ride.estimates)
    for estimate in ride.estimates:
        assert_sound(estimate)


READINGS = st.none() | st.tuples(st.integers(-32768, 32767), st.integers(-32768, 32767))
FRAMES = st.lists(st.tuples(
    st.sampled_from((1, 1, 1, 2, 50)), WHEEL, WHEEL, st.booleans(), st.booleans(), READINGS,
    st.sampled_from(('', '', '', 'interrupted', 'reset'))), max_size=60)


@given(FRAMES, st.sampled_from((0.0, 1.0)))
@settings(max_examples=60, deadline=None)
def test_survives_whatever_a_robot_may_say(frames: list, window: float) -> None:
    odometry = Odometry(window=window)
    for slots, right, left, driven, lifted, reading, event in frames:
        if event:
            getattr(odometry, event)()
        before = odometry.estimate
        distance, angle = reading or (None, None)
        after = odometry.update(Increment(
            dt=slots * SLOT, right=right, left=left, driven=driven, lifted=lifted,
            distance=distance, angle=angle))
        assert_sound(after)
        if window:
            assert_smooth([before, after], slots * SLOT)


@pytest.mark.parametrize('rounding', ROUNDINGS)
@pytest.mark.parametrize(('speed', 'seconds'), [(0.02, 60), (0.2, 20), (-0.2, 20), (0.5, 10)])
def test_a_straight_line_is_exact(rounding: Rounding, speed: float, seconds: float) -> None:
    """As far as the numbers can tell: at 200 mm/s and even slots nothing is ever dropped."""
    ride = Ride(rounding)
    ride.go(seconds, speed, speed)
    ride.go(3)
    assert ride.miss[0] < 3e-3 + 0.003 * abs(speed * seconds)
    assert ride.miss[1] < 0.3


@pytest.mark.parametrize('rounding', ROUNDINGS)
@pytest.mark.parametrize(
    ('right', 'left'), [(0.213, 0.146), (0.097, -0.103), (0.014, -0.014), (-0.31, -0.197)])
def test_a_circle_is_exact(rounding: Rounding, right: float, left: float) -> None:
    ride = Ride(rounding)
    ride.learn()
    ride.begin()
    ride.go(60, right, left)
    ride.go(3)
    far, turned = ride.went
    assert ride.miss[1] < 2 + 0.6 * abs(turned) / tau
    assert ride.miss[0] < 0.01 + 0.02 * abs(far)


def test_slow_turns_register() -> None:
    """Read in every frame, a robot that truncates never reports a turn of 10 degrees a second."""
    plain, ours = Ride(window=0.0), Ride()
    for ride in (plain, ours):
        ride.go(20, 0.0225, -0.0225)
        ride.go(3)
    assert plain.miss[1] > 190
    assert ours.miss[1] < 2


@pytest.mark.parametrize('rounding', ROUNDINGS)
def test_a_mixed_drive_stays_close(rounding: Rounding) -> None:
    ride = Ride(rounding, config=replace(IDEAL, right_speed_gain=1.03, left_speed_gain=0.98))
    for right, left in [(0.3, 0.2), (0.1, -0.1), (0.0, 0.0), (-0.2, -0.15), (0.45, 0.5)] * 5:
        ride.go(2.1, right, left)
    ride.go(3)
    assert ride.miss[1] < 6  # of more than 1800
    assert ride.miss[0] < 0.25  # of 12 m


@pytest.mark.parametrize('frame', [2, 3])
def test_cutting_the_same_motion_into_other_frames_changes_nothing(frame: int) -> None:
    fine, coarse = Ride(), Ride(frame=frame)
    for ride in (fine, coarse):
        ride.go(6, 0.3, 0.2)
        ride.go(3)
    a, b = fine.estimates[-1], coarse.estimates[-1]
    assert (a.x, a.y) == pytest.approx((b.x, b.y), abs=0.03)  # of 1.5 m
    assert a.yaw == pytest.approx(b.yaw, abs=radians(3))  # of 133 degrees


@given(st.lists(st.integers(1, 40), min_size=1, max_size=20))
@settings(max_examples=30, deadline=None)
def test_prediction_does_not_depend_on_how_time_is_cut(cuts: list[int]) -> None:
    whole, cut = Odometry(window=1e6), Odometry(window=1e6)
    for odometry in (whole, cut):
        odometry.update(Increment(dt=SLOT, right=0.4, left=0.1, driven=True))
        # The rest begins with both wheels at their goals and corrections blended in.
        for _ in range(200):
            odometry.update(Increment(dt=SLOT, right=0.4, left=0.1, driven=True))
    for slots in cuts:
        cut.update(Increment(dt=slots * SLOT, right=0.4, left=0.1, driven=True))
    for _ in range(sum(cuts)):
        whole.update(Increment(dt=SLOT, right=0.4, left=0.1, driven=True))
    a, b = whole.estimate, cut.estimate
    assert (a.x, a.y, a.yaw) == pytest.approx((b.x, b.y, b.yaw), abs=1e-4)


def test_rest_costs_no_certainty_and_motion_does() -> None:
    ride = Ride()
    ride.go(5, 0.2, 0.1)
    moved = ride.go(5).pose_covariance
    rested = ride.go(60).pose_covariance
    assert all(rested[i] < 1.001 * moved[i] + 1e-8 for i in (0, 4, 8))  # readings still teach
    assert ride.go(300, 0.2, 0.1).pose_covariance[8] > rested[8]


@pytest.mark.parametrize('right', [0.03, 0.2])
@pytest.mark.parametrize('dead_time', [0.03, 0.06])
@pytest.mark.parametrize('response', [
    {'time_constant': TimeConstant(0.12)}, {'time_constant': TimeConstant(0.25)},
    {'response': Response.RAMP, 'wheel_acceleration': 0.7},
    {'response': Response.RAMP, 'wheel_acceleration': 2.0},
    {'response': Response.SECOND_ORDER, 'time_constant': TimeConstant(0.15)}])
def test_a_new_robot_is_doubted_as_soon_as_it_moves(
        response: dict[str, Any], dead_time: float, right: float) -> None:
    """Nobody knows how soon its wheels follow; at no moment is it farther off than it says."""
    ride = Ride(config=replace(LAGGING, dead_time=dead_time, **response))
    ride.go(2)
    for seconds, forth, left in ((0.5, right, -0.3), (0.8, -right, 0.3), (0.7, 0.0, 0.0)):
        for _ in range(round(seconds / SLOT)):
            estimate = ride.go(SLOT, forth, left)
            off = radians(ride.miss[1])
            assert abs(off) < 4 * estimate.pose_covariance[8] ** 0.5 + radians(0.1)


def test_the_covariance_of_a_robot_that_is_not_known_follows_its_wheels() -> None:
    ride = Ride()
    for right, left in LESSON:
        ride.go(2, right, left)
    ride.go(3)
    assert ride.odometry.tracks.rows.readings > 15
    deviations = {
        round(degrees(ride.go(SLOT, 0.2, -0.3).pose_covariance[8] ** 0.5), 2) for _ in range(30)}
    assert len(deviations) > 5


def asked(odometry: Odometry, frames: int) -> Iterator[bool]:
    """Yield after every frame at rest whether a reading is due; none ever comes."""
    for _ in range(frames):
        odometry.update(Increment(dt=SLOT, right=0.0, left=0.0, driven=True))
        yield odometry.reading_due


def test_asks_once_a_window_for_one_frame_and_again_when_no_answer_comes() -> None:
    ride = Ride()
    ride.go(5)
    questions = []
    for _ in range(400):
        ride.go(SLOT)
        questions.append(ride.odometry.reading_due)
    assert 3 <= sum(questions) <= 12
    assert not any(a and b for a, b in zip(questions, questions[1:]))
    assert sum(asked(Odometry(window=1.0), 200)) > 10


class Wakeful(Odometry):
    """Looks at each frame of a robot that rests as closely as at any other."""

    def _count(self, increment: Increment) -> None:
        if increment.right or increment.left:
            super()._count(increment)


class Watchful(Odometry):
    """Looks at each frame as closely as at any other."""

    def _count(self, increment: Increment) -> None:
        pass


@pytest.mark.parametrize('event', ['', 'interrupted', 'hurry', 'mark', 'reset'])
def test_frames_of_a_robot_that_rests_are_left_out_and_nothing_is_lost(event: str) -> None:
    rides, due = [], []
    for kind in (Odometry, Wakeful):
        ride = Ride(config=LAGGING)
        ride.odometry = kind(window=1.0)
        told = []
        for seconds, right, left in [(3, 0.2, 0.1), (7.4, 0, 0), (2, -0.1, 0.1), (9.13, 0, 0)] * 2:
            ride.go(seconds, right, left)
            for _ in range(100):
                ride.go(SLOT, right, left)
                told.append(ride.odometry.reading_due)
        if event:
            getattr(ride.odometry, event)()
        ride.go(3, 0.1, 0.2)
        rides.append(ride)
        due.append(told)
    assert due[0] == due[1]
    assert sum(due[0]) > 3
    assert rides[0].estimates == rides[1].estimates


@pytest.mark.parametrize('rounding', ROUNDINGS)
def test_frames_of_steady_motion_are_left_out_and_hardly_anything_is_lost(
        rounding: Rounding) -> None:
    rides = [Ride(rounding, config=LAGGING) for _ in range(2)]
    for ride, kind in zip(rides, (Odometry, Watchful)):
        ride.odometry = kind(window=1.0)
    due: list[list[bool]] = [[], []]
    for seconds, right, left in [(20, 0.2, 0.1), (9, -0.1, 0.1), (15, 0.15, 0.15)]:
        for _ in range(round(seconds / SLOT)):
            for ride, told in zip(rides, due):
                ride.go(SLOT, right, left)
                told.append(ride.odometry.reading_due)
    fast, close = rides
    assert due[0] == due[1] and sum(due[0]) > 20
    for one, other in zip(fast.estimates, close.estimates):
        assert one[:3] == pytest.approx(other[:3], abs=2e-4)
        assert one[3:5] == pytest.approx(other[3:5], abs=1e-3)
        assert one.pose_covariance == pytest.approx(other.pose_covariance, rel=0.01, abs=1e-7)
        assert one[-4:] == pytest.approx(other[-4:], abs=0.01)
    assert_smooth(fast.estimates)


@pytest.mark.parametrize('event', ['interrupted', 'hurry', 'mark', 'reset'])
def test_steady_motion_that_was_only_counted_is_there_when_something_happens(event: str) -> None:
    rides = [Ride(config=LAGGING) for _ in range(2)]
    for ride, kind in zip(rides, (Odometry, Watchful)):
        ride.odometry = kind(window=1.0)
        ride.go(13, 0.2, 0.1)
        while ride.odometry.reading_due:
            ride.go(SLOT, 0.2, 0.1)
        ride.go(25 * SLOT, 0.2, 0.1)
        getattr(ride.odometry, event)()
        ride.go(0.6, 0.2, 0.1)
    for one, other in zip(*(ride.estimates for ride in rides)):
        assert one[:5] == pytest.approx(other[:5], abs=3e-4)


def test_without_a_window_it_asks_in_every_frame_and_believes_the_robot() -> None:
    odometry = Odometry(window=0.0)
    assert all(asked(odometry, 5))
    for _ in range(11):
        estimate = odometry.update(Increment(
            dt=SLOT, right=0.4, left=0.4, driven=True, distance=6, angle=0))
    assert estimate.x == pytest.approx(0.060)  # the first reading is discarded
    assert estimate.linear == pytest.approx(0.4)


def test_heading_and_course_agree() -> None:
    ride = Ride()
    ride.go(5, 0.2, 0.2)
    ride.go(2, 0.1, -0.1)
    a = ride.go(3, 0.2, 0.2)
    b = ride.go(2, 0.2, 0.2)
    course = atan2(b.y - a.y, b.x - a.x)
    assert cos(course - b.yaw) > cos(radians(2))
    assert abs(sin(course - b.yaw)) < sin(radians(2))
