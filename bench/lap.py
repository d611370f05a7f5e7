# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A lap of the apartment with the simulated lidar, its scans laid out along the odometry."""

from collections.abc import Iterator
from dataclasses import replace
from math import atan2, copysign, hypot, remainder, tau
from typing import NamedTuple

import numpy as np

from create_oi_ros.driver import Driver, Moved, Settings
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.world import Pose, World
from create_oi_ros.sim.world.lidar import BEAMS, BEARINGS, Lidar, TURN

WAY = ((1.2, 1.2), (2.05, 2.1), (2.05, 3.85), (4.25, 3.85), (4.25, 1.65), (5.6, 1.9),
       (4.25, 1.65), (4.25, 3.85), (2.05, 3.85), (2.05, 2.1), (1.2, 1.2), (1.0, 1.0))
"""Through living room, study, hall and kitchen, and back; metres in the world's frame."""
SPEED, RATE = 0.3, 1.2
"""m/s and rad/s."""
THERE, AIMED = 0.08, 0.3
"""Metres and radians by which a place and a heading may be missed."""
STEP, PERIOD = 0.005, 0.1
"""Seconds of a step, and between two commands."""


class Laid(NamedTuple):
    """A scan in the world's frame, as the odometry has it."""

    x: np.ndarray
    """Metres of each beam's end; NaN where it met nothing."""
    y: np.ndarray
    robot: Pose


def lap(world: World, *, settings: Settings | None = None, seed: int = 0,
        stand: float = 4.0) -> Iterator[Laid]:
    """
    Drive the way by the odometry; yield each scan laid out along it.

    The robot stands for so many seconds first. Its gyro, which differs by seed, is read only if
    the settings have one.
    """
    body = Body(world, seed=seed, config=replace(DEFAULT_BODY, gyro=True))
    robot, driver = Create(body), Driver(settings or Settings())
    lidar, scans, slots = Lidar(world, 0.0, body.truth().pose), 0, []
    now, commanded, goals = 0.0, stand, list(WAY)
    driver.connected(now)
    while goals:
        now += STEP
        robot.poll(now)
        driver.receive(robot.data_to_send(), now)
        driver.poll(now)
        moved = None
        while (event := driver.next_event()) is not None:
            moved = event if isinstance(event, Moved) else moved
        robot.receive(driver.data_to_send(), now)
        if moved is None:
            continue
        x, y = world.start.ahead(moved.estimate.x, moved.estimate.y)
        here = Pose(x, y, world.start.yaw + moved.estimate.yaw)
        slots.append((robot.time, *here))
        lidar.step(robot.time, body.truth().pose)
        if lidar.scans > scans and now > commanded:
            scans = lidar.scans
            yield _laid(lidar.report(robot.time), robot.time, np.array(slots[-20:]), here)
        if now >= commanded + PERIOD:
            commanded = now
            if hypot(goals[0][0] - x, goals[0][1] - y) < THERE:
                goals.pop(0)
            driver.drive(*(_velocity(here, *goals[0]) if goals else (0.0, 0.0)), now)


def _velocity(here: Pose, x: float, y: float) -> tuple[float, float]:
    """Return m/s and rad/s towards a place."""
    bearing = remainder(atan2(y - here.y, x - here.x) - here.yaw, tau)
    if abs(bearing) > AIMED:
        return 0.0, copysign(min(RATE, 2 * abs(bearing)), bearing)
    return min(SPEED, hypot(x - here.x, y - here.y)), 1.5 * bearing


def _laid(scan: dict, time: float, slots: np.ndarray, here: Pose) -> Laid:
    """Lay each beam out from where the odometry had the robot at the beam's moment."""
    moments = time - scan['age'] + (np.arange(BEAMS) / BEAMS - 0.5) * TURN
    slots[:, 3] = np.unwrap(slots[:, 3])
    x, y, yaw = (np.interp(moments, slots[:, 0], slots[:, column]) for column in (1, 2, 3))
    far = np.array([np.nan if each is None else each for each in scan['ranges']])
    return Laid(x + far * np.cos(yaw + BEARINGS), y + far * np.sin(yaw + BEARINGS), here)
