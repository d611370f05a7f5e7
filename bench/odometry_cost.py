# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What an update of the odometry costs: recorded drives, played again and again."""

from collections.abc import Sequence
from random import Random
from statistics import mean
from time import perf_counter_ns

from create_oi_ros.odometry import Estimate, Geometry, Increment, Odometry
from drives import DRIVES
from odometry_loop import Journey
from results import Figure
from robots import anywhere

SEED = 70_000
SECONDS, LATENCY = 120.0, 0.005
PLAYED = 3
"""Times that a drive is played. Of each update the shortest time counts, for what interrupts this
program is no cost of the odometry."""
MEAN, SLOWEST = 60.0, 1500.0
"""Targets, us."""


class Recorder(Odometry):
    """Keeps what it was given."""

    def __init__(self, geometry: Geometry) -> None:
        super().__init__(geometry, window=1.0)
        self.increments: list[Increment] = []

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in, and keep it."""
        self.increments.append(increment)
        return super().update(increment)


def recorded(style: str) -> Recorder:
    """Drive a robot that nobody knows; return its odometry."""
    random = Random(f'all ranges {SEED} {style}')
    robot = anywhere(random)
    odometry = Recorder(robot.geometry)
    journey = Journey(robot, SEED, latency=LATENCY, odometry=odometry)
    journey.drive(list(DRIVES[style](random, SECONDS)), SECONDS)
    return odometry


def played(increments: Sequence[Increment], geometry: Geometry) -> list[float]:
    """Return what each update costs, us."""
    odometry, costs = Odometry(geometry, window=1.0), []
    for increment in increments:
        begun = perf_counter_ns()
        odometry.update(increment)
        costs.append((perf_counter_ns() - begun) / 1000)
    return costs


def cost(style: str) -> list[float]:
    """Return the cost of each update in a kind of drive, us."""
    drive = recorded(style)
    return [min(times) for times in zip(
        *(played(drive.increments, drive.geometry) for _ in range(PLAYED)))]


def costs() -> list[Figure]:
    """Return what an update costs in each kind of drive."""
    found = {style: cost(style) for style in DRIVES}
    every = [each for part in found.values() for each in part]
    return [Figure('an update: mean', mean(every), 'us', MEAN, beside=', '.join(
                f'{style} {mean(part):.0f}' for style, part in found.items())),
            Figure('an update: slowest', max(every), 'us', SLOWEST)]
