# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What people are told of a robot that has become known."""

import pytest

from create_oi_ros.driver.tracking import in_words
from create_oi_ros.odometry import Hypothesis, Knowledge, Known, Response, SignSource
from create_oi_ros.robot import Rounding

WHEELS = Hypothesis(Response.LAG, 0.14, 1.0, 0.0, 1.0, 0.03, 0.01, SignSource.DRIVE)


def robot(wheels: Hypothesis = WHEELS) -> Knowledge:
    """Return what is known of a robot."""
    return Knowledge(
        hypotheses={wheels: 1.0},
        rounding={each: float(each is Rounding.TRUNCATE) for each in Rounding},
        right_gain=Known(0.98, 1e-4), left_gain=Known(1.02, 1e-4), angle_factor=Known(1.0, 1e-3),
        frame_period=Known(0.01525, 1e-6))


def test_a_robot_is_described_in_plain_words() -> None:
    assert in_words(robot()) == {
        'fractions of distance and angle': 'cut off and lost at each reading (over 99.9 % sure)',
        'sign of an encoder': 'of the drive: the last request that was not zero, after its dead '
                              'time (over 99.9 % sure)',
        'response': 'first order, coasts 14 mm from 0.1 m/s, 14 mm from 0.2 m/s (over 99.9 % '
                    'sure)',
        'late': '100 +- 0 ms at 0.2 m/s', 'dead time': 'about 30 ms',
        'wheels over request': 'right 0.980 +- 0.000, left 1.020 +- 0.000',
        'slowest speed that moves it': 'about 10 mm/s',
        'wheel separation of the firmware': '258.0 mm', 'frame period': '15.250 ms'}


@pytest.mark.parametrize(('wheels', 'answer'), [
    (WHEELS._replace(of_speed=0.0), 'first order, coasts 14 mm from 0.1 m/s, 28 mm from 0.2 m/s'),
    (WHEELS._replace(response=Response.SPRING, overshoot=0.3), 'second order, overshoots by 30 %'),
    (WHEELS._replace(response=Response.RAMP, time=2.0, braking=0.5),
     'a constant acceleration of 0.50 m/s2, brakes 0.5 times as fast as it speeds up')])
def test_each_response_has_its_words(wheels: Hypothesis, answer: str) -> None:
    assert in_words(robot(wheels))['response'].startswith(f'{answer} (')
