# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""When the robot is asked for distance and angle, frame by frame."""

from collections.abc import Iterable
from types import SimpleNamespace

import pytest

from create_oi_ros.odometry.reading_plan import ReadingPlan
from create_oi_ros.robot import Rounding

DT = 0.01
EVEN = 0.1, 0.0
"""Rates at which each frame gains a whole millimetre: no rounding loses any."""


def believed(**more: object) -> SimpleNamespace:
    """Return what tracks say of a robot that is new and drives; of it, what a plan asks for."""
    return SimpleNamespace(**{
        'is_free': False, 'blur': 0.0, 'known': 0.0, 'rests': False, 'settled': True,
        'roundings': {Rounding.CARRY}, 'rates': EVEN, **more})


def first_due(plan: ReadingPlan, tracks: SimpleNamespace, *, steady: bool = True) -> float:
    """Let frames pass until a reading is due; return how many seconds that took."""
    for frame in range(1, 3000):
        plan.step(DT, steady=steady, tracks=tracks)
        if plan.due:
            return frame * DT
    return 0.0


def read(window: float = 1.0, times: int = 1) -> ReadingPlan:
    """Return a plan after so many readings; how many sets how far waits vary."""
    plan = ReadingPlan(window)
    for _ in range(times):
        plan.came()
    return plan


FIRST = 0.8 + 0.4 * 0.618
"""Factor by which waits are varied after the first reading."""


@pytest.mark.parametrize(('tracks', 'seconds'), [
    (believed(is_free=True), 0.5), (believed(is_free=True, blur=9.0), 0.5),
    (believed(blur=1.61), 0.4), (believed(blur=1.81, known=0.5), 0.4),
    (believed(blur=2.01, known=1.0), 0.4), (believed(rests=True), 1.0 * FIRST),
    (believed(rests=True, known=1.0), 1.0 * FIRST)])
def test_how_long_it_waits_while_nothing_is_asked(tracks, seconds):
    for window in (1.0, 2.5):
        plan = read(window)
        for _ in range(1):
            assert first_due(plan, tracks) == pytest.approx(seconds * window, abs=DT)


@pytest.mark.parametrize(('blur', 'known'), [(1.59, 0.0), (1.79, 0.5), (1.99, 1.0)])
def test_a_robot_is_asked_no_earlier_below_its_limit_of_doubt(blur, known):
    blurred = first_due(read(), believed(blur=blur, known=known))
    assert blurred == first_due(read(), believed(known=known)) > 0.4


@pytest.mark.parametrize(('known', 'seconds'), [(0.0, 2.0), (0.5, 4.0), (1.0, 6.0)])
def test_while_requests_change_it_waits_for_two_windows_and_longer_when_it_knows(known, seconds):
    assert first_due(read(), believed(known=known), steady=False) == pytest.approx(seconds, abs=DT)


@pytest.mark.parametrize(('known', 'longest'), [(0.0, 2.0), (0.5, 4.5), (1.0, 7.0)])
def test_the_longer_requests_stay_the_longer_it_waits_up_to_a_limit(known, longest):
    plan, tracks, waits = read(), believed(known=known), []
    shortest = 0.7 * (1 + 2 * known)
    for number in range(1, 13):
        before = plan._steady
        waited = first_due(plan, tracks)
        plan.came()
        factor = 0.8 + 0.4 * (number * 0.618 % 1)
        wait = min(longest, max(shortest, 0.8 * (before + waited)))
        assert waited == pytest.approx(wait * factor, abs=2 * DT)
        waits.append(wait)
    assert waits[0] == pytest.approx(shortest, rel=0.7)
    assert waits[-1] == longest


def test_soon_after_a_change_it_waits_as_if_requests_changed():
    """Wheels follow within 0.45 s; a reading before that tells little."""
    plan = read()
    plan.step(1.9, steady=False, tracks=believed())
    assert not plan.due
    for steady in (0.1, 0.3):
        plan.step(steady / 100, steady=True, tracks=believed())
        assert not plan.due
    for _ in range(45):
        plan.step(DT, steady=True, tracks=believed())
        if plan.due:
            break
    assert plan._age == pytest.approx(2.0, abs=2 * DT)


def answered_after(frames: int) -> list[bool]:
    """Return in which frames a reading is due when its answer comes after so many."""
    plan, tracks, due = ReadingPlan(0.05), believed(is_free=True), []
    plan.step(1.0, steady=True, tracks=tracks)
    for frame in range(1, 20):
        if frame == frames:
            plan.came()
        plan.step(DT, steady=True, tracks=tracks)
        due.append(plan.due)
    return due


def test_a_reading_is_asked_for_once_while_the_answer_is_under_way_and_again_after_six_frames():
    assert [frame for frame, due in enumerate(answered_after(99), 1) if due] == [7, 14]
    assert [frame for frame, due in enumerate(answered_after(3), 1) if due][0] == 5


def test_the_last_frame_for_an_answer_is_told():
    plan, tracks = ReadingPlan(1.0), believed(is_free=True)
    assert plan.due
    plan.step(1.0, steady=True, tracks=tracks)
    assert plan.due and not plan.step(DT, steady=True, tracks=tracks) and plan.pending
    in_vain = [plan.step(DT, steady=True, tracks=tracks) for _ in range(6)]
    assert in_vain == [False, False, False, False, True, False]


def test_a_change_for_a_reason_of_its_own_is_read_soon():
    plan = read(3.0)
    plan.hurry()
    assert first_due(plan, believed(), steady=False) == DT
    plan = read(3.0)
    plan.hurry()
    soon = plan._age
    for age in (soon, soon + 3.0):  # no less than it was, and no more than is needed
        plan._age = age
        plan.hurry()
        assert plan._age == age


def probes(rates: Iterable[float], roundings: set[Rounding], **more: object) -> list[int]:
    """Return how many frames in a row carry readings within four seconds, for each run."""
    plan, runs, tracks = read(99.0), [], believed(
        rates=tuple(rates), roundings=roundings, **more)
    before = False
    for _ in range(400):
        plan.step(DT, steady=True, tracks=tracks)
        if plan.due:
            runs = [*runs[:-1], runs[-1] + 1] if before else [*runs, 1]
        before = plan.due
    return runs


TWO = {Rounding.TRUNCATE, Rounding.ROUND}
CARRIES = {Rounding.TRUNCATE, Rounding.CARRY}
DEGREE = 0.017453292519943295


@pytest.mark.parametrize(('part', 'two', 'carries'), [
    (0.13, False, False), (0.17, False, True), (0.36, False, True), (0.40, False, False),
    (0.60, False, False), (0.64, True, True), (0.86, True, True), (0.90, False, False)])
@pytest.mark.parametrize('sign', [1, -1])
def test_roundings_are_told_apart_where_they_would_answer_differently(part, two, carries, sign):
    """`part` of a unit is gained in a frame, beside whole ones."""
    for rates in (((sign * (3 + part)) * 0.001 / DT, 0.0), (0.0, sign * part * DEGREE / DT)):
        assert bool(probes(rates, TWO)) == two
        assert bool(probes(rates, CARRIES)) == carries


def test_a_probe_is_nine_frames_every_second_and_a_half():
    runs = probes((0.07, 0.0), TWO)
    assert runs == [9, 9]


@pytest.mark.parametrize(('roundings', 'more'), [
    ({Rounding.ROUND}, {}), (TWO, {'settled': False}), (TWO, {'is_free': True})])
def test_there_is_no_probe_where_it_would_tell_nothing(roundings, more):
    assert not [run for run in probes((0.07, 0.0), roundings, **more) if run > 1]


def test_a_probe_waits_until_requests_were_steady_and_the_last_one_is_long_over():
    for steady, passed, is_due in ((0.61, 1.51, True), (0.59, 1.51, False), (0.61, 1.49, False)):
        plan = read(99.0)
        plan.step(passed - steady, steady=False, tracks=believed(rates=EVEN))
        plan.step(steady, steady=True, tracks=believed(rates=EVEN))
        plan._probed, plan._steady = passed - DT, steady - DT
        plan.step(DT, steady=True, tracks=believed(rates=(0.07, 0.0), roundings=TWO))
        assert plan.due == is_due


def sparing(**more: object) -> ReadingPlan:
    """Return a plan after a reading that asks seldom while the rounding is not known."""
    plan = read(**more)
    plan.sparing = True
    return plan


@pytest.mark.parametrize(('tracks', 'seconds'), [
    (believed(roundings=TWO), 3.0), (believed(roundings=TWO, rests=True), 3.0),
    (believed(roundings=TWO, blur=9.0), 3.0), (believed(roundings=TWO, is_free=True), 0.5),
    (believed(blur=9.0), 0.4)])
def test_who_wants_few_readings_waits_for_three_windows_while_the_rounding_is_not_known(
        tracks, seconds):
    for window in (1.0, 2.5):
        plan = sparing(window=window)
        assert first_due(plan, tracks) == pytest.approx(seconds * window, abs=2 * DT)


def test_who_wants_few_readings_still_gets_one_at_once():
    plan = sparing()
    plan.hurry()
    assert first_due(plan, believed(roundings=TWO)) == DT


@pytest.mark.parametrize(('part', 'spacing'), [
    (0.7, 1), (0.4, 2), (0.25, 3), (0.2, 4), (0.15, 5), (0.12, 6), (2.35, 0), (0.5, 0)])
def test_slow_motion_is_probed_where_some_frames_together_tell(part, spacing):
    """`part` of a unit is gained in a frame; more than three units would not be known well."""
    plan, tracks = sparing(window=99.0), believed(rates=(part * 0.001 / DT, 0.0), roundings=TWO)
    due = []
    for frame in range(1, 250):
        plan.step(DT, steady=True, tracks=tracks)
        if plan.due:
            due.append(frame)
    waits = [later - earlier for earlier, later in zip(due, due[1:])]
    assert waits == [spacing] * ({0: 0, 1: 8}.get(spacing, 5))


def test_probes_of_slow_motion_are_no_closer_than_answers_come():
    plan = sparing(window=99.0)
    plan._latency = 3
    tracks = believed(rates=(0.4 * 0.001 / DT, 0.0), roundings=TWO)
    plan._steady = plan._probed = 9.0
    assert plan._probe_spacing(DT, tracks) == 0
    plan._latency = 1
    assert plan._probe_spacing(DT, tracks) == 2
