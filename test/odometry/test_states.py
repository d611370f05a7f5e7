# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is believed before the first reading is possible, and learned rather than drifted into."""

import pytest

from create_oi_ros.odometry import states as s

EVERY = [(index, prior) for kind in (s.COMMON, *s.RESPONSES) for index, prior in kind.items()]


@pytest.mark.parametrize(('index', 'prior'), EVERY)
def test_a_prior_is_a_belief_within_its_range(index, prior):
    assert prior.low <= prior.mean <= prior.high
    assert 0 <= prior.spread <= prior.high - prior.low
    assert prior.mean - 2 * prior.spread < prior.high
    assert 0 <= prior.drift <= prior.spread / 100


def test_all_responses_say_the_same_of_as_many_unknowns():
    kinds = [set(s.COMMON | response) for response in s.RESPONSES]
    assert all(kind == kinds[0] for kind in kinds)
    assert kinds[0] | set(s.SPEEDS) == set(range(s.UNKNOWNS))
    assert s.UNKNOWNS + len(s.POSE) + 2 == s.SIZE


def test_both_wheels_are_believed_to_be_alike():
    for right, left in ((s.GAIN_RIGHT, s.GAIN_LEFT), (s.OFFSET_RIGHT, s.OFFSET_LEFT), s.MOVES):
        assert s.COMMON[right] == s.COMMON[left]


def test_lags_may_become_each_other():
    """Their ranges are the same; the bound may be any of theirs."""
    lags = s.RESPONSES[:3]
    for index in lags[0]:
        assert len({(lag[index].low, lag[index].high) for lag in lags}) == 1
