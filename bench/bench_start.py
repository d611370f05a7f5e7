# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Start-up time of the node: `python bench/bench_start.py`, 30 seconds, a table.

Measured from the start of the process to its first `odom` in a listener that runs already; for
comparison the same of the floor (programs/floor.py).
"""

from time import monotonic, sleep

from results import Figure, repeated, run
from scene import scene

REPETITIONS = 5


def first_odom(*, floor: bool) -> float:
    """Return the time from the start of a process to its first `odom`, seconds."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener('odom')
        sleep(1)
        begun = monotonic()
        stage.driver(floor=floor)
        listener.line()
        return float(listener.result()['odom'][0][0]) - begun


def measure() -> list[Figure]:
    """Return the figures."""
    floor, node = zip(*((first_odom(floor=True), first_odom(floor=False))
                        for _ in range(REPETITIONS)))
    return [repeated('process start to first odom', node, 's', 1.5),
            repeated('floor: process start to first odom', floor, 's')]


if __name__ == '__main__':
    run('bench_start', measure)
