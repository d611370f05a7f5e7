# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How exact goals are: `python bench/bench_goals.py`, minutes, a table.

Robots are drawn at random as for the odometry (`robots`), and each pursues goals one after the
other, byte by byte between the whole driver and the whole simulated robot. The truth is the
simulator's. The error is measured after the robot has come to rest. Allowed are 5 mm + 0.5 % of a
distance, 1 degree + 0.3 % of an angle.
"""

from math import degrees, radians
from multiprocessing import Pool
from random import Random
from statistics import mean
from typing import NamedTuple

from create_oi_ros import oi
from create_oi_ros.driver.goals import DriveDistance, RotateAngle
from odometry_loop import Journey
from results import Figure, percentile, run
from robots import anywhere, centre, spread

GOALS = 1000
EACH = 10
"""Goals of a robot."""
KINDS = {'centre': centre, 'all ranges': anywhere}
MADE = {'drive_distance': DriveDistance, 'rotate_angle': RotateAngle}
LATENCY = 0.005
FIRST_SEED = 10_000
REST = 1.5
"""Seconds after which a robot certainly stands."""
PATIENCE = 120.0
MM = 1000.0


class Score(NamedTuple):
    kind: str
    goal: str
    error: float
    """mm or degrees."""
    beyond: float
    """The error over what is allowed."""


def wish(random: Random) -> tuple[str, float, float]:
    """Draw a goal: its kind, how far, and how fast."""
    if random.random() < 0.5:
        return ('drive_distance', random.choice((1, 1, -1)) * spread(random, 0.02, 3.0),
                spread(random, 0.08, 0.5))
    return ('rotate_angle', random.choice((1, -1)) * radians(spread(random, 3, 1080)),
            spread(random, 0.4, 3.0))


def allowed(name: str, way: float) -> float:
    """Return the error that is allowed, m or rad."""
    if name == 'drive_distance':
        return 0.005 + 0.005 * abs(way)
    return radians(1.0) + 0.003 * abs(way)


def pursue(journey: Journey, kind: str, name: str, way: float, speed: float) -> Score:
    """Pursue one goal to its end, and look where the robot is once it stands."""
    straight = name == 'drive_distance'

    def place() -> float:
        truth = journey.body.truth()
        return truth.travelled if straight else truth.turned
    begun_at, begun = journey.now, place()
    running = journey.driver.goals.start(MADE[name](way, speed, 0.0), journey.now)
    while running.outcome is None and journey.now - begun_at < PATIENCE:
        journey.go()
    for _ in range(round(REST / oi.SLOT) * 3):
        journey.go()
    error = abs(place() - begun - way)
    return Score(kind, name, error * (MM if straight else degrees(1.0)),
                 error / allowed(name, way))


def series(job: tuple[str, int]) -> list[Score]:
    """Let one robot pursue some goals."""
    kind, seed = job
    random = Random(f'{kind} {seed}')
    journey = Journey(KINDS[kind](random), seed, latency=LATENCY)
    while journey.now < 1.0:
        journey.go()
    return [pursue(journey, kind, *wish(random)) for _ in range(EACH)]


def measure() -> list[Figure]:
    jobs = [(kind, FIRST_SEED + i) for i in range(GOALS // EACH // len(KINDS)) for kind in KINDS]
    with Pool() as pool:
        scores = [each for some in pool.imap_unordered(series, jobs) for each in some]
    made = []
    for name, unit in (('drive_distance', 'mm'), ('rotate_angle', 'deg')):
        for kind in KINDS:
            some = [s for s in scores if s.goal == name and s.kind == kind]
            beyond = [s.beyond for s in some]
            made.append(Figure(
                f'{name}, {kind}: 95th percentile of the error over what is allowed',
                percentile(beyond, 95), '', 1.0, worst=max(beyond),
                beside=f'error: mean {mean(s.error for s in some):.2f} {unit}, 95th percentile '
                f'{percentile([s.error for s in some], 95):.2f} {unit}'))
    return made


if __name__ == '__main__':
    run('bench_goals', measure)
