# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Draw docs/odometry.png: `python bench/draw_odometry.py`, two minutes of mixed driving."""

from dataclasses import replace
from random import Random

import matplotlib

from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY, EncoderSign
from create_oi_ros.sim.body.wheels import Response, TimeConstant
from drives import mixed
from odometry_loop import Journey
from rivals import Rival
from robots import Robot

matplotlib.use('Agg')

from matplotlib import pyplot

SECONDS, SEED, LATENCY = 120.0, 8, 0.005
ROBOTS = {
    'the centre of what was measured': Robot(DEFAULT_BODY, Rounding.TRUNCATE, 0.015),
    'as a Create 2, rounds': Robot(replace(
        DEFAULT_BODY, response=Response.SECOND_ORDER, overshoot=0.2,
        time_constant=TimeConstant(0.05), right_speed_gain=1.04, left_speed_gain=0.99),
        Rounding.ROUND, 0.015625),
    'constant acceleration, true signs, carries': Robot(replace(
        DEFAULT_BODY, response=Response.RAMP, encoder_sign=EncoderSign.TRUE,
        wheel_acceleration=0.8, dead_time=0.1), Rounding.CARRY, 0.015),
}
"""Three simulated robots, by name; frames come every so many seconds."""
INK = {'each frame read': '#d1495b', 'a reading a second': '#e09f3e', 'this odometry': '#00798c'}
Track = list[tuple[float, float]]


def tracks(robot: Robot) -> tuple[Track, dict[str, Track]]:
    """Drive a robot; return its true track, and what each odometry makes of it."""
    journey = Journey(robot, SEED, latency=LATENCY)
    journey.drive(list(mixed(Random(SEED), SECONDS)), SECONDS)
    found: dict[str, Track] = {}
    for name, interval in (('each frame read', 0.0), ('a reading a second', 1.0)):
        rival, found[name] = Rival(robot, interval), []
        for counts in journey.counts:
            rival.frame(counts)
            found[name].append((rival.x, rival.y))
    found['this odometry'] = [(e.x, e.y) for _, e, _ in journey.moves]
    return [(truth.pose.x, truth.pose.y) for _, _, truth in journey.moves], found


def main() -> None:
    """Draw the true track of each robot and the estimated ones."""
    figure, every = pyplot.subplots(1, 3, figsize=(12, 4.6), layout='constrained')
    for axes, (name, robot) in zip(every, ROBOTS.items()):
        truth, found = tracks(robot)
        for estimator, track in found.items():
            axes.plot(*zip(*track), color=INK[estimator], linewidth=1.6, label=estimator)
        axes.plot(*zip(*truth), color='black', linewidth=0.9, linestyle=(0, (4, 3)),
                  label='truth')
        axes.set_title(name, fontsize=11)
        axes.set_aspect('equal', adjustable='datalim')
        axes.grid(alpha=0.25)
        axes.set_xlabel('x, m')
    every[0].set_ylabel('y, m')
    every[0].legend(fontsize=8, loc='best')
    figure.savefig('docs/odometry.png', dpi=110, metadata={'Software': None})


if __name__ == '__main__':
    main()
