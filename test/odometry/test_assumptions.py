# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which of the things that may be assumed of a robot are kept."""

import numpy as np
import pytest

from create_oi_ros.odometry.assumptions import Assumptions, NEAR, SIGNS, YOUNG
from create_oi_ros.robot import Rounding


@pytest.mark.parametrize(('share', 'is_kept'), [(2 * NEAR, True), (NEAR / 2, False)])
def test_a_spring_is_kept_beside_the_best_lag_while_it_comes_near(
        share: float, is_kept: bool) -> None:
    rows = Assumptions.all()
    rows.weights = np.where(rows.springs, share, 1.0)
    rows.weights[0] *= 1.5
    rows.readings = YOUNG
    rows.weigh(np.zeros(len(rows.weights)))
    assert rows.springs.any() == is_kept
    kinds = len(Rounding) * len(SIGNS)
    assert (len(rows.roundings), len(rows.means)) == (kinds * (1 + is_kept),) * 2
    assert rows.weights.sum() == pytest.approx(1.0)
    assert rows.weights[0] == rows.weights.max()


def test_all_are_kept_of_a_robot_that_is_new() -> None:
    rows = Assumptions.all()
    before = len(rows.roundings)
    rows.weigh(np.zeros(before))
    assert len(rows.roundings) == before
