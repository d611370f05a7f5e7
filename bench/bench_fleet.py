"""
How many robots a machine carries: `python bench/bench_fleet.py`, two minutes, a table.

One to 32 simulated robots with their nodes, a process each, and one listener to all odometry.
A frame is lost where no `odom` came for it. The machine is full when all its cores are busy;
what lies beyond is shown, not judged. The last row has several drivers in one process.
"""

import os
from time import monotonic, sleep
from typing import NamedTuple

from create_oi_ros.oi import SLOT
from create_oi_ros.ros.programs import PROGRAMS
from processes import machine_seconds, processor_shares
from results import Figure, run
from scene import Actor, Scene, scene

SIZES = (1, 2, 4, 8, 16, 32)
TOGETHER = 4
FLAT = 1.2
"""Most that a robot may cost in a fleet, as a multiple of one alone."""
LATEST, SETTLE, WATCH = 25.0, 3.0, 5.0
"""Seconds until all drive at the latest, until all is quiet, and of counting."""


class Seen(NamedTuple):
    """A fleet."""

    size: int
    node: float
    """Processor share of a node, % of a core."""
    robot: float
    came: float
    """Of the frames that there should have been, %."""
    busy: float
    """Of all cores, %, whoever keeps them busy."""


def robots(stage: Scene, size: int) -> list[Actor]:
    """Switch robots on."""
    fleet = [stage.start('-c', PROGRAMS['create_sim'], '--link', f'{stage.port}{number}')
             for number in range(1, size + 1)]
    for each in fleet:
        each.line()
    return fleet


def nodes(stage: Scene, size: int, *, together: bool) -> list[Actor]:
    """Start their drivers."""
    ports = [f'{stage.port}{number}' for number in range(1, size + 1)]
    if together:
        return [stage.program('together', *ports)]
    return [stage.start('-c', PROGRAMS['create_node'], '--ros-args', '-p', f'port:={port}',
                        '-r', f'__ns:=/robot{number}') for number, port in enumerate(ports, 1)]


def watched(size: int, *, together: bool = False) -> Seen:
    """Watch a fleet for a while."""
    with scene() as stage:
        fleet = robots(stage, size)
        listener = stage.listener(*(f'/robot{number}/odom' for number in range(1, size + 1)))
        drivers = nodes(stage, size, together=together)
        sleep(min(LATEST, SETTLE + size))
        begun, busy = monotonic(), machine_seconds()
        shares = processor_shares([each.pid for each in drivers + fleet], WATCH)
        passed, busy = monotonic() - begun, machine_seconds() - busy
        for each in drivers + fleet:
            each.process.kill()  # on a full machine a farewell of each takes minutes
        heard = listener.told()
    came = sum(begun < when < begun + passed for times in heard.values() for when, _ in times)
    split = len(drivers)
    return Seen(
        size, sum(shares[:split]) / size, sum(shares[split:]) / size,
        100 * came / (size * passed / SLOT), 100 * busy / passed / (os.cpu_count() or 1))


def described(seen: Seen, alone: Seen) -> list[Figure]:
    """Say how a fleet did; a full machine is only told of."""
    full = seen.busy > 95
    name = f'{seen.size} robot{"s" * (seen.size > 1)}{", machine full" if full else ""}'
    beside = f'node {seen.node:.1f} %, robot {seen.robot:.1f} %, machine busy {seen.busy:.0f} %'
    return [
        Figure(f'{name}: node beside one alone', seen.node / alone.node, 'x',
               None if full else FLAT, beside=beside),
        Figure(f'{name}: frames that came', seen.came, '%', None if full else 99.5, True),
    ]


def measure() -> list[Figure]:
    """Measure everything."""
    seen = [watched(size) for size in SIZES]
    shared = watched(TOGETHER, together=True)
    apart = next(each for each in seen if each.size == TOGETHER)
    return [
        *(figure for each in seen for figure in described(each, seen[0])),
        Figure(f'{TOGETHER} drivers in one process beside {TOGETHER} processes',
               shared.node / apart.node, 'x',
               beside=f'{shared.node:.1f} % a driver, {shared.came:.1f} % of the frames came'),
    ]


if __name__ == '__main__':
    run('bench_fleet', measure)
