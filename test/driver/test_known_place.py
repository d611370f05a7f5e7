# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The odometry goes on from a place that somebody knows: a user's, or the dock's."""

from math import cos, inf, nan, pi, remainder, sin, tau

import pytest

from create_oi_ros.driver import Settings
from create_oi_ros.driver.goals import Code, Dock, Undock
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.world import parse, Pose
from support.asking import ask
from support.goals import distance, pursue
from support.loop import Loop

BASE = parse('start 0.8 0 180\nhome_base 0 0 0', 'base')
ON_BASE = Pose(0.1655, 0.0, pi)
PLACE = (2.0, -3.0, 2.5)


def pose(loop: Loop) -> tuple[float, float, float]:
    """Return x, y and yaw of the estimate."""
    return loop.estimate[:3]


def moved_from(loop: Loop, begun: Pose, place: tuple[float, float, float]) -> None:
    """See that the estimate is where its motion, since it truly began, leads from a place."""
    true, turned = loop.body.truth().pose, place[2] - begun.yaw
    dx, dy = true.x - begun.x, true.y - begun.y
    assert pose(loop)[:2] == pytest.approx((
        place[0] + cos(turned) * dx - sin(turned) * dy,
        place[1] + sin(turned) * dx + cos(turned) * dy), abs=0.02)
    assert remainder(pose(loop)[2] - turned - true.yaw, tau) == pytest.approx(0, abs=0.03)


def test_the_odometry_goes_on_from_a_place():
    loop = Loop()
    loop.run(0.3)
    loop.drive(0.2, 0.7, 1.0)
    begun = loop.body.truth().pose
    answer = ask(loop, loop.driver.reset_pose, *PLACE, seconds=0.02)
    assert answer == (True, 'odom goes on from x 2 m, y -3 m, yaw 2.5 rad', b'')
    moved_from(loop, begun, PLACE)
    assert pursue(loop, distance(0.5)).code is Code.NONE
    moved_from(loop, begun, PLACE)
    assert ask(loop, loop.driver.reset_odometry).ok
    assert pose(loop) == pytest.approx((0, 0, 0), abs=1e-3)


@pytest.mark.parametrize('place', [(nan, 0, 0), (0, inf, 0), (0, 0, nan), (0, 1.1e6, 0)])
def test_an_impossible_place_is_refused(loop, place):
    answer = ask(loop, loop.driver.reset_pose, *place)
    assert not answer.ok
    assert 'allowed: up to 1e+06 m from the origin, and a finite yaw' in answer.text
    assert pose(loop) == (0, 0, 0)


def test_a_robot_that_docks_is_where_its_dock_is():
    loop = Loop(Settings(dock_pose=PLACE), config=DEFAULT_BODY, world=BASE)
    loop.run(1.0)
    assert pose(loop) == (0, 0, 0)
    assert pursue(loop, Dock(0.0)).docked
    assert pose(loop) == pytest.approx(PLACE, abs=0.02)
    assert [each.text for each in loop.notices].count(
        'on the dock: odom goes on from dock_pose') == 1
    begun = loop.body.truth().pose
    assert pursue(loop, Undock(0.0)).code is Code.NONE
    moved_from(loop, begun, PLACE)


def test_a_robot_that_starts_on_its_dock_is_there():
    loop = Loop(Settings(dock_pose=PLACE), config=DEFAULT_BODY, world=BASE)
    loop.body.place(ON_BASE)
    loop.run(1.0)
    assert pose(loop) == pytest.approx(PLACE, abs=0.01)
