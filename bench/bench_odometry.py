# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How good the odometry is: `python bench/bench_odometry.py`, three minutes, one table.

Robots are drawn at random from what was measured and reported of real ones (`robots`), or do not
do what they are asked (`odometry_rig`). Each drives for a while in one of five ways (`drives`),
byte by byte between the whole driver and the whole simulated robot, with default parameters. A row
has the heading's error at the end, degrees, root mean square, and beside it that of the simplest
thing: a reading a second, half a unit added where it is cut off. Then logs of real wheels
(`--logs FOLDER`; they are not part of the project), a damaged line, and what an update costs.
"""

from argparse import ArgumentParser
from collections.abc import Callable
from math import degrees, tau
from multiprocessing import Pool
from pathlib import Path
from random import Random
from statistics import mean
from typing import NamedTuple

import numpy as np

from create_oi_ros import oi
from create_oi_ros.odometry import Odometry
from create_oi_ros.robot import Rounding
from drives import DRIVES, waypoints
from odometry_cases import damaged_line, follow_log, rows_of
from odometry_cost import costs
from odometry_loop import Journey
from odometry_rig import Event, held, lame, loaded, Misled, nothing, pushed
from results import Figure, run
from rivals import Rival
from robots import anywhere, centre, exact, Robot, unsteady

HELD_OUT, EACH, LATENCY = 80_000, 10, 0.005
"""First seed, which served for no tuning; drives of a row; seconds of delay."""
SHORTEST, LONGEST = 60.0, 150.0
"""Seconds of a drive."""
FIRST_SHORTEST, FIRST_LONGEST, FIRST = 15.0, 40.0, 30.0
"""Seconds of a robot's first drive, and of that in which the worst moment counts."""
NO_WORSE, HALF = 1.1, 0.5
"""Times the error of a reading a second that is allowed, everywhere and where wheels follow."""
LINES, MOST_LOST = 3, 2.0
"""Drives over a damaged line under each rounding, and per cent of the way that it may cost."""
ANY, ROUTE = tuple(DRIVES.values()), (waypoints,)


class Row(NamedTuple):
    """A kind of robot, how it drives, what happens to it, and what is wanted of the odometry."""

    robot: Callable[[Random], Robot]
    styles: tuple[Callable[..., object], ...] = ANY
    event: Event = nothing
    part: float = NO_WORSE
    misled: bool = False


ROWS = {
    'wheels follow': Row(centre, part=HALF), 'all ranges': Row(anywhere, part=HALF),
    'unsteady wheels': Row(unsteady, part=HALF), 'carried, true signs': Row(exact),
    'waypoints: wheels follow': Row(centre, ROUTE, part=HALF),
    'waypoints: all ranges': Row(anywhere, ROUTE, part=HALF),
    'waypoints: carried': Row(exact, ROUTE),
    'a load halves the speed': Row(loaded), 'one wheel at 60 %': Row(lame),
    'requests that are not driven': Row(anywhere, misled=True),
    'pushed along': Row(anywhere, event=pushed), 'wheels held': Row(anywhere, event=held),
    'the first half minute': Row(anywhere)}


class Score(NamedTuple):
    """How one drive ended: degrees, the same a turn, its rival's, and how honest it was."""

    off: float
    rival: float
    turns: float
    nees: float
    beyond: float
    """Part of the time in which the yaw was off by more than two standard deviations."""
    most: float
    """Degrees at any moment of the first half minute."""


class Drive(Journey):
    """A journey that is scored."""

    def __init__(self, robot: Robot, seed: int, event: Event, odometry: Odometry | None) -> None:
        super().__init__(robot, seed, latency=LATENCY, odometry=odometry)
        self.event = event(Random(seed), self.body)
        self.off: list[float] = []
        self.beyond: list[bool] = []

    def go(self) -> None:
        """Let a step of time pass."""
        seen = len(self.moves)
        super().go()
        for _, e, _ in self.moves[seen:]:
            off = abs(e.yaw - self._turned[self._down.sent])
            self.off.append(degrees(off))
            self.beyond.append(off > 2 * e.pose_covariance[8] ** 0.5)


def drive(name: str, number: int) -> Score:
    """Drive once."""
    row, random = ROWS[name], Random(f'{name} {HELD_OUT + number}')
    robot = row.robot(random)
    first = name == 'the first half minute'
    seconds = random.uniform(*((FIRST_SHORTEST, FIRST_LONGEST) if first else (SHORTEST, LONGEST)))
    journey = Drive(robot, HELD_OUT + number, row.event,
                    Misled(robot.geometry, random) if row.misled else None)
    journey.drive(list(row.styles[number % len(row.styles)](random, seconds)), seconds)
    truth, e = journey.body.truth(), journey.estimate
    rival = Rival(robot, 1.0).follow(journey.counts)
    error = np.array([e.x - truth.pose.x, e.y - truth.pose.y, e.yaw - truth.turned])
    return Score(
        degrees(error[2]), degrees(rival.yaw - truth.turned), max(journey.turned / tau, 1.0),
        float(error @ np.linalg.solve(np.reshape(e.pose_covariance, (3, 3)), error)),
        mean(journey.beyond), max(journey.off[:int(FIRST / oi.SLOT)]))


def figure(name: str, scores: list[Score]) -> Figure:
    """Return a row of the table."""
    ours, rival = np.sqrt(np.mean(np.square([(s.off, s.rival) for s in scores]), axis=0)).tolist()
    worse = max((abs(s.off) - abs(s.rival)) / s.turns for s in scores)
    return Figure(
        name, ours, 'deg', ROWS[name].part * rival,
        beside=f'a reading a second {rival:.2f}; worse by {worse:.2f} deg a turn at most; NEES '
               f'{mean(s.nees for s in scores):.1f}; beyond 2 deviations '
               f'{100 * mean(s.beyond for s in scores):.0f} %; first half minute '
               f'{max(s.most for s in scores):.1f} deg at most')


def of_logs(folder: Path) -> list[Figure]:
    """Follow logs of real wheels under each rounding."""
    made = []
    for rounding in Rounding:
        errors = [follow_log(rows_of(path), rounding) for path in folder.glob('wheels_*.csv')]
        ours, rival = np.sqrt(np.mean(np.square(errors), axis=0)).tolist()
        made.append(Figure(f'logs of real wheels, {rounding.value}', ours, 'deg',
                           NO_WORSE * rival, beside=f'a reading a second {rival:.2f}'))
    return made


def measure(names: list[str], drives: int, logs: Path | None) -> list[Figure]:
    """Return the figures of these rows, each of so many drives, and of all else."""
    with Pool() as pool:
        jobs = [(name, number) for number in range(drives) for name in names]
        found = dict(zip(jobs, pool.starmap(drive, jobs, chunksize=1)))
        made = [figure(name, [found[name, number] for number in range(drives)]) for name in names]
        lines = pool.starmap(damaged_line, [
            (rounding, seed) for rounding in Rounding for seed in range(LINES)])
    made.append(Figure('damaged line', max(lines), '% of the way', MOST_LOST))
    return [*made, *([] if logs is None else of_logs(logs)), *costs()]


if __name__ == '__main__':
    parser = ArgumentParser()
    parser.add_argument('--drives', type=int, default=EACH, help='of each row')
    parser.add_argument('--rows', nargs='*', default=list(ROWS), choices=list(ROWS))
    parser.add_argument('--logs', type=Path, default=None, metavar='FOLDER',
                        help='logs of real wheels, which are not part of the project')
    options = parser.parse_args()
    run('bench_odometry', lambda: measure(options.rows, options.drives, options.logs),
        whole=options.drives == EACH and options.rows == list(ROWS))
