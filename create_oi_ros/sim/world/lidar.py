# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A lidar on top of the robot: it turns ten times a second and measures what its beams meet.

A beam meets walls, posts and Home Bases. Each beam starts where the robot is at its own moment, so
the scan of a robot that moves is as bent as a real one.
"""

import math
from typing import Any, NamedTuple

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


class Scan(NamedTuple):
    """A whole turn."""

    middle: float
    """Seconds on the robot's clock at which half of the beams were measured."""
    ranges: list[float | None]
    """Metres, in the order of the beams; None: too near, too far, or nothing there."""


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
        self._began, self._measured = time, 0
        """When the present turn began, and the number of its beams that were measured."""
        self._before = time, pose
        self._ranges = np.full(BEAMS, np.inf)
        self.scans = 0
        """Number of whole turns."""
        self.scan: Scan | None = None
        """The last whole turn."""

    def step(self, time: float, pose: Pose) -> None:
        """Measure the beams whose moment has come: the robot has moved evenly to this pose."""
        while self._measured < (due := int((time - self._began) / TURN * BEAMS + 1e-6)):
            self._measure(min(due, BEAMS), time, pose)
            if due < BEAMS:
                break
            self.scan = Scan(self._began + TURN / 2, self._reported())
            self.scans += 1
            self._began, self._measured = self._began + TURN, 0
        self._before = time, pose

    def _measure(self, end: int, time: float, pose: Pose) -> None:
        """Measure the beams up to number `end` of the present turn."""
        beams = np.arange(self._measured, end)
        since, (x, y, yaw) = self._before
        part = (self._began + beams * (TURN / BEAMS) - since) / (time - since)
        self._ranges[beams] = self.cast(
            x + (pose.x - x) * part, y + (pose.y - y) * part,
            yaw + math.remainder(pose.yaw - yaw, math.tau) * part + BEARINGS[beams])
        self._measured = end

    def cast(self, x: Floats, y: Floats, heading: Floats) -> Floats:
        """Return how far rays from these places run, metres; inf: they meet nothing."""
        dx, dy = np.cos(heading)[:, None], np.sin(heading)[:, None]
        x, y = x[:, None], y[:, None]
        ax, ay, ux, uy, length = self._lines
        with np.errstate(divide='ignore', invalid='ignore'):
            cross = dx * uy - dy * ux
            to_lines = ((ax - x) * uy - (ay - y) * ux) / cross
            along = ((ax - x) * dy - (ay - y) * dx) / cross
            met = (to_lines >= 0) & (along >= 0) & (along <= length)
            px, py, radius = self._posts
            nearest = (px - x) * dx + (py - y) * dy
            inside = radius ** 2 - ((px - x) ** 2 + (py - y) ** 2 - nearest ** 2)
            to_posts = nearest - np.sqrt(inside)
        found: Floats = np.hstack([
            np.where(met, to_lines, np.inf),
            np.where((inside >= 0) & (to_posts >= 0), to_posts, np.inf)]).min(
                axis=1, initial=np.inf)
        return found

    def _reported(self) -> list[float | None]:
        noisy = self._ranges + self._random.normal(0.0, NOISE, BEAMS)
        return [round(far, 3) if NEAREST <= far <= FARTHEST else None for far in noisy.tolist()]
