"""Frames that come late, as on a busy computer, say what was: the driver must not act on it."""

import pytest

from create_oi_ros import oi
from support.loop import Loop


@pytest.mark.parametrize('delay', [0.05, 0.2, 0.3, 0.45])
def test_a_robot_that_answers_late_is_not_said_to_have_left_its_mode(delay):
    loop = Loop()
    loop.run(3.0)
    loop.cut, loop.delay = True, delay
    loop.run(0.6)  # the driver calls again, and the robot's last frames in Safe come first
    loop.cut = False
    loop.run(4.0)
    assert loop.driver.status.actual is oi.Mode.SAFE
    assert not [notice.text for notice in loop.notices if 'robot left' in notice.text]
