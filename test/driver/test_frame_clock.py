# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Stamps follow the robot's slots, whatever the line adds."""

from random import Random

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.driver.frame_clock import FrameClock, MIN_STEP
from create_oi_ros.odometry import Known
from create_oi_ros.oi import SLOT

WIRE = 0.01


def test_random_delays_are_taken_out():
    clock, random = FrameClock(), Random(1)
    errors = []
    for slot in range(1, 4000):
        stamp, _ = clock.stamp(slot * SLOT + WIRE + random.uniform(0, 0.005), WIRE)
        errors.append(stamp - slot * SLOT)
    settled = errors[100:]
    assert (sum(error ** 2 for error in settled) / len(settled)) ** 0.5 < 0.001


def test_a_line_that_becomes_slower_loses_nothing():
    clock, random = FrameClock(), Random(2)
    total, arrival = 0.0, 0.0
    for slot in range(1, 3000):
        # Pieces do not overtake each other, so delays are high for long.
        arrival = max(arrival, slot * SLOT + random.uniform(0, 0.03))
        total += clock.stamp(arrival, 0.0)[1]
    assert total == pytest.approx(2999 * SLOT, abs=SLOT / 2)  # of a period that is learned


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
        assert stamp >= before + MIN_STEP / 2
        assert dt > 0
        before = stamp


@pytest.mark.parametrize('longest', [0.08, 0.15, 0.4])
def test_a_computer_that_pauses_now_and_then_does_not_stop_the_clock(longest):
    clock, random = FrameClock(), Random(3)
    total, paused_until = 0.0, 0.0
    for slot in range(1, 4000):
        sent = slot * SLOT
        if sent > paused_until and random.random() < 0.02:
            paused_until = sent + random.uniform(0.05, longest)
        total += clock.stamp(max(sent, paused_until), 0.0)[1]
        assert total == pytest.approx(sent, abs=2.5 * SLOT)


def test_late_frames_are_told_from_lost_ones_by_the_next_frame():
    late, lost = FrameClock(), FrameClock()
    for slot in range(1, 100):
        late.stamp(slot * SLOT, 0.0)
        lost.stamp(slot * SLOT, 0.0)
    for clock in (late, lost):
        assert clock.stamp(105.6 * SLOT, 0.0) == pytest.approx((100 * SLOT, SLOT)) and clock.gap
    for slot in range(101, 106):
        assert late.stamp(105.6 * SLOT, 0.0) == pytest.approx((slot * SLOT, SLOT))
    assert late.stamp(106 * SLOT, 0.0) == pytest.approx((106 * SLOT, SLOT)) and not late.gap
    assert lost.stamp(106.6 * SLOT, 0.0) == pytest.approx((106 * SLOT, 6 * SLOT)) and lost.gap
    assert lost.stamp(107 * SLOT, 0.0) == pytest.approx((107 * SLOT, SLOT)) and not lost.gap


def test_the_length_of_a_slot_is_believed_as_far_as_it_was_seen():
    """The earliest of 32 frames count. After 40 slots they say as much as the manual does."""
    clock = FrameClock(Known(0.015, 0.0003))
    for slot in range(1, 64):
        clock.stamp(slot * 0.0152, 0.0)
        assert clock.known_period == (0.015, 0.0003)
    for slots in (32, 64, 96):
        clock.stamp((slots + 32) * 0.0152, 0.0)
        part = slots ** 2 / (slots ** 2 + 40 ** 2)
        assert clock.known_period == pytest.approx(
            (0.015 + part * 0.0002, 0.0003 * (1 - part) ** 0.5))
        for slot in range(slots + 33, slots + 64):
            clock.stamp(slot * 0.0152, 0.0)


@pytest.mark.parametrize(('slot', 'believed'), [(0.0140, 0.0147), (0.0170, 0.0160)])
def test_a_length_that_no_robot_has_is_not_believed(slot, believed):
    clock = FrameClock()
    for number in range(1, 400):
        clock.stamp(number * slot, 0.0)
    assert clock.period == believed


def test_a_frame_that_was_damaged_is_counted():
    clock, durations = FrameClock(), []
    for slot in range(1, 49):
        clock.stamp(slot * SLOT, 0.0)
    for slot in range(50, 80):
        _, dt = clock.stamp(slot * SLOT, 0.0, lost=slot == 50)
        durations.append(round(dt / SLOT))
    assert durations == [2] + 29 * [1]
