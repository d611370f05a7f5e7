# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated lidar: its beams against the walls, and its scans along the odometry."""

from math import cos, hypot, inf, sin

import numpy as np
import pytest

from create_oi_ros.sim.world import parse, Pose, shipped, World
from create_oi_ros.sim.world.geometry import reach
from create_oi_ros.sim.world.lidar import BEARINGS, Lidar, NOISE, TURN
from lap import lap

SLOT = 0.015


def scanned(world: World, poses: list[Pose]) -> list[dict]:
    """Return the scans of a robot that moves from one pose to the next in each slot."""
    lidar, found = Lidar(world, 0.0, poses[0]), []
    for number, pose in enumerate(poses, 1):
        lidar.step(number * SLOT, pose)
        if lidar.scans > len(found):
            found.append(lidar.report(number * SLOT))
    return found


@pytest.mark.parametrize('name', ['room', 'apartment', 'table'])
def test_a_beam_ends_at_the_first_thing_in_its_way(name):
    world = shipped(name)
    x, y, yaw = world.start
    scan, = scanned(world, [world.start] * 7)
    for bearing, far in zip(BEARINGS, scan['ranges']):
        true = reach(world.obstacles, x, y, cos(yaw + bearing), sin(yaw + bearing))
        if far is None:
            assert not 0.12 + 4 * NOISE < true < 8.0 - 4 * NOISE
        else:
            assert far == pytest.approx(true, abs=5 * NOISE)


def test_distances_are_measured_from_12_cm_to_8_m_with_1_cm_of_noise():
    near_and_far = parse('wall -0.05 -9 -0.05 9 \n wall 8.5 -9 8.5 9 \n wall -9 2 9 2', 'walls')
    scans = scanned(near_and_far, [Pose()] * 700)
    assert all(scan['ranges'][0] is scan['ranges'][180] is None for scan in scans)
    beside = [scan['ranges'][270] for scan in scans]
    assert len(beside) == 105
    assert np.mean(beside) == pytest.approx(2.0, abs=0.005)
    assert np.std(beside) == pytest.approx(NOISE, rel=0.3)


def test_a_scan_is_as_old_as_the_middle_of_its_turn():
    ages = [scan['age'] for scan in scanned(shipped('room'), [Pose()] * 100)]
    assert all(TURN / 2 <= age < TURN / 2 + SLOT for age in ages)


def test_each_beam_starts_where_the_robot_is_at_its_moment():
    """A robot that drives 1 m/s towards a wall is 9 cm nearer when the last beams are measured."""
    wall = parse('wall 3 -9 3 9 \n wall -3 -9 -3 9', 'walls')
    scan, = scanned(wall, [Pose(x=SLOT * number) for number in range(1, 8)])
    ahead, behind_first, behind_last = (scan['ranges'][beam] for beam in (180, 0, 359))
    assert ahead == pytest.approx(3 - TURN / 2, abs=4 * NOISE)
    assert behind_last - behind_first == pytest.approx(TURN, abs=6 * NOISE)


def off_the_walls(world: World, scan) -> float:
    """Return how far the ends of the beams are off the nearest obstacle, metres, in the median."""
    gaps = []
    for x, y in zip(scan.x, scan.y):
        if np.isfinite(x):
            gaps.append(min((abs(each.gap(x, y)) for each in world.obstacles), default=inf))
    return float(np.median(gaps))


def test_scans_of_a_lap_draw_the_walls_of_the_apartment():
    """Laid out along the true way, whether the robot moves or not."""
    world = shipped('apartment')
    scans = list(lap(world, by_truth=True))
    assert len(scans) > 700
    assert hypot(scans[-1].robot.x - 1, scans[-1].robot.y - 1) < 0.1
    assert max(off_the_walls(world, scan) for scan in scans[::10]) < 0.03
