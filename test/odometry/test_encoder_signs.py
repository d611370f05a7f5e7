# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What encoders count that take their signs from requests, wheel by wheel and track by track."""

from itertools import product

import numpy as np
import pytest

from create_oi_ros.odometry.encoder_signs import Encoders, LAST, NONE, Signs, UPWARD

KINDS = [NONE, LAST, LAST, UPWARD, UPWARD]
LATE = [False, False, True, False, True]
COPIES = 3
SHAPE = 2, len(KINDS), COPIES


def encoders(kinds: list[int], late: list[bool] | None = None) -> Encoders:
    """Return encoders of tracks that have these signs."""
    return Encoders(Signs(np.array(kinds), np.array(late or [False] * len(kinds))))


def of_wheels(right: float, left: float) -> np.ndarray:
    """Return one number for each wheel, right first."""
    return np.array([right, left]).reshape(2, 1, 1)


@pytest.mark.parametrize('is_late', [False, True])
def test_a_track_counts_with_the_sign_that_it_believes_in(is_late: bool) -> None:
    random = np.random.default_rng(3)
    travel, rolled = random.normal(size=SHAPE), random.uniform(size=SHAPE)
    now = of_wheels(-1.0, 1.0), of_wheels(0.5, -0.5)
    then = random.choice([-1.0, 0.25, 1.0], size=(2, *SHAPE))
    late = (then[0], then[1]) if is_late else None
    counted = encoders(KINDS, LATE).counted(travel, rolled, now, late)
    for place in product(*map(range, SHAPE)):
        wheel, track, _ = place
        if KINDS[track] == NONE:
            assert counted[place] == travel[place]
            continue
        which = int(KINDS[track] == UPWARD)
        sign = then[which][place] if is_late and LATE[track] else now[which][wheel, 0, 0]
        assert counted[place] == sign * rolled[place]


@pytest.mark.parametrize('kind', [LAST, UPWARD])
def test_tracks_of_one_kind_count_like_one_among_others(kind: int) -> None:
    now = of_wheels(-1.0, 1.0), of_wheels(1.0, -1.0)
    alone, beside = (encoders(kinds).counted(
        np.full((2, len(kinds), 1), 0.5), np.full((2, len(kinds), 1), 2.0), now, None)
        for kinds in ([kind], [kind, NONE]))
    assert alone[:, 0].tolist() == beside[:, 0].tolist()
    assert beside[:, 1].tolist() == [[0.5], [0.5]]


@pytest.mark.parametrize(('kinds', 'right', 'sign', 'see'), [
    ([NONE], 0.1, None, True), ([NONE, NONE], -0.1, (1.0, 1.0), True),
    ([LAST], 0.1, None, False), ([NONE, LAST], 0.1, None, False), ([UPWARD], 0.1, None, False),
    ([LAST], 0.1, (1.0, -1.0), True), ([LAST], 0.0, (1.0, -1.0), True),
    ([LAST], -0.1, (1.0, -1.0), False), ([LAST], -0.1, (-1.0, -1.0), True),
    ([UPWARD, NONE], 0.1, (1.0, 1.0), False)])
def test_signs_make_no_difference_where_wheels_roll_as_they_were_asked(
        kinds: list[int], right: float, sign: tuple[float, float] | None, see: bool) -> None:
    travel = np.array([right, -0.2]).reshape(2, 1, 1) * np.ones((2, len(kinds), COPIES))
    asked = None if sign is None else of_wheels(*sign)
    assert encoders(kinds).see_motion(travel, asked) == see


@pytest.mark.parametrize(('kept', 'up', 'turned'), [
    ((1.0, 1.0), (1.0, 1.0), [[0, 0, 0], [0, 0, 0]]),
    ((-1.0, 1.0), (1.0, 1.0), [[0, 1, 0], [0, 0, 0]]),
    ((1.0, 1.0), (1.0, -1.0), [[0, 0, 0], [0, 0, 1]]),
    ((1.0, -1.0), (-1.0, -1.0), [[0, 0, 1], [0, 1, 1]])])
def test_an_encoder_turns_with_the_sign_that_it_believes_in(
        kept: tuple[float, float], up: tuple[float, float], turned: list[list[int]]) -> None:
    before, after = (of_wheels(1.0, 1.0),) * 2, (of_wheels(*kept), of_wheels(*up))
    found = encoders([NONE, LAST, UPWARD])
    assert found.turned(before, after).astype(int).tolist() == turned
    assert found.turned(after, before).astype(int).tolist() == turned
