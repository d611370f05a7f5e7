# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How good the odometry is: `python bench/bench_odometry.py`, ten minutes, some tables.

Robots are drawn at random from what was measured and reported of real ones (`robots`), each drives
two to five minutes in one of five ways (`drives`), byte by byte between the whole driver and the
whole simulated robot, with default parameters. Then some of each class drive from place to place
(`waypoints`). By class of robot:

  turn   |yaw error| at the end, degrees, for each 360 degrees of true rotation either way
  place  distance from estimated to true place at the end, per cent of the true path's length
  NEES   normalised estimation error squared of (x, y, yaw) at the end; 3 is calibrated
  >4     drives that end more than 4 standard deviations off in yaw
  ever   drives that are so at some moment
  step   largest correction of the published yaw within half a second, beyond its own turn rate,
         degrees
  worse  by how much a drive was worse than a reading a second, degrees a turn, at most

Then all figures: those, the conditions of `odometry_rig` (slip, held wheels, a lifted or pushed
robot, demos), short drives (`odometry_starts`), the trials of `odometry_cases` (a damaged line
and, with `--logs FOLDER`, logs of real wheels), and what an update costs (`odometry_cost`).

`odometry_before.json` has what the estimator before this one reached, with date and machine. With
`--drives 70` the classes are large enough for a tenth of a degree; the figures that are kept, and
those from before, are of the everyday size.
"""

from argparse import ArgumentParser
from collections import deque
from collections.abc import Iterable
import json
from math import degrees, hypot, tau
from multiprocessing import Pool
from multiprocessing.pool import Pool as Workers
from pathlib import Path
from random import Random
from statistics import mean
from typing import NamedTuple

from create_oi_ros.robot import Rounding
from drives import DRIVES, waypoints
from odometry_cases import damaged_line, follow_log, rows_of
from odometry_cost import costs
from odometry_loop import Journey
from odometry_rig import Condition, CONDITIONS, follow, nees_of, simulate
from odometry_starts import starts
from results import Figure, keep, machine, percentile, show_all
from rivals import Rival
from robots import CLASSES

DRIVES_EACH, ROUTES = 20, 8
"""Robots of each class, four for each kind of drive; and those that drive to waypoints."""
ROUTE = 'waypoints'
STYLES = {**DRIVES, ROUTE: waypoints}
HELD_OUT = 80_000
"""First seed; others served for tuning."""
SHORTEST, LONGEST = 120.0, 300.0
"""Seconds of a drive."""
LATENCY = 0.005
SOON = 0.5
"""Seconds within which corrections count as one step."""
MOST_STEP, MOST_BEYOND, MOST_EVER = 5.0, 1.0, 4.3
"""Degrees of a correction; per cent of the drives that may end more than 4 standard deviations
off, or be so at some moment."""
WORSE, MOST_WORSE, SELDOM_WORSE = 0.3, 0.5, 0.84
"""Degrees a turn from which on a drive counts as worse than a reading a second, by which it may be
so at most, and per cent of all drives for which it may."""
NEES_LEAST, NEES_MOST = 1.5, 6.0
LINES = 5
"""Drives over a damaged line under each rounding."""
MOST_LOST, LOG_END, LOG_MOST = 2.0, 2.0, 5.0
"""Per cent of the way that a damaged line may cost; degrees off a log of wheels."""
SECOND = 'a reading a second'
RIVALS = {SECOND: 1.0, 'each frame': 0.0}
OLD_DRIVES = 4
"""Drives of each condition, each under every rounding."""
BEFORE: dict[str, float] = json.loads(
    Path(__file__).with_name('odometry_before.json').read_text('utf-8'))['figures']
"""What the estimator before this one reached; when and on what machine, the file says."""
NO_WORSE = 1.25
"""Times that as which a condition may be."""


class Target(NamedTuple):
    """What a class is to reach: mean and 95th percentile."""

    turn: tuple[float, float]
    place: tuple[float, float]


TARGETS: dict[str, Target | None] = {
    'centre': Target((0.18, 0.55), (0.6, 1.5)),
    'all ranges': Target((0.21, 0.6), (1.0, 3.0)),
    'carried, true sign': Target((0.06, 0.2), (0.3, 0.8)),
    'all ranges, unsteady': None,
}


class Score(NamedTuple):
    """How one drive ended."""

    turn: float
    place: float
    nees: float = 0.0
    sigmas: float = 0.0
    most_sigmas: float = 0.0
    step: float = 0.0
    worse: float = 0.0
    response: str = ''
    """How the robot's wheels answer."""


Result = tuple[str, str, str, Score]
"""Class, kind of drive, estimator and how well it did."""
Cells = dict[tuple[str, str], list[Score]]
"""Scores by class, also by kind of drive or response of the wheels, and by estimator."""


def drive(kind: str, style: str, seed: int) -> list[Result]:
    """Drive once; score the odometry and its rivals."""
    random = Random(f'{kind} {seed}')
    robot = CLASSES[kind](random)
    seconds = random.uniform(SHORTEST, LONGEST)
    journey = Journey(robot, seed, latency=LATENCY)
    journey.drive(list(STYLES[style](random, seconds)), seconds)
    truth = journey.body.truth()

    def missed(x: float, y: float, yaw: float) -> Score:
        return Score(degrees(abs(yaw - truth.turned)) / max(journey.turned / tau, 1.0),
                     100 * hypot(x - truth.pose.x, y - truth.pose.y) / max(journey.path, 0.5))

    scores = {}
    for name, interval in RIVALS.items():
        rival = Rival(robot, interval).follow(journey.counts)
        scores[name] = missed(rival.x, rival.y, rival.yaw)
    e = journey.estimate
    ours = missed(e.x, e.y, e.yaw)
    scores['ours'] = ours._replace(
        nees=nees_of(truth.pose.x, truth.pose.y, truth.turned, e),
        sigmas=abs(e.yaw - truth.turned) / e.pose_covariance[8] ** 0.5,
        most_sigmas=journey.most_sigmas, step=largest_step(journey),
        worse=ours.turn - scores[SECOND].turn, response=robot.config.response.value)
    return [(kind, style, name, score) for name, score in scores.items()]


def largest_step(journey: Journey) -> float:
    """
    Return the largest correction within SOON, degrees.

    It is what the published yaw changed by beyond what the published turn rate accounts for.
    """
    corrections, largest = deque([(0.0, 0.0)]), 0.0
    for (was, before, _), (stamp, e, _) in zip(journey.moves, journey.moves[1:]):
        correction = e.yaw - before.yaw - e.angular * (stamp - was)
        corrections.append((stamp, corrections[-1][1] + correction))
        while corrections[0][0] < stamp - SOON:
            corrections.popleft()
        largest = max(largest, abs(corrections[-1][1] - corrections[0][1]))
    return degrees(largest)


def show(name: str, estimator: str, scores: list[Score]) -> str:
    """Return a line of the table."""
    turn, place = [s.turn for s in scores], [s.place for s in scores]
    line = (f'{name:28} {estimator:18} {len(scores):3}  {mean(turn):6.3f} {percentile(turn):6.3f} '
            f'{mean(place):6.2f} {percentile(place):6.2f}')
    if estimator == 'ours':
        beyond, ever = sum(s.sigmas > 4 for s in scores), sum(s.most_sigmas > 4 for s in scores)
        line += (f'  {mean(s.nees for s in scores):6.2f} {beyond:3} {ever:4} '
                 f'{max(s.step for s in scores):6.1f} {max(s.worse for s in scores):6.2f}')
    return line


def print_table(results: Iterable[Result]) -> Cells:
    """Print the table by class and by kind of drive, and return it."""
    cells: Cells = {}
    for kind, style, estimator, score in results:
        for name in (kind, f'{kind}: {style}', f'{kind}, {score.response} wheels'):
            cells.setdefault((name, estimator), []).append(score)
    print(f'{"":51}  deg a turn    % of path\n'
          f'{"robots":28} {"by":18}   n    mean   95th   mean   95th    NEES  >4 ever   step'
          '  worse')
    for (name, estimator), scores in sorted(cells.items()):
        if scores[0].response or ' wheels' not in name:
            print(show(name, estimator, scores))
    return cells


def figures(kind: str, scores: list[Score], second: list[Score]) -> list[Figure]:
    """Return a class as figures, beside those of a reading a second."""
    target, made = TARGETS[kind], []
    for unit, values, others, mosts in (
            ('deg a turn', [s.turn for s in scores], [s.turn for s in second],
             target and target.turn),
            ('% of the path', [s.place for s in scores], [s.place for s in second],
             target and target.place)):
        for which, of in (('', mean), (', 95th percentile', percentile)):
            what = f'{kind}: {unit}{which}'
            most = mosts[bool(which)] if mosts else BEFORE[what]
            made.append(Figure(what, of(values), unit, most,
                               beside=f'{SECOND} {of(others):.3g}'))
    honest = mean(s.nees for s in scores)
    if target is None:
        return [*made, Figure(f'{kind}: NEES', honest, '')]
    return [
        *made,
        Figure(f'{kind}: NEES, at least', honest, '', NEES_LEAST, at_least=True),
        Figure(f'{kind}: NEES, at most', honest, '', NEES_MOST),
        Figure(f'{kind}: drives beyond 4 standard deviations',
               100 * mean(s.sigmas > 4 for s in scores), '%', MOST_BEYOND),
        Figure(f'{kind}: drives beyond 4 standard deviations at some moment',
               100 * mean(s.most_sigmas > 4 for s in scores), '%', MOST_EVER),
        Figure(f'{kind}: largest correction in half a second', max(s.step for s in scores), 'deg',
               MOST_STEP)]


def routes(cells: Cells) -> list[Figure]:
    """Return drives to waypoints as figures; a reading a second is what they must not exceed."""
    made = []
    for kind in TARGETS:
        ours, second = (cells[f'{kind}: {ROUTE}', name] for name in ('ours', SECOND))
        for unit, which in (('deg a turn', 'turn'), ('% of the path', 'place')):
            value, most = (mean(getattr(s, which) for s in scores) for scores in (ours, second))
            made.append(Figure(f'{kind}, {ROUTE}: {unit}', value, unit, most,
                               beside=f'{SECOND} {most:.3g}'))
    return made


def worse(scores: list[Score]) -> list[Figure]:
    """Return how often, and by how much, all drives were worse than a reading a second."""
    return [Figure(f'drives worse than {SECOND} by more than {WORSE} deg a turn',
                   100 * mean(s.worse > WORSE for s in scores), '%', SELDOM_WORSE),
            Figure(f'worse than {SECOND}, at most', max(s.worse for s in scores), 'deg a turn',
                   MOST_WORSE)]


def conditions(cells: Cells) -> list[Figure]:
    """Return the old conditions as figures, each the mean of all roundings."""
    made = []
    for condition in CONDITIONS:
        scores = cells[condition.name, 'ours']
        for what, value in (('deg a turn', mean(s.turn for s in scores)),
                            ('% of the path', mean(s.place for s in scores))):
            name = f'{condition.name}: {what}'
            made.append(Figure(name, value, what, NO_WORSE * BEFORE[name]))
    return made


def trials(pool: Workers, logs: Path | None) -> list[Figure]:
    """Drive over a damaged line and follow logs of real wheels; return figures."""
    made = []
    for rounding in Rounding:
        missed = pool.starmap(damaged_line, [(rounding, seed) for seed in range(LINES)])
        made.append(Figure(f'damaged line, {rounding.value}: % of the way', max(missed),
                           '% of the way', MOST_LOST))
    if logs is None:
        return made
    for rounding in Rounding:
        strays = [follow_log(rows_of(path), rounding) for path in logs.glob('wheels_*.csv')]
        made += [Figure(f'logs of real wheels, {rounding.value}: {what}', max(values), 'deg', most)
                 for what, most, values in (
                     ('off at the end', LOG_END, [stray.end for stray in strays]),
                     ('off at any moment', LOG_MOST, [stray.most for stray in strays]))]
    return made


def old(job: tuple[Condition, int]) -> list[Result]:
    """Follow a drive of the old conditions under every rounding."""
    condition, seed = job
    instants = simulate(seed, condition)
    found = []
    for rounding in Rounding:
        score = follow(instants, rounding, condition)
        found.append((condition.name, rounding.value, 'ours',
                      Score(score.turn, score.distance, score.nees)))
    return found


def main() -> None:
    """Print the tables; keep the figures."""
    parser = ArgumentParser()
    parser.add_argument('--drives', type=int, default=DRIVES_EACH, help='of each class')
    parser.add_argument('--seed', type=int, default=HELD_OUT, help='the first')
    parser.add_argument('--processes', type=int, default=None)
    parser.add_argument('--logs', type=Path, default=None, metavar='FOLDER',
                        help='logs of real wheels, which are not part of the project')
    options = parser.parse_args()
    where = machine()
    styles = list(DRIVES)
    jobs = [(kind, styles[i % len(styles)], options.seed + i)
            for i in range(options.drives) for kind in TARGETS]
    with Pool(options.processes) as pool:
        cells = print_table(
            [each for some in pool.starmap(drive, jobs, chunksize=1) for each in some])
        of_routes = routes(print_table(
            [each for some in pool.starmap(drive, [
                (kind, ROUTE, options.seed + i) for i in range(ROUTES) for kind in TARGETS])
             for each in some]))
        old_jobs = [(c, seed) for c in CONDITIONS for seed in range(OLD_DRIVES)]
        of_conditions = conditions(print_table(
            [each for some in pool.imap_unordered(old, old_jobs) for each in some]))
        made = [each for kind in TARGETS for each in figures(
            kind, cells[kind, 'ours'], cells[kind, SECOND])]
        made += worse([score for kind in TARGETS for score in cells[kind, 'ours']])
        made += of_routes
        made += of_conditions
        made += starts(pool)
        made += trials(pool, options.logs)
    made += costs()
    made = [figure._replace(beside='; '.join(filter(None, (
        f'before {BEFORE[figure.what]:.3g}' if figure.what in BEFORE else '', figure.beside))))
        for figure in made]
    show_all(made)
    if options.drives == DRIVES_EACH and options.seed == HELD_OUT:
        keep('bench_odometry', made, where)


if __name__ == '__main__':
    main()
