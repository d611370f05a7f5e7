# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What wheels were asked some moments ago: sums over requests and their signs."""

import numpy as np
import pytest

from create_oi_ros.odometry.request_history import RECENT, RequestHistory, ROOM
from support.ride import SLOT

NEITHER = False, False


def asked(*requests: tuple[float, float, float]) -> RequestHistory:
    """Return what was asked: right, left, and for how many seconds."""
    history = RequestHistory()
    for right, left, seconds in requests:
        history.ask(right, left, NEITHER)
        history.step(seconds)
    return history


def means(history: RequestHistory, since: float, until: float) -> np.ndarray:
    """Return mean speeds, kept signs and upward signs between two moments, seconds ago."""
    first, last = np.moveaxis(history.sums(np.array([since, until])), -1, 0)
    return (last - first) / (since - until)


def test_means_over_a_window_are_those_of_the_requests_in_it():
    history = asked((0.2, 0.1, 0.125), (-0.1, 0.0, 0.125))
    assert means(history, 0.125, 0.0).tolist() == [[-0.1, 0.0], [-1, 1], [-1, 1]]
    assert means(history, 0.25, 0.125) == pytest.approx(np.array([[0.2, 0.1], [1, 1], [1, 1]]))
    assert means(history, 0.1875, 0.0625) == pytest.approx(
        np.array([[0.05, 0.05], [0, 1], [0, 1]]))
    # Before the first request nothing was asked; a zero counts as forwards.
    assert means(history, 0.375, 0.125) == pytest.approx(
        np.array([[0.1, 0.05], [1, 1], [1, 1]]))


def test_a_zero_keeps_the_sign_before_it_and_counts_as_up():
    history = asked((-0.2, 0.2, 0.1), (0.0, 0.0, 0.1))
    kept, up = (each[:, 0, 0].tolist() for each in history.signs)
    assert (kept, up) == ([-1, 1], [1, 1])
    assert means(history, 0.1, 0.0) == pytest.approx(np.array([[0, 0], [-1, 1], [1, 1]]))
    assert means(history, 0.2, 0.1) == pytest.approx(np.array([[-0.2, 0.2], [-1, 1], [-1, 1]]))


def test_a_request_too_slow_to_move_a_wheel_has_a_sign_but_no_speed():
    history = RequestHistory()
    assert history.ask(-0.01, 0.2, (True, False)).tolist() == [0, 0.2]
    assert (history.asked, history.speeds.tolist()) == ((-0.01, 0.2), [0, 0.2])
    history.step(0.1)
    assert means(history, 0.1, 0.0) == pytest.approx(np.array([[0, 0.2], [-1, 1], [-1, 1]]))


def test_a_change_is_told_in_speed_as_it_moves_the_wheels():
    history = asked((0.2, 0.1, 0.1))
    assert history.ask(-0.1, 0.3, NEITHER) == pytest.approx([-0.3, 0.2])


def test_a_request_that_never_moved_a_wheel_stands_from_its_beginning():
    history = asked((0.2, 0.1, 0.1), (0.01, 0.1, 0.05))
    history.stand(0)
    assert history.speeds.tolist() == [0, 0.1]
    assert means(history, 0.05, 0.0).tolist()[0] == pytest.approx([0, 0.1])
    assert means(history, 0.15, 0.05).tolist()[0] == pytest.approx([0.2, 0.1])


def test_what_was_asked_long_ago_is_forgotten_but_not_what_still_matters():
    history = asked(*((speed / 1000, 0.0, SLOT) for speed in range(1, 400)))
    assert len(history._times) == ROOM
    # 20 slots ago the request was that of the 379th; the 399th is in force.
    assert means(history, 20.5 * SLOT, 20.25 * SLOT)[0, 0] == pytest.approx(0.379)
    assert means(history, 0.5 * SLOT, 0.0)[0, 0] == pytest.approx(0.399)
    assert 23 * SLOT < RECENT
    assert means(history, 23 * SLOT, 0.0)[0, 0] == pytest.approx(0.388)
    late = asked((0.2, 0.1, 0.36))
    late.ask(0.3, 0.1, NEITHER)
    late.step(0.01)
    assert np.isfinite(late._times).sum() == 2
    assert means(late, 0.3, 0.01)[0] == pytest.approx([0.2, 0.1])


def test_age_is_that_of_the_last_change():
    history = asked((0.2, 0.1, 0.1), (0.3, 0.1, 0.05))
    assert history.age == pytest.approx(0.05)
    history.settle()
    assert history.age == np.inf
    assert history.speeds.tolist() == [0.3, 0.1]
    history.step(0.1)
    assert means(history, 0.3, 0.0) == pytest.approx(np.array([[0.3, 0.1], [1, 1], [1, 1]]))


@pytest.mark.parametrize(('requests', 'same'), [
    (((0.2, 0.1, 0.1),), [1, 1]), (((0.2, -0.1, 0.1),), None),
    (((0.2, -0.1, 0.5), (0.3, -0.2, 0.1)), [1, -1]), (((0.2, -0.1, 0.5), (0.0, 0.0, 0.1)), None),
    (((0.2, 0.1, 0.5), (0.0, 0.0, 0.1)), [1, 1])])
def test_where_all_kinds_of_sign_are_the_same_lately_there_is_one(requests, same):
    one = asked(*requests).one_sign
    assert (one if one is None else one[:, 0, 0].tolist()) == same


@pytest.mark.parametrize(('right', 'left', 'turns', 'breaks'), [
    (0.02, -0.01, False, False), (0.04, -0.03, False, False), (0.049, -0.01, False, False),
    (0.051, -0.01, False, True), (0.02, -0.041, False, True), (0.0, -0.01, False, False),
    (0.02, 0.0, True, True), (-0.005, -0.01, True, True), (0.02, 0.01, True, True)])
def test_a_step_and_another_sign_break_what_was_asked(right, left, turns, breaks):
    """A zero is upward, so only what ran backwards gets another sign by it."""
    history = asked((0.02, -0.01, 0.2))
    assert any(history.turning(right, left)) == turns
    history.ask(right, left, NEITHER)
    history.step(0.1)
    assert bool([*history.broken(np.array([0.15]), np.array([0.05]))]) == breaks


def test_moments_at_which_requests_broke_are_told_within_each_span_the_oldest_first():
    history = asked((0.2, 0.1, 0.06), (0.1, -0.1, 0.05), (0.11, -0.1, 0.04))
    first = np.array([[0.2, 0.12], [0.12, 0.14], [0.08, 0.12]])
    last = np.array([[0.1, 0.05], [0.05, 0.1], [0.03, 0.08]])
    told = [moment.tolist() for moment in history.broken(first, last)]
    assert told == [[pytest.approx(row) for row in rows] for rows in (
        [[0.15, 0.12], [0.12, 0.14], [0.08, 0.12]], [[0.1, 0.09], [0.09, 0.1], [0.08, 0.09]])]
    assert [*history.broken(np.array([[0.08]]), np.array([[0.0]]))] == []
    assert [*history.broken(np.array([[0.08, 0.16]]), np.array([[0.0, 0.05]]))] == []


def test_moments_that_no_longer_matter_are_forgotten():
    history = asked((0.2, 0.1, RECENT + 0.01), (0.2, 0.2, RECENT - 0.01), (0.2, 0.3, 0.02))
    assert len([*history.broken(np.array([9.0]), np.array([0.0]))]) == 2
    history = asked((0.2, 0.1, RECENT + 0.01), (0.2, 0.2, RECENT + 0.01), (0.2, 0.3, 0.02))
    assert len([*history.broken(np.array([9.0]), np.array([0.0]))]) == 1
