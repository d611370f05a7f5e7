# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the robot is after a script, during which nobody can ask it."""

from functools import cache
from math import cos, degrees, hypot, sin, sqrt
from statistics import fmean

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Settings
from create_oi_ros.oi.tools.text import parse_script
from create_oi_ros.robot import Rounding, WHEEL_SEPARATION
from support.loop import AT_ONCE, Loop

LINE = 'Drive velocity=200 radius=straight; Wait Time time=20'
ARC = 'Drive velocity=-150 radius=500; Wait Time time=40; Drive velocity=0 radius=straight'
CORNER = ('Drive velocity=300 radius=straight; Wait Distance distance=400; '
          'Drive velocity=100 radius=in_place_clockwise; Wait Angle angle=-90; '
          'Drive velocity=300 radius=straight; Wait Distance distance=400')
DIRECT = ('Drive Direct right=200 left=100; Wait Time time=20; Drive Direct right=-100 left=150; '
          'Wait Time time=30')
MIXED = ('Drive Direct right=200 left=100; Wait Time time=20; '
         'Drive velocity=-100 radius=straight; Wait Time time=30')
LESSON = ((239, 161), (10, 190), (0, 0), (-174, -226), (352, 248), (64, -64), (0, 0))
"""Speeds of the right and the left wheel, mm/s."""


@cache
def lessons(rounding: Rounding, begin: int) -> Loop:
    """Return a driver after half a minute of driving by steps, as scripts drive."""
    loop = Loop(Settings(odometry_window=1.0, limits=AT_ONCE), rounding=rounding)
    loop.run(0.3)
    for right, left in (LESSON[begin:] + LESSON[:begin]) * 3:
        loop.drive((right + left) / 2000, (right - left) / 1000 / WHEEL_SEPARATION, 1.5)
    return loop


def learned(rounding: Rounding, begin: int = 0) -> Loop:
    """Return a driver that knows its robot. Tests share it: each one plays and comes to rest."""
    loop = lessons(rounding, begin)
    loop.run(1.0)
    # Readings still correct where the lessons ended; with a new origin they correct the script.
    loop.driver.reset_odometry()
    loop.run(0.1)
    return loop


def seen_from(yaw: float, x: float, y: float) -> tuple[float, float]:
    """Return a way as somebody sees it who looks in that direction."""
    return x * cos(yaw) + y * sin(yaw), y * cos(yaw) - x * sin(yaw)


def play(loop: Loop, text: str) -> tuple[float, float, float]:
    """Play a script to its end; return what it missed, m and degrees, and its doubt, m."""
    before, started = loop.estimate, loop.body.truth()
    defined = loop.driver.scripts.define(parse_script(text))
    loop.run(0.2)
    played = loop.driver.scripts.play(loop.now, force=False)
    while loop.driver.scripts.playing or played.outcome is None:
        loop.run(0.1)
    loop.run(3.0)
    assert defined.outcome.ok and played.outcome.ok
    after, ended = loop.estimate, loop.body.truth()
    assert abs(ended.travelled - started.travelled) + abs(ended.turned - started.turned) > 0.1
    told = seen_from(before.yaw, after.x - before.x, after.y - before.y)
    true = seen_from(started.turned, ended.pose.x - started.pose.x, ended.pose.y - started.pose.y)
    return (hypot(told[0] - true[0], told[1] - true[1]),
            abs(degrees(after.yaw - before.yaw - ended.turned + started.turned)),
            sqrt(after.pose_covariance[0] + after.pose_covariance[4]))


@pytest.mark.parametrize(('script', 'metres', 'turn'), [
    (LINE, 0.008, 1.0), (ARC, 0.008, 1.0), (CORNER, 0.015, 2.0), (DIRECT, 0.008, 1.0)])
@pytest.mark.parametrize('rounding', list(Rounding))
def test_after_a_script_the_odometry_is_where_the_robot_is(
        rounding: Rounding, script: str, metres: float, turn: float) -> None:
    """
    As a root mean square of drivers that learned in another order: one alone may be lucky.

    A wheel that reverses is counted backwards while it brakes, so it must be known how it brakes.
    """
    played = [play(learned(rounding, begin), script) for begin in range(0, len(LESSON), 2)]
    places, headings, _ = zip(*played)
    assert sqrt(fmean(each ** 2 for each in places)) < metres
    assert sqrt(fmean(each ** 2 for each in headings)) < turn


def test_a_script_is_followed_again_when_it_is_played_again() -> None:
    """The echo of its first command is there already."""
    loop = learned(Rounding.TRUNCATE)
    for _ in range(2):
        assert play(loop, LINE)[0] < 0.012


def test_a_script_that_cannot_be_followed_leaves_doubt() -> None:
    place, _, doubt = play(learned(Rounding.TRUNCATE), MIXED)
    assert place < 2 * doubt


def test_while_a_script_plays_distance_and_angle_are_not_read() -> None:
    """A robot that waits cannot be asked for another list."""
    loop = learned(Rounding.TRUNCATE)
    loop.commands()
    play(loop, LINE)
    commands = loop.commands()
    played = commands.index(oi.PlayScript())
    asked = [each for each in commands[:played] if isinstance(each, oi.Stream)][-1]
    assert asked.packets == loop.driver.plan.script.ids
    assert not {19, 20} & set(asked.packets)


def test_a_script_that_is_refused_leaves_the_stream_as_it_is(loop: Loop) -> None:
    assert loop.driver.scripts.play(loop.now, force=False).outcome.ok is False
    loop.run(0.1)
    assert not any(isinstance(each, oi.Drive) for each in loop.commands())


def test_a_speed_that_the_robot_reports_oddly_is_not_known(loop: Loop) -> None:
    scripts = loop.driver.scripts
    scripts.define(parse_script(LINE))
    scripts.play(loop.now, force=False)
    for velocity, speeds in ((200, (0.2, 0.2)), (None, None)):
        readings = oi.Readings({'requested_velocity': velocity, 'requested_radius': -32768})
        assert scripts.speeds(readings) == speeds
