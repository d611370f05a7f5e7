# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Draw docs/lidar.png: `python bench/draw_lidar.py`, what a lap's scans draw."""

import matplotlib

from create_oi_ros.robot import BODY_RADIUS
from create_oi_ros.sim.world import shipped
from lap import lap

matplotlib.use('Agg')

from matplotlib import pyplot

WIDTH, HEIGHT, MARGIN = 8, 6, 0.12
"""Metres of the apartment and around it; a metre is an inch."""
PAPER, MET, TRACK, ROBOT = '#fbfaf7', '#d1495b', '#00798c', '#30343f'


def main() -> None:
    """Draw the ends of all beams, the track of the odometry, and the robot at its end."""
    scans = list(lap(shipped('apartment')))
    figure = pyplot.figure(figsize=(WIDTH + 2 * MARGIN, HEIGHT + 2 * MARGIN), facecolor=PAPER)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(-MARGIN, WIDTH + MARGIN),
                           ylim=(-MARGIN, HEIGHT + MARGIN))
    axes.axis('off')
    for scan in scans:
        axes.plot(scan.x, scan.y, ',', color=MET)
    axes.plot(*zip(*(scan.robot[:2] for scan in scans)), color=TRACK)
    axes.add_patch(pyplot.Circle(scans[-1].robot[:2], BODY_RADIUS, fill=False, color=ROBOT))
    figure.savefig('docs/lidar.png', dpi=100, metadata={'Software': None})


if __name__ == '__main__':
    main()
