# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a gyro is worth: degrees of heading error in a minute of driving, with it and without.

Each robot has its own gyro and drive. It first stands for half a minute and drives two on a hard
floor, with a gyro of which only the data sheet is known; what the driver has learned then is what
it starts with. Before the minute it stands for 20 seconds. The whole driver and the whole
simulated robot talk as bytes.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import degrees
from multiprocessing import Pool
from random import Random
from statistics import mean
from typing import Any

from create_oi_ros.odometry import GyroSettings, Knowledge
from create_oi_ros.robot import SLOT
from create_oi_ros.sim.body import Body
from drives import DRIVES
from odometry_loop import Journey
from odometry_rig import bursts, nothing, slip
from results import Figure, run
from robots import centre

SHEET = GyroSettings()
SEEDS = range(70_000, 70_016)
"""Nobody tuned on these."""
STYLES = ('smooth', 'straight')
REST, MINUTE, LATENCY = 20.0, 60.0, 0.005
HAND = 0.15
"""Seconds in which a hand speeds a robot up, or slows it down."""
MOST = 1.0
"""Degrees a minute, of the mean."""


def turned_by_hand(random: Random, body: Body, ramp: float = HAND) -> Iterator[bool]:
    """Lift the robot now and then, turn it, speeding up for `ramp` seconds, and put it down."""
    before, rate, left, lasts = False, 0.0, 0.0, 0.0
    for begins, on in bursts(random, 20, 4):
        if on and not before:
            body.lift(True)
        if begins:
            rate = random.choice((1, -1)) * random.uniform(0.5, 2.0)
            left = lasts = random.uniform(0.3, 1.3)
        if left > 0:
            part = min(1.0, left / ramp, (lasts - left) / ramp)
            body.push(speed=0.0, rate=part * rate, seconds=2 * SLOT)
            left -= SLOT
        if before and not on:
            body.lift(False)
        before = on
        yield not on


FLOORS = {
    'hard floor': (0.0, nothing), 'slip bursts': (0.0, slip), 'carpet, 2 % slip': (0.02, nothing),
    'carpet, 10 % slip': (0.1, nothing), 'lifted and turned': (0.0, turned_by_hand),
    'lifted and turned at once': (0.0, partial(turned_by_hand, ramp=SLOT))}


def journey_on(part: float, seed: int, **options: Any) -> Journey:
    """Return a journey of a robot with a gyro on a floor where wheels slip by a part."""
    robot = centre(Random(seed))
    return Journey(replace(robot, config=replace(
        robot.config, gyro=True, right_slip=part, left_slip=part)), seed, latency=LATENCY,
        **options)


def off(journey: Journey) -> float:
    """Return the error of the heading, degrees."""
    return degrees(journey.estimate.yaw - journey.body.truth().turned)


def learned(seed: int) -> Knowledge:
    """Return what a driver has learned of a robot and its gyro on a hard floor."""
    first = journey_on(0.0, seed, gyro=SHEET)
    turns = [(30.0 + 7 * turn + at, 0.0, rate) for turn in range(6)
             for at, rate in ((0.0, 1.3 if turn % 2 else -1.3), (5.0, 0.0))]
    rest = [(75.0 + at, *wish) for at, *wish in DRIVES['straight'](Random(seed), 85.0)]
    first.drive([*turns, *rest], 165.0)
    robot = first.driver.health(first.now).robot
    assert robot is not None
    return robot


def minute(job: tuple[str, int, Knowledge, bool]) -> tuple[str, bool, float]:
    """Drive for a minute; return the error that it has added, degrees."""
    floor, seed, known, gyro = job
    part, event = FLOORS[floor]
    journey = journey_on(part, seed, gyro=SHEET if gyro else None, known=known)
    journey.drive([], REST)
    before, journey.event = off(journey), event(Random(f'{floor} {seed}'), journey.body)
    wishes = DRIVES[STYLES[seed % len(STYLES)]](Random(seed), MINUTE)
    journey.drive([(REST + at, linear, angular) for at, linear, angular in wishes], REST + MINUTE)
    return floor, gyro, abs(off(journey) - before)


def measure() -> list[Figure]:
    """Return the mean and the worst of each floor."""
    with Pool(2) as pool:
        known = pool.map(learned, SEEDS)
        jobs = [(floor, seed, robot, gyro) for floor in FLOORS
                for seed, robot in zip(SEEDS, known) for gyro in (True, False)]
        found = pool.map(minute, jobs, chunksize=1)
    errors = {(floor, gyro): [error for at, had, error in found if (at, had) == (floor, gyro)]
              for floor in FLOORS for gyro in (True, False)}
    return [Figure(floor, mean(errors[floor, True]), 'deg a minute', MOST,
                   worst=max(errors[floor, True]),
                   beside=f'without {mean(errors[floor, False]):.3g}, '
                          f'at most {max(errors[floor, False]):.3g}')
            for floor in FLOORS]


if __name__ == '__main__':
    run('bench_gyro', measure)
