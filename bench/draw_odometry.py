"""Draw docs/odometry.png: `python bench/draw_odometry.py [PATH]`, two minutes of mixed driving."""

from pathlib import Path
import sys

import matplotlib

from create_oi_ros.odometry import Estimate
from create_oi_ros.sim.body.encoders import Rounding
from odometry_rig import Condition, follow, simulate

matplotlib.use('Agg')

from matplotlib import pyplot

DRIVE = Condition('picture', latency=0.03, seconds=120.0)
SEED = 8
INK = {'naive': '#d1495b', 'ours': '#00798c'}


def main() -> None:
    """Draw the true track, the naive one and ours, for each rounding."""
    instants = simulate(SEED, DRIVE)
    figure, every = pyplot.subplots(1, 3, figsize=(12, 4.6), layout='constrained')
    for axes, rounding in zip(every, Rounding):
        for name, window in (('naive', 0.0), ('ours', 1.0)):
            track: list[Estimate] = []
            score = follow(instants, rounding, window, DRIVE, track.append)
            axes.plot([e.x for e in track], [e.y for e in track], color=INK[name], linewidth=1.6,
                      label=f'{name}: {score.turn:.2f}° a turn, {score.distance:.1f} %')
        axes.plot([i.x for i in instants], [i.y for i in instants], color='black',
                  linewidth=0.9, linestyle=(0, (4, 3)), label='truth')
        axes.set_title(f'a robot that {WORDS[rounding]}', fontsize=11)
        axes.set_aspect('equal', adjustable='datalim')
        axes.grid(alpha=0.25)
        axes.set_xlabel('x, m')
        axes.legend(fontsize=8, loc='best')
    every[0].set_ylabel('y, m')
    path = Path(sys.argv[1] if len(sys.argv) > 1 else 'docs/odometry.png')
    figure.savefig(path, dpi=110, metadata={'Software': None})


WORDS = {Rounding.TRUNCATE: 'truncates', Rounding.ROUND: 'rounds', Rounding.CARRY: 'carries'}

if __name__ == '__main__':
    main()
