# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Processor time and memory of the node, beside others: `python bench/bench_cost.py`, four minutes.

Floor (programs/floor.py) and node run at the same time, and with `--beside COMMAND` another
driver. Each has its own ROS domain, simulated robot (66.7 frames a second) and subscriber, and
drives in a circle by `cmd_vel`, 20 times a second. Processor times, each with that of its child
processes, are read over the same slices of ten seconds: whatever else runs slows all of them
alike, so only their ratios count. Memory is resident memory.
"""

from argparse import ArgumentParser
from collections.abc import Sequence
from contextlib import ExitStack
import shlex
from statistics import median
from time import monotonic, sleep

from results import Figure, repeated, run
from scene import DOMAIN, family, resident, Scene, shares

OTHER = 'the other driver'
SETTLE, SLICE, SLICES = 20.0, 10.0, 6
"""Seconds of driving before the first slice, of a slice, and how many of them."""
HEARD = {'odom alone': (('odom',), 1.2), 'all topics': ((), 1.1)}
"""Topics of the subscriber, none: all; and how much more than the other driver is allowed."""
MEMORY, DEAD_MAN_MEMORY = 98.0, 9.0
"""MB."""


def measured(heard: str, command: str) -> list[Figure]:
    """Let them run; return the figures with one choice of topics heard."""
    topics, allowed = HEARD[heard]
    with ExitStack() as stack:
        stages = [stack.enter_context(Scene(DOMAIN + n)) for n in range(3 if command else 2)]
        for stage in stages:
            stage.robot()
        drivers = [stages[0].driver(floor=True), stages[1].driver(), *(
            stage.start(*shlex.split(command.format(port=stage.port, domain=stage.domain)))
            for stage in stages[2:])]
        listeners = [stage.program('listener', *topics) for stage in stages]
        for stage in stages:
            stage.program('circle')
        sleep(SETTLE)
        begun = monotonic()
        floor, node, *other = zip(*(shares(SLICE, *drivers) for _ in range(SLICES)))
        ended = monotonic()
        _, (memory, *dead_man), *more = (
            [resident(each) for each in family(driver.process.pid)] for driver in drivers)
        _, rate, *other_rate = (
            sum(begun < when < ended for times in listener.result().values() for when, _ in times)
            / (ended - begun) for listener in listeners)
    made = [compared(f'{heard}: node', 'floor', node, floor, rate)]
    if other:
        made += [compared(f'{heard}: {OTHER}', 'floor', *other, floor, *other_rate),
                 compared(f'{heard}: node', OTHER, node, *other, rate, allowed)]
    if not topics:
        made += [Figure('memory: node', memory, 'MB', MEMORY),
                 *(Figure('memory: its dead-man', each, 'MB', DEAD_MAN_MEMORY)
                   for each in dead_man),
                 *(Figure(f'memory: {OTHER}', sum(each), 'MB') for each in more)]
    return made


def compared(what: str, name: str, shares: Sequence[float], others: Sequence[float],
             rate: float, target: float | None = None) -> Figure:
    """Return the ratio of two drivers in the same slices, and messages heard of the first."""
    return repeated(f'{what} to {name}', [a / b for a, b in zip(shares, others)], 'times', target,
                    f'{median(shares):.1f} to {median(others):.1f} %, {rate:.0f}/s')


if __name__ == '__main__':
    parser = ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--beside', metavar='COMMAND', default='', help=(
        'start another driver by this, with {port} and {domain} where its arguments name them'))
    command = parser.parse_args().beside
    run('bench_cost', lambda: [each for heard in HEARD for each in measured(heard, command)])
