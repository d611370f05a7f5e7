# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Errors of the time stamps: `python bench/bench_clock.py`, ten seconds, a table.

A driver and a robot in memory. The line delays each frame by a random 0 to 5 ms and keeps their
order. The robot's clock is fast or slow by as much as a quartz may be. The true time of a frame
is the end of the slot in which the robot made it.
"""

from math import sqrt
from random import Random

from create_oi_ros.driver import Driver, Moved, Settings
from create_oi_ros.oi import BITS_PER_BYTE, SLOT
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import shipped
from results import Figure, run

DELAY = 0.005
"""Longest delay of a frame, seconds."""
# Seconds that the driver's clock has to settle, and duration of the measurement.
LEARN, WATCH = 20.0, 40.0
DRIFTS = (0.0, 1e-4, -1e-4)
"""How fast the robot's clock is: 1e-4 gains 100 microseconds a second."""


def errors(drift: float, seed: int) -> tuple[list[float], float]:
    """Return the error of each stamp and the shortest step between two, seconds."""
    driver = Driver(Settings())
    robot = Create(Body(shipped('empty')), guesses=Guesses(boot_seconds=0.0))
    random, now = Random(seed), 0.0
    driver.connected(now)
    wrong, stamps = [], []
    for slot in range(1, round((LEARN + WATCH) / SLOT)):
        robot.receive(driver.data_to_send(), (slot - 1) * SLOT, driver.baud)
        robot.poll(slot * SLOT)
        left = slot * SLOT / (1 + drift)
        data = robot.data_to_send()
        wire = BITS_PER_BYTE * len(data) / driver.baud
        now = max(now, left + wire + random.uniform(0, DELAY))
        driver.receive(data, now)
        driver.poll(now)
        while (event := driver.next_event()) is not None:
            if isinstance(event, Moved) and left > LEARN:
                wrong.append(event.stamp - left)
                stamps.append(event.stamp)
    return wrong, min(b - a for a, b in zip(stamps, stamps[1:]))


def measure() -> list[Figure]:
    """Return the figures for each drift."""
    figures = []
    for drift in DRIFTS:
        runs = [errors(drift, seed) for seed in range(3)]
        name = f"5 ms of random delay, robot's clock {1e6 * drift:+.0f} ppm"
        spreads = [1e3 * sqrt(sum(e * e for e in wrong) / len(wrong)) for wrong, _ in runs]
        figures.append(Figure(f'{name}: stamps off the truth, root mean square',
                              sorted(spreads)[1], 'ms', 1.0, worst=max(spreads)))
        figures.append(Figure(f'{name}: least step between two stamps',
                              1e3 * min(step for _, step in runs), 'ms', 0.0, True))
    return figures


if __name__ == '__main__':
    run('bench_clock', measure)
