# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How many robots one machine can run: `python bench/bench_fleet.py`, two minutes, a table.

One to 32 simulated robots and their nodes, each a process, and one listener to all odometry. A
frame without an `odom` counts as lost. When all cores are busy, the machine is full: rows beyond
that have no target. In the last rows `create_fleet` has all drivers in one process.
"""

import os
from time import monotonic, sleep
from typing import NamedTuple

from create_oi_ros.oi import SLOT
from create_oi_ros.ros.programs import PROGRAMS
from processes import machine_seconds, processor_shares, resident
from results import Figure, run
from scene import Process, Scene, scene

SIZES = (1, 2, 4, 8, 16, 32)
TOGETHER = (4, 8, 16)
FLAT = 1.2
"""Target: the cost of a node in a fleet, as a multiple of the cost of one alone."""
# Seconds: longest wait for all nodes to start, wait for one node, duration of a measurement.
LATEST, SETTLE, WATCH = 25.0, 3.0, 5.0


class Fleet(NamedTuple):
    """What was measured with a number of robots."""

    size: int
    node: float
    """Processor share of a node, % of a core."""
    robot: float
    """Processor share of a simulated robot, % of a core."""
    arrived: float
    """Frames that arrived, % of those expected."""
    busy: float
    """Load of the whole machine by all its processes, % of all cores."""
    memory: float
    """Resident memory of a driver without its dead-man, MB."""


def robots(stage: Scene, size: int) -> list[Process]:
    """Start simulated robots; wait until they run."""
    fleet = [stage.start('-c', PROGRAMS['create_sim'], '--link', f'{stage.port}{number}')
             for number in range(1, size + 1)]
    for each in fleet:
        each.line()
    return fleet


def nodes(stage: Scene, size: int, *, together: bool) -> list[Process]:
    """Start the drivers of the robots."""
    ports = {f'robot{number}': f'{stage.port}{number}' for number in range(1, size + 1)}
    if together:
        return [stage.start('-c', PROGRAMS['create_fleet'],
                            *(f'{name}={port}' for name, port in ports.items()))]
    return [stage.start('-c', PROGRAMS['create_node'], '--ros-args', '-p', f'port:={port}',
                        '-r', f'__ns:=/{name}') for name, port in ports.items()]


def measured(size: int, *, together: bool = False) -> Fleet:
    """Run a fleet of this size; `together` puts all drivers into one process."""
    with scene() as stage:
        fleet = robots(stage, size)
        listener = stage.listener(*(f'/robot{number}/odom' for number in range(1, size + 1)))
        drivers = nodes(stage, size, together=together)
        sleep(min(LATEST, SETTLE + size))
        begun, busy = monotonic(), machine_seconds()
        shares = processor_shares([each.pid for each in drivers + fleet], WATCH)
        passed, busy = monotonic() - begun, machine_seconds() - busy
        memory = sum(resident(each.pid) for each in drivers) / size
        for each in drivers + fleet:
            each.process.kill()  # on a full machine a clean end of all takes minutes
        received = listener.result()
    arrived = sum(
        begun < when < begun + passed for times in received.values() for when, _ in times)
    split = len(drivers)
    return Fleet(
        size, sum(shares[:split]) / size, sum(shares[split:]) / size,
        100 * arrived / (size * passed / SLOT), 100 * busy / passed / (os.cpu_count() or 1),
        memory)


def figures(fleet: Fleet, alone: Fleet) -> list[Figure]:
    """Return the figures of a fleet; on a full machine they have no target."""
    full = fleet.busy > 95
    name = f'{fleet.size} robot{"s" * (fleet.size > 1)}{", machine full" if full else ""}'
    beside = f'node {fleet.node:.1f} %, robot {fleet.robot:.1f} %, machine busy {fleet.busy:.0f} %'
    return [
        Figure(f'{name}: node beside one alone', fleet.node / alone.node, 'x',
               None if full else FLAT, beside=beside),
        Figure(f'{name}: frames that came', fleet.arrived, '%', None if full else 99.5, True),
    ]


def measure() -> list[Figure]:
    """Return the figures of all fleets."""
    fleets = [measured(size) for size in SIZES]
    apart = {fleet.size: fleet for fleet in fleets}
    return [
        *(figure for fleet in fleets for figure in figures(fleet, fleets[0])),
        *(figure for size in TOGETHER
          for figure in shared(measured(size, together=True), apart[size])),
    ]


def shared(fleet: Fleet, apart: Fleet) -> list[Figure]:
    """Return the figures of a fleet in one process."""
    name = f'{fleet.size} drivers in one process'
    return [
        Figure(f'{name}: processor, beside {fleet.size} processes', fleet.node / apart.node, 'x',
               beside=f'{fleet.node:.1f} % a driver'),
        Figure(f'{name}: frames that came', fleet.arrived, '%',
               beside=f'{apart.arrived:.1f} % with {fleet.size} processes'),
        Figure(f'{name}: memory of a driver', fleet.memory, 'MB',
               beside=f'{apart.memory:.0f} MB each with {fleet.size} processes')]


if __name__ == '__main__':
    run('bench_fleet', measure)
