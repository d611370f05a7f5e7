# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Processor time and memory of the node: `python bench/bench_cost.py`, ten minutes, a table.

The node runs with its dead-man process at 66.7 frames a second, with one subscriber on each topic,
or on `odom` alone, in another process. Its processor time, as a share of one core, is measured
standing, and in the first 20 s of driving in a circle with `cmd_vel` ten times a second. Memory is
resident memory. The floor (programs/floor.py) publishes one Odometry for each frame to one
subscriber. Node and floor take turns.

The targets are what `create_driver` takes, the C++ driver of the package create_robot, over the
same floor: it was measured once beside the node, with the same simulated robot and commands.
"""

from collections.abc import Sequence
from statistics import median
from time import sleep
from typing import NamedTuple

from create_oi_ros.ros.topics import PUBLISHED
from results import Figure, figures_of, load, repeated, run
from scene import scene

REPETITIONS = 5
# Seconds to wait before a measurement, and its duration.
SETTLE, WATCH = 1.5, 4.0
DRIVE = 20.0
"""The same for a robot that drives: a new robot costs more, until its odometry knows it."""
ALL = tuple(topic.name for topic in PUBLISHED)


class Node(NamedTuple):
    """What a node takes: shares of a core in %, with its dead-man; its own memory in MB."""

    standing: float
    driving: float
    memory: float


def floor() -> float:
    """Return the processor share of the floor, %."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener('odom')
        driver = stage.driver(floor=True)
        listener.line()
        sleep(SETTLE)
        return driver.processor_share(WATCH)


def node(*topics: str) -> Node:
    """Return what the node takes with these topics heard."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener(*topics)
        driver = stage.driver()
        listener.line()
        sleep(SETTLE)
        standing = driver.processor_share(WATCH)
        stage.program('circle')
        sleep(SETTLE)
        return Node(standing, driver.processor_share(DRIVE), driver.resident())


def measure() -> list[Figure]:
    floors, most, heard = zip(*((floor(), node(*ALL), node('odom')) for _ in range(REPETITIONS)))
    theirs = [figure.value for figure in figures_of(load(), 'create_driver')]
    return [
        repeated('floor: processor', floors, '% of a core'),
        compared('node, standing', [each.standing for each in most], floors),
        compared('node, driving', [each.driving for each in most], floors, theirs[0]),
        compared('node, only odom heard, driving', [each.driving for each in heard], floors,
                 theirs[1]),
        repeated('node: memory', [each.memory for each in most], 'MB')]


def compared(what: str, shares: Sequence[float], floors: Sequence[float],
             target: float | None = None) -> Figure:
    """Return the ratio to the floor of the same repetition."""
    return repeated(f'{what}: processor', [a / b for a, b in zip(shares, floors)], 'x floor',
                    target, f'{median(shares):.1f} % of a core')


if __name__ == '__main__':
    run('bench_cost', measure)
