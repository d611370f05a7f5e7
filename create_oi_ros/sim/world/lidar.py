# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A lidar on top of the robot: it turns ten times a second and measures what its beams meet.

A beam meets walls, posts and Home Bases. Each beam starts where the robot is at its own moment, so
the scan of a robot that moves is as bent as a real one.
"""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .geometry import Disc, LineSegment
from .world import Pose, World

BEAMS = 360
"""Beams of a turn, counter-clockwise from straight behind the robot."""
TURN = 0.1
"""Seconds of a turn."""
NEAREST, FARTHEST = 0.12, 8.0
"""Metres between which a distance is measured."""
NOISE = 0.01
"""Standard deviation of a distance, metres."""
BEARINGS = np.arange(BEAMS) * (math.tau / BEAMS) - math.pi
"""Of the beams, seen from the robot, left positive."""

Floats = npt.NDArray[np.floating[Any]]


class Lidar:
    """Measures a world from a robot that moves in it."""

    def __init__(self, world: World, time: float, pose: Pose, *, seed: int = 0) -> None:
        """Start at a time in seconds, with the robot at a pose."""
        lines = [each for each in world.obstacles if isinstance(each, LineSegment)]
        posts = [each for each in world.obstacles if isinstance(each, Disc)]
        self._lines = np.array(
            [(each.ax, each.ay, each.ux, each.uy, each.length) for each in lines]).reshape(-1, 5).T
        self._posts = np.array([(each.x, each.y, each.radius) for each in posts]).reshape(-1, 3).T
        self._random = np.random.default_rng(seed)
        self._began = time
        """When the present turn began."""
        self._poses = [(time, *pose)]
        """Where the robot was in this turn, and when."""
        self.scans = 0
        """Number of whole turns."""
        self._middle = time
        """When half of the beams of the last whole turn were measured."""
        self._ranges: list[float | None] = []

    def step(self, time: float, pose: Pose) -> None:
        """Measure a turn if it is over; the robot has moved evenly to this pose."""
        self._poses.append((time, *pose))
        if time < self._began + TURN - 1e-6:
            return
        times, x, y, yaw = np.array(self._poses).T
        moments = self._began + np.arange(BEAMS) * (TURN / BEAMS)
        measured = self.cast(
            np.interp(moments, times, x), np.interp(moments, times, y),
            np.interp(moments, times, np.unwrap(yaw)) + BEARINGS)
        noisy = measured + self._random.normal(0.0, NOISE, BEAMS)
        self._ranges = [round(far, 3) if NEAREST <= far <= FARTHEST else None
                        for far in noisy.tolist()]
        self._middle = self._began + TURN / 2
        self._began += TURN
        self._poses = self._poses[-2:]
        self.scans += 1

    def cast(self, x: Floats, y: Floats, heading: Floats) -> Floats:
        """Return how far rays from these places run, metres; inf: they meet nothing."""
        dx, dy = np.cos(heading), np.sin(heading)
        ax, ay, ux, uy, length = self._lines
        px, py, radius = self._posts
        across = np.array([uy, -ux])  # of a line: to the right of its direction
        with np.errstate(divide='ignore', invalid='ignore'):
            cross = np.column_stack([dx, dy]) @ across
            to_lines = (ax * uy - ay * ux - np.column_stack([x, y]) @ across) / cross
            along = (np.column_stack([dy, -dx]) @ np.array([ax, ay])
                     - (x * dy - y * dx)[:, None]) / cross
            met = (to_lines >= 0) & (along >= 0) & (along <= length)
            px, py = px - x[:, None], py - y[:, None]
            nearest = px * dx[:, None] + py * dy[:, None]
            to_posts = nearest - np.sqrt(radius ** 2 - (px ** 2 + py ** 2 - nearest ** 2))
        found: Floats = np.hstack([np.where(met, to_lines, np.inf),
                                   np.where(to_posts >= 0, to_posts, np.inf)]).min(
                                       axis=1, initial=np.inf)
        return found

    def report(self, time: float) -> dict[str, Any]:
        """
        Return the last whole turn at a time on the robot's clock: metres and seconds.

        `age` is the time since half of its beams were measured. `ranges` has the beams counter-
        clockwise from straight behind the robot; None: too near, too far, or nothing there.
        """
        return {'age': round(time - self._middle, 6), 'turn': TURN, 'nearest': NEAREST,
                'farthest': FARTHEST, 'ranges': self._ranges}
