# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Stamps follow the robot's slots, whatever the line adds."""

from random import Random

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.driver.frame_clock import FrameClock, LEAST_STEP
from create_oi_ros.oi import SLOT

WIRE = 0.01


def test_on_a_line_without_delay_stamps_are_the_slots():
    clock = FrameClock()
    for slot in range(1, 200):
        stamp, dt = clock.stamp(slot * SLOT + WIRE, WIRE)
        assert stamp == pytest.approx(slot * SLOT)
        assert dt == pytest.approx(SLOT)


def test_random_delays_are_taken_out():
    clock, random = FrameClock(), Random(1)
    errors = []
    for slot in range(1, 4000):
        stamp, _ = clock.stamp(slot * SLOT + WIRE + random.uniform(0, 0.005), WIRE)
        errors.append(stamp - slot * SLOT)
    settled = errors[100:]
    assert (sum(error ** 2 for error in settled) / len(settled)) ** 0.5 < 0.001


def test_lost_frames_are_noticed_and_their_time_is_not_lost():
    clock = FrameClock()
    slots = [slot for slot in range(1, 400) if slot not in (200, 201, 202)]
    taken = [(*clock.stamp(slot * SLOT, 0.0), clock.found_lost) for slot in slots]
    assert taken[-1][0] == pytest.approx(slots[-1] * SLOT)
    assert sum(dt + lost for _, dt, lost in taken) == pytest.approx(slots[-1] * SLOT)


def test_a_line_that_becomes_slower_loses_nothing():
    clock, random = FrameClock(), Random(2)
    total, arrival = 0.0, 0.0
    for slot in range(1, 3000):
        # Pieces do not overtake each other, so delays are high for long.
        arrival = max(arrival, slot * SLOT + random.uniform(0, 0.03))
        total += clock.stamp(arrival, 0.0)[1]
    assert total == pytest.approx(2999 * SLOT, abs=SLOT / 2)  # of a period that is learned


def test_a_single_lost_frame_is_noticed_where_garbage_came():
    clock = FrameClock()
    total = 0.0
    for slot in range(1, 400):
        if slot == 200:
            clock.suspect()
        else:
            total += clock.stamp(slot * SLOT, 0.0)[1]
    assert total == pytest.approx(399 * SLOT)


def test_a_robot_whose_clock_is_slow_is_followed():
    clock = FrameClock()
    for slot in range(1, 20000):
        stamp, _ = clock.stamp(slot * SLOT * 1.0005, 0.0)
    assert stamp == pytest.approx(slot * SLOT * 1.0005, abs=0.001)


def test_after_a_restart_stamps_go_on_from_the_new_arrivals():
    clock = FrameClock()
    clock.stamp(1.0, 0.0)
    clock.restart()
    stamp, _ = clock.stamp(100.0, 0.0)
    assert stamp == pytest.approx(100.0)


@given(st.lists(st.floats(0, 0.2), min_size=1, max_size=200))
def test_stamps_always_rise_and_time_always_passes(gaps):
    clock, arrival, before = FrameClock(), 0.0, -1.0
    for gap in gaps:
        arrival += gap
        stamp, dt = clock.stamp(arrival, WIRE)
        assert stamp >= before + LEAST_STEP / 2
        assert dt > 0
        before = stamp


def test_tells_at_once_after_what_a_frame_may_have_been_lost():
    clock = FrameClock()
    gaps = []
    for arrival in (0.0, SLOT, 2 * SLOT, 6 * SLOT, 7 * SLOT):
        clock.stamp(arrival, 0.0)
        gaps.append(clock.gap)
    clock.suspect()
    for arrival in (8 * SLOT, 9 * SLOT):
        clock.stamp(arrival, 0.0)
        gaps.append(clock.gap)
    assert gaps == [False, False, False, True, False, True, False]


@pytest.mark.parametrize('longest', [0.08, 0.15, 0.4])
def test_a_computer_that_pauses_now_and_then_does_not_stop_the_clock(longest):
    clock, random = FrameClock(), Random(3)
    total, paused_until = 0.0, 0.0
    for slot in range(1, 4000):
        sent = slot * SLOT
        if sent > paused_until and random.random() < 0.02:
            paused_until = sent + random.uniform(0.05, longest)
        total += clock.stamp(max(sent, paused_until), 0.0)[1] + clock.found_lost
        assert total == pytest.approx(sent, abs=2.5 * SLOT)


def test_late_frames_are_told_from_lost_ones_by_the_next_frame():
    late, lost = FrameClock(), FrameClock()
    for slot in range(1, 100):
        late.stamp(slot * SLOT, 0.0)
        lost.stamp(slot * SLOT, 0.0)
    for clock in (late, lost):
        _, dt = clock.stamp(105 * SLOT, 0.0)
        assert dt == pytest.approx(SLOT) and clock.undecided
    late.stamp(105 * SLOT, 0.0)
    lost.stamp(106 * SLOT, 0.0)
    assert late.found_lost == 0.0 and lost.found_lost == pytest.approx(5 * SLOT)
    assert not late.undecided and not lost.undecided
