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
    for index in s.LAGS[0]:
        assert len({(lag[index].low, lag[index].high) for lag in s.LAGS}) == 1


def test_springs_may_become_each_other_and_are_believed_to_brake_differently():
    hard, soft = (s.COMMON | spring for spring in s.SPRINGS)
    assert all((hard[index].low, hard[index].high) == (soft[index].low, soft[index].high)
               for index in hard)
    assert [index for index in hard if hard[index] != soft[index]] == [s.BRAKING]
    assert soft[s.BRAKING].mean + soft[s.BRAKING].spread < hard[s.BRAKING].mean


def test_springs_have_the_ranges_of_lags_where_they_mean_the_same():
    for index in (s.LAG, s.SLOW_LAG, s.FAST_LAG):
        lag, spring = s.LAGS[0][index], s.SPRING[index]
        assert (lag.low, lag.high) == (spring.low, spring.high)
    dead_time, spring = s.COMMON[s.DEAD_TIME], s.SPRING[s.DEAD_TIME]
    assert (dead_time.low, dead_time.high) == (spring.low, spring.high)


def test_wheels_are_believed_to_be_as_built_and_to_err_to_both_sides_alike():
    for index, mean in ((s.BRAKING, 0.0), (s.SEPARATION, 0.0)):
        assert (s.COMMON[index].mean, s.COMMON[index].low) == (mean, -s.COMMON[index].high)
    for index, mean in ((s.GAIN_LEFT, 1.0), (s.OFFSET_LEFT, 0.0), (s.MOVES_LEFT, 1.0)):
        assert s.COMMON[index].mean == mean
