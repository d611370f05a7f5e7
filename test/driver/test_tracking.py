# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the odometry is told of each frame: how long it lasted, what was asked, what it read."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Settings
from create_oi_ros.driver.core import Core
from create_oi_ros.driver.frame_clock import LEAST_STEP
from create_oi_ros.driver.tracking import Tracking
from create_oi_ros.odometry import Estimate, Increment
from create_oi_ros.oi import SLOT
from support.views import QUIET

SHORT, FULL = oi.PacketList.named(*QUIET), oi.PacketList.named(*QUIET, 'distance', 'angle')
SPEEDS = 0.2, -0.1


class Heard:
    """Stands for an odometry; keeps what it was told."""

    def __init__(self) -> None:
        self.increments: list[Increment] = []
        self.knowledge = None
        self.interruptions = 0
        self.asks_after: set[int] = set()
        """After how many increments a reading is due."""

    @property
    def reading_due(self) -> bool:
        return len(self.increments) in self.asks_after

    def update(self, increment: Increment) -> Estimate:
        self.increments.append(increment)
        return Estimate(x=float(len(self.increments)))

    def interrupted(self) -> None:
        self.interruptions += 1


class Line:
    """Frames on their way to a tracking, at one slot or another."""

    def __init__(self) -> None:
        self.odometry, self.core = Heard(), Core(Settings(), lambda _: None)
        self.counts = self.core.counts
        self.tracking = Tracking(self.core, self.odometry)

    def frame(self, slot: float, reading: tuple[int, int] | None = None, speeds=SPEEDS,
              **values: int) -> list[Increment]:
        """Let a frame come; return what the odometry was told."""
        told, packets = len(self.odometry.increments), FULL if reading else SHORT
        numbers = dict(zip(('distance', 'angle'), reading or ()))
        sent = {**QUIET, **values, **numbers}
        data = packets.pack_frame([sent[name] for name in packets.names])
        taken = self.tracking.take(
            oi.Frame(packets, data, oi.Checksum.HARDWARE), 57600,
            slot * SLOT + packets.wire_time(57600))
        if taken is not None:
            self.moved = self.tracking.moved(taken, speeds)
        return self.odometry.increments[told:]


@pytest.fixture
def line() -> Line:
    """Return a line over which some frames have come."""
    line = Line()
    for slot in range(1, 41):
        line.frame(slot)
    return line


def test_a_frame_tells_how_long_it_was_and_what_was_asked(line):
    increment, = line.frame(41)
    assert increment == Increment(pytest.approx(SLOT), 0.2, -0.1, driven=True)
    increment, = line.frame(42, (3, -4))
    assert (increment.distance, increment.angle, increment.lost) == (3, -4, False)
    assert line.counts.frames == 42
    assert line.moved.estimate.x == 42.0
    assert line.moved.stamp == pytest.approx(42 * SLOT)
    assert line.moved.readings.distance == 3


@pytest.mark.parametrize(('mode', 'driven'), [(0, False), (1, False), (2, True), (3, True)])
def test_wheels_obey_in_safe_and_full_where_their_speeds_are_known(line, mode, driven):
    increment, = line.frame(41, oi_mode=mode)
    assert increment.driven == driven
    increment, = line.frame(42, oi_mode=mode, speeds=None)
    assert (increment.driven, increment.right, increment.left) == (False, 0.0, 0.0)


@pytest.mark.parametrize(('bits', 'lifted'), [
    (0, False), (3, False), (4, True), (8, True), (16, False), (31, True)])
def test_a_drive_wheel_in_the_air_is_told_but_not_the_one_in_front(line, bits, lifted):
    increment, = line.frame(41, bumps_and_wheel_drops=bits)
    assert increment.lifted == lifted


def test_the_time_of_a_frame_that_cannot_be_is_that_of_the_next_one(line):
    assert line.frame(41, oi_mode=7) == line.frame(42, oi_mode=7) == []
    increment, = line.frame(43)
    assert increment.dt == pytest.approx(3 * SLOT)
    assert (line.counts.implausible_frames, line.counts.frames) == (2, 41)
    increment, = line.frame(44)
    assert increment.dt == pytest.approx(SLOT)


def test_an_impossible_reading_is_none_and_may_be_a_lost_one(line):
    line.frame(41, (0, 0))
    increment, = line.frame(42, (9999, 0))
    assert (increment.distance, increment.angle, increment.lost) == (None, None, True)
    assert line.counts.impossible_jumps == 1
    increment, = line.frame(43)
    assert not increment.lost


def test_after_garbage_a_frame_may_have_been_lost(line):
    line.tracking.clock.suspect(0.1)
    increment, = line.frame(41)
    assert increment.lost
    increment, = line.frame(42)
    assert not increment.lost


def test_behind_a_gap_the_robot_is_taken_to_drive_on_until_the_next_frame_tells(line):
    """Ten slots without a frame; the reading behind them waits."""
    increment, = line.frame(51, (5, 6), speeds=(0.4, 0.3))
    assert increment == Increment(pytest.approx(SLOT), 0.2, -0.1, driven=True)
    held, increment = line.frame(52, (7, 8), speeds=(0.5, 0.5))
    assert held == Increment(pytest.approx(10 * SLOT), 0.4, 0.3, True, 5, 6, lost=True)
    assert increment == Increment(pytest.approx(SLOT), 0.5, 0.5, True, 7, 8)


def test_frames_that_were_only_late_took_no_time(line):
    line.frame(51, (5, 6), speeds=(0.4, 0.3))
    held, increment = line.frame(51.01, speeds=(0.5, 0.5))
    assert held == Increment(LEAST_STEP, 0.4, 0.3, True, 5, 6, lost=False)
    assert increment.dt == pytest.approx(SLOT)


def test_time_that_was_lost_counts_with_the_next_frame_that_can_be(line):
    line.frame(51, speeds=(0.4, 0.3))
    assert line.frame(52, oi_mode=7) == []
    held, increment = line.frame(53)
    assert held.dt == pytest.approx(10 * SLOT)
    assert increment.dt == pytest.approx(2 * SLOT)


def test_a_reading_that_was_asked_for_behind_a_gap_is_asked_for(line):
    line.odometry.asks_after = {42}  # after the held frame, and not after the one behind it
    line.frame(51)
    assert not line.tracking.reading_due
    line.frame(52)
    assert len(line.odometry.increments) == 43 and line.tracking.reading_due
    line.frame(53)
    assert not line.tracking.reading_due


def test_a_robot_that_was_away_is_begun_anew(line):
    line.frame(51, (5, 6))
    line.tracking.restart()
    assert line.odometry.interruptions == 1
    increment, = line.frame(200, (9999, 0))
    assert increment.distance == 9999  # the first reading spans an unknown time
    assert increment.dt == pytest.approx(SLOT)
    assert line.tracking.robot is None


def test_all_readings_are_kept_until_newer_ones_come(line):
    line.frame(41, (3, 4))
    line.frame(42, cliff_left=1)
    assert line.core.readings.distance == 3 and line.core.readings.cliff_left


def test_frames_lost_before_one_that_cannot_be_are_time_of_the_next_one(line):
    assert line.frame(51, oi_mode=7) == []
    increment, = line.frame(52)
    assert increment.dt == pytest.approx(12 * SLOT)
