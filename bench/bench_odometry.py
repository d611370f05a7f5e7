"""
How good the odometry is: `python bench/bench_odometry.py`, two minutes, a table.

Mixed drives of five minutes (arcs, turns in place, lines, stops, reversals; 10 to 500 mm/s, 2 to
200 degrees a second), the estimator told neither rounding nor acceleration, which is 0.5 to
2 m/s². Mean and worst of ten drives:

  turn   |yaw error| at the end, degrees, for each 360 degrees of true rotation either way
  path   distance from estimated to true place at the end, per cent of the true path's length
  NEES   normalised estimation error squared of (x, y, yaw) at the end; 3 is calibrated
  step   largest step from frame to frame beyond what the wheels can do in that time

The last condition is the whole driver against the whole simulated robot, byte by byte.
"""

from collections.abc import Iterable
from multiprocessing import Pool
from typing import NamedTuple

from create_oi_ros.sim.body.encoders import Rounding
from odometry_loop import travel
from odometry_rig import Condition, CONDITIONS, follow, Score, simulate
from results import Figure, keep, machine

DRIVES = 10
MORE_DRIVES = 37
"""Further drives in the condition CALIBRATED, for the NEES."""
CALIBRATED = 2
WINDOWS = {'naive': 0.0, 'ours': 1.0}
LOOP = Condition('whole driver', latency=0.03, any_moment=True, target=True, seconds=300)
LOOP_DRIVES = 4
MEANS = {'turn': 0.3, 'distance': 1.0}
WORSTS = {'turn': 0.8, 'distance': 2.5, 'step': 1.0, 'step_angle': 0.2}
CARRY_TURN = 0.1


class Job(NamedTuple):
    """One drive, to be followed by every estimator under every rounding."""

    condition: Condition
    seed: int


Result = tuple[str, str, str, Score]
"""Condition, rounding, estimator and how well it did."""


def run(job: Job) -> list[Result]:
    """Simulate a drive and follow it."""
    condition, seed = job
    if condition == LOOP:
        return [(condition.name, rounding.value, 'ours', travel(
                    seed, rounding, condition.latency, WINDOWS['ours'], condition.seconds))
                for rounding in Rounding]
    instants = simulate(seed, condition)
    return [(condition.name, rounding.value, name,
             follow(instants, rounding, window, condition))
            for rounding in Rounding for name, window in WINDOWS.items()
            if name == 'ours' or seed < DRIVES]


def jobs() -> list[Job]:
    """Return all drives, the longest first."""
    return [*(Job(LOOP, seed) for seed in range(LOOP_DRIVES)),
            *(Job(condition, seed) for condition in CONDITIONS for seed in range(DRIVES)),
            *(Job(CONDITIONS[CALIBRATED], DRIVES + seed) for seed in range(MORE_DRIVES))]


class Row(NamedTuple):
    """Figures of one cell of the table."""

    condition: str
    rounding: str
    estimator: str
    drives: int
    mean: Score
    worst: Score
    misses: list[str]
    """Targets that are not held; empty also where there are none."""
    has_targets: bool


def rows(results: Iterable[Result]) -> list[Row]:
    """Gather what belongs together."""
    cells: dict[tuple[str, str, str], list[Score]] = {}
    for condition, rounding, estimator, score in results:
        cells.setdefault((condition, rounding, estimator), []).append(score)
    targets = {each.name for each in (*CONDITIONS, LOOP) if each.target}
    table = []
    for (condition, rounding, estimator), scores in cells.items():
        mean = Score(*(sum(column) / len(scores) for column in zip(*scores)))
        worst = Score(*map(max, zip(*scores)))
        aims = condition in targets and estimator == 'ours'
        table.append(Row(condition, rounding, estimator, len(scores), mean, worst,
                         missed(rounding, mean, worst) if aims else [], aims))
    order = [each.name for each in (*CONDITIONS, LOOP)]
    return sorted(table, key=lambda row: (order.index(row.condition), row.rounding, row.estimator))


def missed(rounding: str, mean: Score, worst: Score) -> list[str]:
    """Return the names of the targets that are missed."""
    means = MEANS | ({'turn': CARRY_TURN} if rounding == 'carry' else {})
    return [*(f'mean {name}' for name, most in means.items() if getattr(mean, name) > most),
            *(f'worst {name}' for name, most in WORSTS.items() if getattr(worst, name) > most)]


def show(row: Row) -> str:
    """Return a line of the table."""
    mean, worst = row.mean, row.worst
    verdict = ('missed: ' + ', '.join(row.misses)) if row.misses else (
        'met' if row.has_targets else '-')
    return (f'{row.condition:16} {row.rounding:9} {row.estimator:6} {row.drives:3} '
            f'{mean.turn:8.3f} {worst.turn:8.3f} {mean.distance:7.2f} {worst.distance:7.2f} '
            f'{mean.nees:9.2f} {worst.step:5.2f} {worst.step_angle:6.3f}  {verdict}')


def figures(row: Row) -> list[Figure]:
    """Return a row with targets as figures; less is better."""
    means = MEANS | ({'turn': CARRY_TURN} if row.rounding == 'carry' else {})
    units = {'turn': 'deg a turn', 'distance': '% of the path'}
    return [Figure(f'{row.condition}, {row.rounding}: {unit}', getattr(row.mean, name), unit,
                   means[name], worst=getattr(row.worst, name),
                   beside=f'worst allowed {WORSTS[name]:g}')
            for name, unit in units.items()]


def main() -> None:
    """Print the table; keep the rows that have targets."""
    where = machine()
    with Pool() as pool:
        results = [result for some in pool.imap_unordered(run, jobs()) for result in some]
    table = rows(results)
    print('                                        deg per turn      % of path          '
          '      largest step\n'
          'condition        rounding  by     n     mean    worst    mean   worst      '
          'NEES    mm    deg  targets')
    for row in table:
        print(show(row))
    targets = {each.name for each in CONDITIONS if each.target}
    calibration = [score.nees for condition, _, estimator, score in results
                   if condition in targets and estimator == 'ours']
    average = sum(calibration) / len(calibration)
    print(f'NEES over {len(calibration)} mixed drives: {average:.2f}; target 1.5 to 6: '
          + ('met' if 1.5 <= average <= 6 else 'missed'))
    keep('bench_odometry', [
        *(figure for row in table if row.has_targets for figure in figures(row)),
        Figure(f'NEES over {len(calibration)} mixed drives, at most', average, '', 6),
        Figure(f'NEES over {len(calibration)} mixed drives, at least', average, '', 1.5, True),
    ], where)


if __name__ == '__main__':
    main()
