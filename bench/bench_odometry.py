"""
How good the odometry is: `python bench/bench_odometry.py`, an hour, two tables.

Robots are drawn at random from what was measured and reported of real ones (`robots`), each drives
two to five minutes in one of five ways (`drives`), byte by byte between the whole driver and the
whole simulated robot, with default parameters. By class of robot:

  turn   |yaw error| at the end, degrees, for each 360 degrees of true rotation either way
  place  distance from estimated to true place at the end, per cent of the true path's length
  NEES   normalised estimation error squared of (x, y, yaw) at the end; 3 is calibrated
  >4     drives that end more than 4 standard deviations off in yaw
  step   largest correction of the published yaw within half a second, beyond its own turn rate,
         degrees
  worse  by how much a drive was worse than a reading a second, degrees a turn, at most

Then the conditions of `odometry_rig`: slip, held wheels, a lifted or pushed robot, demos.
"""

from argparse import ArgumentParser
from collections import deque
from collections.abc import Iterable
from math import degrees, hypot, tau
from multiprocessing import Pool
from random import Random
from statistics import mean, quantiles
from typing import NamedTuple

from create_oi_ros.sim.body.encoders import Rounding
from drives import DRIVES
from odometry_loop import Journey
from odometry_rig import Condition, CONDITIONS, follow, nees_of, simulate
from results import Figure, keep, machine
from rivals import Rival
from robots import CLASSES

DRIVES_EACH = 70
"""Robots of each class."""
HELD_OUT = 10_000
"""First seed; those from 0 on served for tuning."""
SHORTEST, LONGEST = 120.0, 300.0
"""Seconds of a drive."""
LATENCY = 0.005
SOON = 0.5
"""Seconds within which corrections count as one step."""
RIVALS = {'a reading a second': 1.0, 'each frame': 0.0}
OLD_DRIVES = 10


class Target(NamedTuple):
    """What a class is to reach: mean and 95th percentile."""

    turn: tuple[float, float]
    place: tuple[float, float]


TARGETS = {
    'centre': Target((0.2, 0.5), (0.6, 1.5)),
    'all ranges': Target((0.3, 1.0), (1.0, 3.0)),
    'carried, true sign': Target((0.05, 0.15), (0.3, 0.8)),
}


class Score(NamedTuple):
    """How one drive ended."""

    turn: float
    place: float
    nees: float = 0.0
    sigmas: float = 0.0
    step: float = 0.0
    worse: float = 0.0


Result = tuple[str, str, str, Score]
"""Class, kind of drive, estimator and how well it did."""


def drive(kind: str, style: str, seed: int) -> list[Result]:
    """Drive once; score the odometry and its rivals."""
    random = Random(f'{kind} {seed}')
    robot = CLASSES[kind](random)
    seconds = random.uniform(SHORTEST, LONGEST)
    journey = Journey(robot, seed, latency=LATENCY)
    journey.drive(list(DRIVES[style](random, seconds)), seconds)
    truth = journey.body.truth()

    def missed(x: float, y: float, yaw: float) -> Score:
        return Score(degrees(abs(yaw - truth.turned)) / max(journey.turned / tau, 1.0),
                     100 * hypot(x - truth.pose.x, y - truth.pose.y) / max(journey.path, 0.5))

    scores = {}
    for name, interval in RIVALS.items():
        rival = Rival(robot.geometry, robot.rounding, interval)
        for slot, counts in enumerate(journey.counts, 1):
            rival.frame(counts, robot.period, last=slot == len(journey.counts))
        scores[name] = missed(rival.x, rival.y, rival.yaw)
    e = journey.estimate
    ours = missed(e.x, e.y, e.yaw)
    scores['ours'] = ours._replace(
        nees=nees_of(truth.pose.x, truth.pose.y, truth.turned, e),
        sigmas=abs(e.yaw - truth.turned) / e.pose_covariance[8] ** 0.5,
        step=largest_step(journey), worse=ours.turn - scores['a reading a second'].turn)
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


def percentile(values: list[float]) -> float:
    """Return the 95th percentile."""
    return quantiles(values, n=20, method='inclusive')[-1] if len(values) > 1 else values[0]


def show(name: str, estimator: str, scores: list[Score]) -> str:
    """Return a line of the table."""
    turn, place = [s.turn for s in scores], [s.place for s in scores]
    line = (f'{name:28} {estimator:18} {len(scores):3}  {mean(turn):6.3f} {percentile(turn):6.3f} '
            f'{mean(place):6.2f} {percentile(place):6.2f}')
    if estimator == 'ours':
        beyond = sum(s.sigmas > 4 for s in scores)
        line += (f'  {mean(s.nees for s in scores):6.2f} {beyond:3} '
                 f'{max(s.step for s in scores):6.1f} {max(s.worse for s in scores):6.2f}')
    return line


def print_table(results: Iterable[Result]) -> dict[str, list[Score]]:
    """Print the table by class and by kind of drive; return our scores by class."""
    cells: dict[tuple[str, str], list[Score]] = {}
    for kind, style, estimator, score in results:
        for name in (kind, f'{kind}: {style}'):
            cells.setdefault((name, estimator), []).append(score)
    print(f'{"":51}  deg a turn    % of path\n'
          f'{"robots":28} {"by":18}   n    mean   95th   mean   95th    NEES  >4   step  worse')
    for (name, estimator), scores in sorted(cells.items()):
        print(show(name, estimator, scores))
    return {name: scores for (name, by), scores in cells.items() if by == 'ours'}


def figures(kind: str, scores: list[Score]) -> list[Figure]:
    """Return a class as figures; less is better."""
    target, made = TARGETS[kind], []
    for unit, values, (most, most_95) in (
            ('deg a turn', [s.turn for s in scores], target.turn),
            ('% of the path', [s.place for s in scores], target.place)):
        made.append(Figure(f'{kind}: {unit}', mean(values), unit, most,
                           worst=percentile(values), beside=f'95th allowed {most_95:g}'))
    return made


def old(job: tuple[Condition, int]) -> list[Result]:
    """Follow a drive of the old conditions under every rounding."""
    condition, seed = job
    instants = simulate(seed, condition)
    found = []
    for rounding in Rounding:
        score = follow(instants, rounding, 1.0, condition)
        found.append((condition.name, rounding.value, 'ours',
                      Score(score.turn, score.distance, score.nees)))
    return found


def _drive(job: tuple[str, str, int]) -> list[Result]:
    return drive(*job)


def main() -> None:
    """Print the tables; keep the figures that have targets."""
    parser = ArgumentParser()
    parser.add_argument('--drives', type=int, default=DRIVES_EACH, help='of each class')
    parser.add_argument('--seed', type=int, default=HELD_OUT, help='the first')
    parser.add_argument('--processes', type=int, default=None)
    parser.add_argument('--no-old', action='store_true', help='leave out the old conditions')
    options = parser.parse_args()
    where = machine()
    styles = list(DRIVES)
    jobs = [(kind, styles[i % len(styles)], options.seed + i)
            for i in range(options.drives) for kind in TARGETS]
    with Pool(options.processes) as pool:
        results = [each for some in pool.imap_unordered(_drive, jobs) for each in some]
        ours = print_table(results)
        if not options.no_old:
            old_jobs = [(c, seed) for c in CONDITIONS for seed in range(OLD_DRIVES)]
            print_table([each for some in pool.imap_unordered(old, old_jobs) for each in some])
    if options.drives == DRIVES_EACH and options.seed == HELD_OUT:
        keep('bench_odometry', [each for kind in TARGETS for each in figures(kind, ours[kind])],
             where)


if __name__ == '__main__':
    main()
