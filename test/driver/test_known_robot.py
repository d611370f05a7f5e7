# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A robot that is known starts at full accuracy; one that is another is learned anew."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from itertools import product
from math import degrees, hypot
from random import Random

import pytest

from create_oi_ros.driver import Settings, Severity
from create_oi_ros.odometry import Knowledge, Rounding, SignSource
from create_oi_ros.ros.odometry_model import parsed, text_of
from create_oi_ros.sim.body.config import BodyConfig, DEFAULT_BODY, EncoderSign
from create_oi_ros.sim.body.wheels import Response, TimeConstant
from support.loop import Loop, said
from support.nightly import UNMEASURED

pytestmark = UNMEASURED

Wish = tuple[float, float, float]
"""m/s, rad/s, seconds."""


def robot(rounding: Rounding = Rounding.TRUNCATE, config: BodyConfig = DEFAULT_BODY,
          known: Knowledge | None = None) -> Loop:
    """Return a robot that a driver has found, and may know."""
    loop = Loop(Settings(robot=known), rounding=rounding, config=config)
    loop.run(0.3)
    return loop


def mixed(seed: int, seconds: float) -> Iterable[Wish]:
    """Yield drives with turns, reversals and stops."""
    random = Random(seed)
    while seconds > 0:
        lasts = random.uniform(0.8, 3.0)
        yield (random.choice((-1, 1)) * random.uniform(0.05, 0.3),
               random.choice((-1, 0, 1)) * random.uniform(0.2, 1.2), lasts)
        if random.random() < 0.4:
            yield 0.0, 0.0, 1.0
        seconds -= lasts


def learned(loop: Loop) -> Knowledge:
    """Return what the driver knows."""
    known = loop.driver.health(loop.now).robot
    assert known is not None
    return known


def taught(loop: Loop, seed: int = 1, seconds: float = 75.0) -> Knowledge:
    """Drive for a while; return what was learned, by way of a file."""
    for wish in mixed(seed, seconds):
        loop.drive(*wish)
    return parsed(text_of(learned(loop)))


def errors(loop: Loop, wishes: Iterable[Wish]) -> tuple[float, float]:
    """Drive and come to rest; return the errors, degrees and metres."""
    for wish in wishes:
        loop.drive(*wish)
    truth, estimate = loop.body.truth(), loop.estimate
    return (abs(degrees(estimate.yaw - truth.turned)),
            hypot(estimate.x - truth.pose.x, estimate.y - truth.pose.y))


@cache
def centre_robot() -> Knowledge:
    """Return what is learned of the most likely robot."""
    return taught(robot())


def test_a_robot_is_known_after_75_seconds():
    centre = centre_robot()
    assert centre.certain
    assert centre.likeliest == (Rounding.TRUNCATE, SignSource.DRIVE)
    assert centre.right_gain.value == pytest.approx(1.0, abs=0.01)
    assert centre.left_gain.value == pytest.approx(1.0, abs=0.01)
    assert centre.delay(0.2).value == pytest.approx(0.1, abs=0.02)
    assert centre.frame_period.value == pytest.approx(0.015, abs=1e-5)


@pytest.mark.parametrize('wishes', [
    [(0.2, 0.4, 12.0)], [(0.3, 0.0, 3.0), (-0.3, 0.0, 3.0), (0.0, 1.5, 3.0), (0.0, -1.5, 3.0)]])
def test_the_first_12_seconds_with_a_known_robot_are_right(wishes):
    centre = centre_robot()
    loop = robot(known=centre)
    yaw, place = errors(loop, wishes)
    assert yaw < 1.5  # each reading that is cut off may hide a degree
    assert place < 0.015
    assert not said(loop, Severity.INFO, 'odometry'), 'it was known before'


def test_knowledge_makes_the_start_of_an_unusual_robot_right():
    unusual = replace(DEFAULT_BODY, right_speed_gain=1.05, left_speed_gain=0.95,
                      encoder_sign=EncoderSign.TRUE)
    known = taught(robot(Rounding.CARRY, unusual))
    near = far = 0.0
    for side, turn in product((0.3, -0.3), (1.5, -1.5)):
        wishes = [(side, 0.0, 1.0), (-side, 0.0, 1.0), (0.1, turn, 2.0), (0.0, 0.0, 1.0)]
        yaw, place = errors(robot(Rounding.CARRY, unusual, known), wishes)
        assert yaw < 0.5
        assert place < 0.0035
        near, far = near + place, far + errors(robot(Rounding.CARRY, unusual), wishes)[1]
    assert near < far / 2


@pytest.mark.parametrize('speed', [0.17, 0.31])
@pytest.mark.parametrize('rounding', Rounding)
def test_the_rounding_is_learned_on_a_line_that_is_steered_all_the_time(rounding, speed):
    """As Nav2 drives: the request changes with each command, by a little."""
    loop, random = robot(rounding), Random(1)
    for _ in range(120):
        loop.drive(speed, random.uniform(-0.03, 0.03), 0.1)
    assert learned(loop).rounding[rounding] > 0.95


def test_wheels_that_overshoot_are_known_as_such():
    config = replace(DEFAULT_BODY, response=Response.SECOND_ORDER, overshoot=0.3,
                     time_constant=TimeConstant(0.06))
    loop = robot(config=config)
    # In drive 1 the last bits of a processor decide between two signs.
    known = taught(loop, seed=2, seconds=120.0)
    assert known.likeliest == (Rounding.TRUNCATE, SignSource.DRIVE)
    late = 2 * 0.358 * 0.06 + config.dead_time  # 0.358 is the damping of such an overshoot
    assert known.delay(0.2).value == pytest.approx(late, abs=0.01)
    line, = [notice.text for notice in loop.notices if 'odometry' in notice.text]
    assert line == 'the odometry knows this robot now: /diagnostics has its numbers'
    yaw, place = errors(robot(config=config, known=known), [
        (0.3, 0.0, 2.0), (-0.3, 0.0, 2.0), (0.0, 1.5, 2.0), (0.0, 0.0, 1.0), (0.0, -1.5, 2.0)])
    assert yaw < 1.5
    assert place < 0.015


@pytest.mark.parametrize(('rounding', 'sign', 'is_learned'), [
    (Rounding.CARRY, EncoderSign.DRIVE, (Rounding.CARRY, SignSource.DRIVE)),
    (Rounding.TRUNCATE, EncoderSign.TRUE, (Rounding.TRUNCATE, SignSource.MOTION))])
def test_knowledge_of_another_robot_is_unlearned(rounding, sign, is_learned):
    centre = centre_robot()
    other = replace(DEFAULT_BODY, encoder_sign=sign, right_speed_gain=1.04)
    loop = robot(rounding, other, known=centre)
    known = taught(loop)
    assert known.likeliest == is_learned
    assert known.right_gain.value == pytest.approx(1.04, abs=0.015)
    assert said(loop, Severity.INFO, 'this robot is another than the odometry thought') > 0


def test_nothing_is_known_before_the_first_reading():
    assert Loop().driver.health(100.0).robot is None


def test_the_length_of_a_frame_survives_a_silence():
    centre = centre_robot()
    period = replace(centre, frame_period=centre.frame_period._replace(value=0.0154))
    loop = robot(known=period)
    loop.cut = True
    loop.run(3.0)
    assert loop.driver._tracking.clock.period == pytest.approx(0.0154, abs=1e-5)
