# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What tells how well the line works: counts, limits and times, each to the last one."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.connection import BaudSearch, FrameBudget
from create_oi_ros.driver.stream import CommandNews, CommandWatch, StreamPlan

ONE, OTHER = (7, 8), (7, 9)
SUSPECT, WAKE, IGNORES, AGAIN = CommandNews

# Whether the robot takes commands.


def test_speeds_that_are_not_taken_are_news_ever_graver_until_they_are():
    watch = CommandWatch()
    news = [watch.check(8.0, now) for now in (8.29, 8.31, 8.89, 8.91, 9.49, 9.51, 99.0)]
    assert news == [None, SUSPECT, None, WAKE, None, IGNORES, None]
    assert watch.ignores and watch.suspects
    assert [watch.check(None, 100.0), watch.check(None, 101.0)] == [AGAIN, None]
    assert not watch.ignores and not watch.suspects


def test_a_list_that_does_not_come_is_news_after_a_while():
    watch = CommandWatch()
    watch.seen(ONE)
    watch.asked(OTHER, 1.0)
    news = [watch.check(None, now) for now in (1.29, 1.31, 2.51, 9.0)]
    assert news == [None, SUSPECT, IGNORES, None]
    watch.seen(OTHER)
    assert watch.check(None, 9.1) is AGAIN


# Whether frames arrive.


def seconds(budget: FrameBudget, begin: float, frames: int, size: int = 30, more: int = 0,
            baud: int = 57600, fits: bool = True) -> bool:
    """Let frames come for four seconds; return whether a problem began or ended."""
    for _ in range(frames):
        budget.add_bytes(size)
        budget.add_frame(size)
    budget.add_bytes(more)
    assert not budget.check(baud, begin + 2.9, fits=fits)
    return budget.check(baud, begin + 3.0, fits=fits)


def test_fewer_than_four_fifths_are_a_problem_until_nine_tenths_come():
    budget, now = FrameBudget(), 0.0
    assert not budget.check(57600, now, fits=True)
    for frames, news, problem in ((161, False, False), (159, True, True), (159, False, True),
                                  (179, False, True), (181, True, False)):
        assert seconds(budget, now, frames) == news
        assert bool(budget.problem) == problem
        now += 3.0


@pytest.mark.parametrize(('more', 'fits', 'damaged'), [
    (2710, True, True), (2690, True, False), (2710, False, False)])
def test_bytes_that_came_though_frames_did_not_were_damaged(more, fits, damaged):
    """Half of the frames came whole, 3000 bytes; 95 % of the bytes are 5700."""
    budget = FrameBudget()
    budget.check(57600, 0.0, fits=True)
    assert seconds(budget, 0.0, 100, more=more, fits=fits)
    assert ('the others are damaged' in budget.problem) == damaged
    assert budget.problem.startswith('' if damaged else 'frame budget exceeded: ')
    assert 'only 33 of 67 frames a second arrive' in budget.problem


@pytest.mark.parametrize(('baud', 'advice'), [
    (19200, 'baud: use 57600 baud, and look at'), (57600, 'baud: look at')])
def test_a_slow_line_says_its_numbers_and_what_to_do(baud, advice):
    budget = FrameBudget()
    budget.check(baud, 0.0, fits=True)
    seconds(budget, 0.0, 100, baud=baud)
    assert ('a frame of 30 bytes every 15 ms is 2000 bytes/s, and 1000 came at '
            f'{baud} {advice} adapter, network and cable') in budget.problem


def test_why_a_line_is_silent():
    longest = oi.PacketList([6]).budget(57600)
    budget = FrameBudget()
    for size, why in ((longest.size, 'off, asleep'), (1, f'{longest.size + 1} bytes came')):
        budget.add_bytes(size)
        assert why in budget.why_silent(longest, 57600)
    budget.add_frame(5)
    assert budget.since_frame == 0
    assert 'off, asleep' in budget.why_silent(longest, 57600)
    budget.add_bytes(999)
    budget.restart()
    assert 'off, asleep' in budget.why_silent(longest, 57600)
    slow = oi.PacketList([6]).budget(19200)
    assert budget.why_silent(slow, 19200) == (
        'frame budget exceeded: 19200 baud carries 28 bytes in 15 ms, and longer frames are cut')


# At which rate the robot is.


def test_the_likely_rates_come_again_before_each_of_the_others():
    search = BaudSearch(0)
    tried = [search.next_baud() for _ in range(30)]
    assert tried[:9] == [57600, 19200, 115200, 57600, 19200, 14400, 57600, 19200, 9600]
    assert tried[-6:] == [57600, 19200, 38400, 57600, 19200, 28800]
    search.restart()
    assert [search.next_baud() for _ in range(7)] == [
        28800, 57600, 19200, 115200, 28800, 57600, 19200]


def test_bytes_that_are_no_frames_are_shown_once_there_are_enough():
    for sizes, other in (((63,), False), ((64,), True), ((32, 32), True), ((1, 200), True)):
        search = BaudSearch(57600)
        for _ in range(3):
            search.next_baud()
        for size in sizes:
            search.add_garbage(bytes(range(size)))
        text = search.find_problem()
        assert ('not like a Create at 57600 baud (it sent 0 ' in text) == other
    assert '(it sent 0 0 1 2 3 4 5 6 7 8 9 10 ...)' in text


# Which packets are asked for.


def test_on_a_slow_line_the_rest_comes_in_turns():
    plan = StreamPlan(19200)
    asked = [plan.next_stream(slot * 0.0151, motion_due=slot == 4).packets for slot in range(14)]
    assert asked[0] == asked[4] == plan.full.ids == (7, 9, 10, 11, 12, 35, 41, 42, 19, 20)
    rest = asked[1:4] + asked[5:]
    parts = list(dict.fromkeys(rest))
    assert rest == (3 * parts)[:len(rest)]
    assert plan.short.ids == parts[0]
    named = {number for part in parts for number in part}
    assert named == set(StreamPlan(57600).full.ids) - {19, 20}
    for part in parts:
        assert part[:8] == (7, 9, 10, 11, 12, 35, 41, 42)
        assert oi.PacketList(part).budget(19200).fits
    for part, following in zip(parts, parts[1:]):
        assert not oi.PacketList([*part, following[8]]).budget(19200).fits


@pytest.mark.parametrize('baud', [19200, 57600, 115200])
def test_a_list_for_scripts_tells_the_last_drive_and_what_has_room(baud):
    plan = StreamPlan(baud)
    assert plan.marker.ids == (7, 9, 10, 11, 12, 35, 41, 42)
    assert {39, 40} <= set(plan.script.ids)
    assert set(plan.marker.ids) <= set(plan.script.ids)
    assert (8 in plan.script.ids) == (baud > 19200)
    assert not {19, 20} & set(plan.script.ids)
    assert plan.budget == plan.full.budget(baud)
    assert {plan.short, plan.full, plan.marker, plan.script} <= set(plan.lists)
