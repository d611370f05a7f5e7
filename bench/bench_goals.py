# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How exact goals are: `python bench/bench_goals.py`, minutes, tables.

Robots are drawn at random as for the odometry (`robots`), and each pursues goals one after the
other, byte by byte between the whole driver and the whole simulated robot. The truth is the
simulator's. For each kind of goal and class of robot:

  error  |true way - wanted way|, mm or degrees, after the robot has come to rest
  beyond error over what is allowed: 5 mm + 0.5 % of a distance, 1 degree + 0.3 % of an angle
  over   how far the robot went beyond its goal on the way, mm or degrees
  time   seconds, over those of the trapezoid alone

Then cancels: frames from a cancel to a request of zero. With `--soak N`: N goals one after the
other on one robot, cancels, bumps and superseding among them, and the memory before and after.
"""

from argparse import ArgumentParser
from collections.abc import Iterator
from math import degrees, radians
from multiprocessing import Pool
from random import Random
import resource
from statistics import mean, quantiles
import tracemalloc
from typing import NamedTuple

from create_oi_ros import oi
from create_oi_ros.driver.goals import Code, DriveDistance, Goal, RotateAngle
from create_oi_ros.driver.goals.approach import ACCELERATION, BRAKING
from odometry_loop import Journey
from results import Figure, keep, machine
from robots import CLASSES, spread

GOALS = 1000
EACH = 10
"""Goals of a robot."""
KINDS = ('centre', 'all ranges')
LATENCY = 0.005
HELD_OUT = 10_000
REST = 1.5
"""Seconds after which a robot certainly stands."""
PATIENCE = 120.0
MM, HALF_TRACK = 1000.0, 0.129


class Score(NamedTuple):
    """How one goal was reached."""

    kind: str
    goal: str
    error: float
    """mm or degrees."""
    beyond: float
    over: float
    slow: float
    code: Code


def wish(random: Random) -> tuple[str, float, float]:
    """Draw a goal: its kind, how far, and how fast."""
    if random.random() < 0.5:
        return ('drive_distance', random.choice((1, 1, -1)) * spread(random, 0.02, 3.0),
                spread(random, 0.08, 0.5))
    return ('rotate_angle', random.choice((1, -1)) * radians(spread(random, 3, 1080)),
            spread(random, 0.4, 3.0))


def goal_of(journey: Journey, name: str, way: float, speed: float) -> Goal:
    """Return the goal that the driver pursues."""
    goals = journey.driver.goals
    if name == 'drive_distance':
        return DriveDistance(way, speed, 0.0, goals.straight)
    return RotateAngle(way, speed, 0.0, goals.turning)


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
    goal = goal_of(journey, name, way, speed)
    running = journey.driver.goals.start(goal, journey.now)
    sign, furthest = (1.0 if way > 0 else -1.0), 0.0
    while running.ending is None and journey.now - begun_at < PATIENCE:
        journey.go()
        furthest = max(furthest, sign * (place() - begun))
    took = journey.now - begun_at
    for _ in range(round(REST / oi.SLOT) * 3):
        journey.go()
    error = abs(place() - begun - way)
    unit = MM if straight else degrees(1.0)
    top = speed if straight else speed * HALF_TRACK
    length = abs(way) * (1 if straight else HALF_TRACK)
    ideal = length / top + top / 2 * (1 / ACCELERATION + 1 / BRAKING)
    code = running.ending.code if running.ending else Code.TIMEOUT
    return Score(kind, name, error * unit, error / allowed(name, way),
                 max(0.0, furthest - abs(way)) * unit, took - ideal, code)


def series(job: tuple[str, int]) -> list[Score]:
    """Let one robot pursue some goals."""
    kind, seed = job
    random = Random(f'{kind} {seed}')
    robot = CLASSES[kind](random)
    journey = Journey(robot, seed, latency=LATENCY)
    while journey.now < 1.0:
        journey.go()
    return [pursue(journey, kind, *wish(random)) for _ in range(EACH)]


def cancels(count: int) -> list[int]:
    """Cancel goals at random moments; return the frames until zero was requested."""
    random, frames = Random(1), []
    journey = Journey(CLASSES['centre'](random), 1)
    while journey.now < 1.0:
        journey.go()
    for _ in range(count):
        name, way, speed = wish(random)
        running = journey.driver.goals.start(goal_of(journey, name, 9 * way, speed), journey.now)
        until = journey.now + random.uniform(0.1, 1.0)
        while journey.now < until:
            journey.go()
        journey.driver.goals.cancel(running, journey.now)
        waited = 0
        while journey.robot.actuators.wheels != (0, 0):
            journey.go()
            waited += 1
        frames.append(-(-waited // 3))
    return frames


def percentile(values: list[float]) -> float:
    """Return the 95th percentile."""
    return quantiles(values, n=20, method='inclusive')[-1]


def show(scores: list[Score]) -> Iterator[str]:
    """Yield the lines of the table."""
    yield (f'{"goal":16} {"robots":12}    n   error: mean   95th    worst  beyond: 95th  worst'
           '   over: 95th  worst   time  failed')
    for name in ('drive_distance', 'rotate_angle'):
        for kind in KINDS:
            some = [s for s in scores if s.goal == name and s.kind == kind]
            if len(some) < 2:
                continue
            errors, over = [s.error for s in some], [s.over for s in some]
            beyond = [s.beyond for s in some]
            failed = sum(s.code is not Code.NONE for s in some)
            yield (f'{name:16} {kind:12} {len(some):4}  {mean(errors):11.3f} '
                   f'{percentile(errors):6.2f} {max(errors):8.2f} '
                   f'{percentile(beyond):13.2f} {max(beyond):6.2f} '
                   f'{percentile(over):12.2f} {max(over):6.2f} '
                   f'{mean(s.slow for s in some):6.1f} {failed:7}')


def figures(scores: list[Score], frames: list[int]) -> list[Figure]:
    """Return the figures that have targets; less is better."""
    made = []
    for name, unit in (('drive_distance', 'mm'), ('rotate_angle', 'deg')):
        for kind in KINDS:
            some = [s for s in scores if s.goal == name and s.kind == kind]
            beyond = [s.beyond for s in some]
            made.append(Figure(
                f'{name}, {kind}: 95th percentile of the error over what is allowed',
                percentile(beyond), '', 1.0, worst=max(beyond),
                beside=f'error: mean {mean(s.error for s in some):.2f} {unit}, 95th percentile '
                f'{percentile([s.error for s in some]):.2f} {unit}'))
    made.append(Figure('frames from a cancel to a request of zero', max(frames), '', 1.0))
    return made


def soak(count: int) -> None:
    """Pursue many goals on one robot; print what memory they leave behind."""
    random = Random(7)
    journey = Journey(CLASSES['centre'](random), 7)
    while journey.now < 1.0:
        journey.go()
    ended: dict[str, int] = {}
    tracemalloc.start()
    before = 0
    for number in range(count):
        if number == count // 10:
            before = tracemalloc.get_traced_memory()[0]
        name, way, speed = wish(random)
        running = journey.driver.goals.start(goal_of(journey, name, way / 20, speed), journey.now)
        chance = random.random()
        until = journey.now + (random.uniform(0.1, 1.0) if chance < 0.6 else PATIENCE)
        if chance < 0.2:
            journey.body.force(seconds=0.1, bump_left=1)
        while running.ending is None and journey.now < until:
            journey.go()
        journey.moves.clear()
        journey.counts.clear()
        if chance < 0.4:
            journey.driver.goals.cancel(running, journey.now)
        if running.ending is not None:
            text = running.ending.code.name
            ended[text] = ended.get(text, 0) + 1
    grown = tracemalloc.get_traced_memory()[0] - before
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f'{count} goals, {journey.now / 3600:.1f} h of driving: {ended}; memory grew by '
          f'{grown / 1024:.0f} KiB since the first tenth, peak {peak / 1024:.0f} MiB')


def main() -> None:
    """Print the tables; keep the figures."""
    parser = ArgumentParser()
    parser.add_argument('--goals', type=int, default=GOALS)
    parser.add_argument('--seed', type=int, default=HELD_OUT, help='the first')
    parser.add_argument('--processes', type=int, default=None)
    parser.add_argument('--soak', type=int, default=0, metavar='N', help='only pursue N goals')
    options = parser.parse_args()
    if options.soak:
        soak(options.soak)
        return
    where = machine()
    jobs = [(kind, options.seed + i) for i in range(options.goals // EACH // len(KINDS))
            for kind in KINDS]
    with Pool(options.processes) as pool:
        scores = [each for some in pool.imap_unordered(series, jobs) for each in some]
    print('\n'.join(show(scores)))
    frames = cancels(100)
    print(f'cancel to a request of zero: {max(frames)} frames at most')
    if options.goals == GOALS and options.seed == HELD_OUT:
        keep('bench_goals', figures(scores, frames), where)


if __name__ == '__main__':
    main()
