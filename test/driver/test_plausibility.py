# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a frame is taken for: the edges of what a reading can be, and its time stamp."""

from itertools import groupby
from random import Random

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver, Settings, Severity
from create_oi_ros.driver.frame_clock import FrameClock, MIN_STEP
from create_oi_ros.driver.stream import ALL
from create_oi_ros.driver.tracking import ODD_FRAMES, POSSIBLE
from create_oi_ros.oi import SLOT
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.world import shipped
from support.loop import Loop, said, texts


def impossible(name: str) -> int:
    """Return a value that no Create has: a bit that means nothing, or out of range."""
    low, high = oi.PACKETS[oi.NUMBERS[name]].wire.limits
    return next(value for value in (2, 0x20, 0x80, low, high)
                if low <= value <= high and value not in POSSIBLE[name])


ODD = {name: impossible(name) for name in ALL
       if len(POSSIBLE[name]) < 256 ** oi.size_of(name)}  # type: ignore[arg-type]


def answered(loop: Loop) -> bool:
    """Tell whether nobody was told that the robot is silent."""
    return loop.driver.state.answered and not texts(loop.notices, Severity.ERROR)


@pytest.mark.parametrize('baud', [57600, 19200])
@pytest.mark.parametrize(('name', 'value'), ODD.items())
def test_a_value_that_every_frame_has_stops_nothing(name: str, value: int, baud: int) -> None:
    loop = Loop(Settings(baud=baud), robot_baud=baud)
    loop.forged = {name: value}
    loop.drive(0.2, 0.0, 2.0)
    assert answered(loop)
    packet = f'(packet {oi.NUMBERS[name]}) = {value},'
    assert said(loop, Severity.WARNING, packet) == 1
    health = loop.driver.health(loop.now)
    assert health.odd == {name: value} and health.counts.odd_values > 1
    assert health.counts.implausible_frames <= ODD_FRAMES - 1
    wire = oi.PACKETS[oi.NUMBERS[name]].wire
    bits = 1 if wire.boolean else wire.mask
    assert getattr(health.readings, name) == (value & bits if bits else None)
    assert (loop.body.truth().pose.x > 0.2) is (name != 'oi_mode')


def test_all_of_them_at_once_and_other_values_in_every_frame_stop_nothing() -> None:
    loop = Loop()
    values = {name: value for name, value in ODD.items() if name != 'oi_mode'}
    for turn in range(900):
        loop.forged = {name: value for place, (name, value) in enumerate(values.items())
                       if (place + turn // 3) % 7 or turn > 600}
        loop.forged['wall_signal'] = 5000 + turn % 300
        loop.driver.drive(0.2, 0.0, loop.now)
        loop.turn()
    assert answered(loop) and loop.body.truth().pose.x > 0.2
    told = said(loop, Severity.WARNING, 'which no Create should have')
    assert told == len(values), 'each is told of once'
    loop.forged = {}
    loop.run(2)
    assert loop.driver.health(loop.now).odd == {}
    assert loop.driver.health(loop.now).readings.wall_signal is not None


def test_one_odd_frame_is_dropped_and_so_is_another_one_later(loop: Loop) -> None:
    for count in (1, 2, 3):
        loop.forged = {'oi_mode': 4}
        loop.run(0.015)
        loop.forged = {}
        loop.run(0.1)
        assert loop.driver.counts.implausible_frames == count
    assert loop.driver.counts.odd_values == 0 and not texts(loop.notices, Severity.WARNING)
    assert loop.driver.status.can_drive


def test_a_mode_that_does_not_exist_stops_the_wheels_and_says_what_to_do() -> None:
    loop = Loop()
    loop.drive(0.3, 0.0, 2.0)
    loop.forged = {'oi_mode': 4}
    loop.drive(0.3, 0.0, 0.3)
    assert loop.moved[-1].readings.requested_right_velocity == 0
    assert said(loop, Severity.WARNING, 'robot left SAFE for no known mode') == 1
    assert said(loop, Severity.WARNING, 'call set_mode with SAFE; if that does not help') == 1
    request = loop.driver.modes.set(oi.Mode.SAFE, loop.now)
    loop.run(1.0)
    assert request.outcome is not None and not request.outcome.ok
    assert 'stays in no known mode' in request.outcome.text
    refusal = loop.driver.modes.start_demo(oi.DemoNumber.COVER).outcome
    assert refusal is not None and 'no known mode' in refusal.text
    loop.forged = {}
    loop.drive(0.3, 0.0, 1.0)
    assert loop.driver.status.can_drive and loop.driver.state.moving


def test_a_song_plays_though_its_number_is_not_known() -> None:
    loop = Loop()
    loop.forged = {'song_number': 16}
    loop.run(1)
    loop.driver.songs.define(1, [60], [1.0])
    request = loop.driver.songs.play(1, loop.now)
    loop.run(0.5)
    assert request.outcome is not None and request.outcome.ok


def test_an_impossible_jump_is_dropped_and_counted(loop: Loop) -> None:
    before, frame = loop.estimate, loop.driver.plan.full
    for count, (name, value) in enumerate([
            ('distance', 4000), ('distance', -600), ('angle', 300), ('angle', -300)], 1):
        forged = {'oi_mode': oi.Mode.SAFE, name: value}
        loop.driver.receive(
            frame.pack_frame([forged.get(each, 0) for each in frame.names]), loop.now)
        loop.run(0.5)
        assert loop.driver.counts.impossible_jumps == count
    assert loop.estimate[:3] == pytest.approx(before[:3], abs=1e-6)


# Stamps follow the robot's slots, whatever the line adds.


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


def test_a_frame_that_was_damaged_is_counted():
    clock, durations = FrameClock(), []
    for slot in range(1, 49):
        clock.stamp(slot * SLOT, 0.0)
    for slot in range(50, 80):
        _, dt = clock.stamp(slot * SLOT, 0.0, lost=slot == 50)
        durations.append(round(dt / SLOT))
    assert durations == [2] + 29 * [1]


def test_each_question_for_distance_and_angle_brings_one_frame_of_them():
    # A second one a frame later would cost another fraction of a unit. The host is woken by
    # frames, up to 0.2 ms early or late.
    random, robot, driver = Random(7), Create(Body(shipped('empty'))), Driver(Settings())
    driver.connected(100.0)
    reader, asked = oi.StreamReader(driver.plan.lists), []
    for slot in range(2000):
        at = 100.0 + slot * SLOT
        robot.poll(at)
        heard = robot.data_to_send()
        reader.feed(heard)
        while (event := reader.next_event()) is not None:
            asked.append(isinstance(event, oi.Frame) and 'distance' in event.packets.names)
        now = at + 0.01 + random.uniform(-2e-4, 2e-4)
        driver.receive(heard, now)
        if slot % 5 == 0:
            driver.drive(0.2, 0.3, now)
        driver.poll(now)
        robot.receive(driver.data_to_send(), at + 0.014)
    rows = [len(list(row)) for motion, row in groupby(asked[10:]) if motion]
    assert len(rows) > 10 and set(rows) == {1}
