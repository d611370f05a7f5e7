# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Processor time and memory of the node: `python bench/bench_cost.py`, 25 minutes, a table.

The node runs with its dead-man process at 66.7 frames a second, with one subscriber on each topic
in another process. Its processor time, as a share of one core, is measured standing, and in the
first 20 s of driving in a circle with `cmd_vel` ten times a second. Memory is resident memory.

The floor (programs/floor.py) imports the same message packages and publishes one Odometry for each
frame to one subscriber. The variants are the floor with one change (programs/variant.py). Node,
floor and variants take turns.

The rows of `create_driver`, the C++ driver of the package create_robot, are remembered: it cannot
be run here. It was measured once beside the node, with the same simulated robot and commands.
"""

from collections.abc import Sequence
from statistics import median
from time import sleep
from typing import Any, NamedTuple

from create_oi_ros.ros.topics import PUBLISHED
from processes import family, processor_shares, resident
from results import Figure, repeated, run
from scene import scene

REPETITIONS = 5
# Seconds to wait before a measurement, and its duration.
SETTLE, WATCH = 1.5, 4.0
DRIVE = 20.0
"""The same for a robot that drives: a new robot costs more, until its odometry knows it."""
STANDING, DRIVING, TEN_HERTZ = 1.4, 1.6, 0.84
"""Targets, as multiples of the floor."""
THINNED = {
    'odom_rate 20': {'odom_rate': 20.0}, 'odom_rate 10': {'odom_rate': 10.0},
    'odom_rate and sensor_rate 10': {'odom_rate': 10.0, 'sensor_rate': 10.0}}
"""What is sent less often, as the C++ driver does at its default of 10 Hz."""
THEIR_FLOOR = 4.3
"""The floor when the C++ driver was measured, % of a core."""
THEIRS = {
    'driving, 66.7 Hz': 7.4, 'driving, 66.7 Hz, only odom heard': 6.0,
    'driving, 10 Hz': 2.4, 'driving, 10 Hz, only odom heard': 2.1}
ALL = tuple(topic.name for topic in PUBLISHED)
VARIANTS = {
    'messages': 'floor that publishes all that the node does, nothing filled',
    'bytes': 'the same, serialized beforehand',
    'timer': 'floor, looking every 15 ms, no thread that waits',
    'events': 'floor on the events executor'}
MESSAGES = (
    'builtin_interfaces.msg', 'create_oi_msgs.msg', 'create_oi_msgs.srv', 'diagnostic_msgs.msg',
    'geometry_msgs.msg', 'nav_msgs.msg', 'rcl_interfaces.msg', 'sensor_msgs.msg',
    'std_msgs.msg', 'std_srvs.srv', 'tf2_msgs.msg')


class Node(NamedTuple):
    """What a node takes, with its dead-man: shares of a core in %, memory in MB."""

    standing: float
    driving: float
    memory: float
    """Of the node alone."""
    dead_man: float


def floor() -> tuple[float, float]:
    """Return the processor share and memory of the floor."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener('odom')
        driver = stage.driver(floor=True, imports=MESSAGES)
        listener.line()
        sleep(SETTLE)
        share, = processor_shares([driver.pid], WATCH)
        return share, resident(driver.pid)


def variant(which: str) -> float:
    """Return the processor share of a variant."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener(*(ALL if which in ('messages', 'bytes') else ['odom']))
        driver = stage.variant(which)
        listener.line()
        sleep(SETTLE)
        share, = processor_shares([driver.pid], WATCH)
        return share


def node(*topics: str, **options: Any) -> Node:
    """Return what the node takes with these topics heard; options are those of `Scene.driver`."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener(*topics)
        driver = stage.driver(**options)
        listener.line()
        sleep(SETTLE)
        standing, = processor_shares([driver.pid], WATCH)
        stage.program('circle')
        sleep(SETTLE)
        driving, = processor_shares([driver.pid], DRIVE)
        return Node(standing, driving, resident(driver.pid),
                    sum(resident(child) for child in family(driver.pid)[1:]))


def waiting() -> float:
    """Return what a coroutine that waits costs on the events executor."""
    with scene() as stage:
        program = stage.program('waiting')
        program.line()
        share, = processor_shares([program.pid], 1.0)
        return share


def measure() -> list[Figure]:
    """Run all in turn; return the figures."""
    least, most, thinned = [], [], {name: [] for name in THINNED}
    heard: list[Node] = []
    events: list[Node] = []
    others: dict[str, list[float]] = {which: [] for which in VARIANTS}
    for _ in range(REPETITIONS):
        least.append(floor())
        others['messages'].append(variant('messages'))
        most.append(node(*ALL))
        heard.append(node('odom'))
        for name, rates in THINNED.items():
            thinned[name].append(node(*ALL, **rates))
        events.append(node(*ALL, events=True))
        for which in ('bytes', 'timer', 'events'):
            others[which].append(variant(which))
    shares, memory = zip(*least)
    return [
        repeated('floor: processor', shares, '% of a core'),
        *loads('node', most, shares, STANDING, DRIVING),
        *loads('node, only odom heard', heard, shares),
        *remembered(),
        *(figure for name, nodes in thinned.items() for figure in loads(
            f'node, {name}', nodes, shares,
            driving=TEN_HERTZ if THINNED[name]['odom_rate'] == 10 else None)),
        *loads('node on the events executor', events, shares),
        *(compared(f'{name}: processor', others[which], shares)
          for which, name in VARIANTS.items()),
        repeated('events executor, a coroutine that waits: processor', [waiting()],
                 '% of a core'),
        repeated('node, standing, beside the floor that publishes all: processor',
                 [each.standing / b for each, b in zip(most, others['messages'])], 'x'),
        repeated('floor: memory', memory, 'MB'),
        repeated('node: memory', [each.memory for each in most], 'MB'),
        repeated('node: memory over the floor',
                 [each.memory - b for each, b in zip(most, memory)], 'MB', 8),
        repeated('dead-man: memory', [each.dead_man for each in most], 'MB', 6,
                 'most of it is shared with the node: Python itself'),
    ]


def loads(name: str, nodes: Sequence[Node], floors: Sequence[float],
          standing: float | None = None, driving: float | None = None) -> list[Figure]:
    """Return the ratios to the floor of a node that stands, and drives."""
    return [
        compared(f'{name}, standing: processor', [n.standing for n in nodes], floors, standing),
        compared(f'{name}, driving: processor', [n.driving for n in nodes], floors, driving)]


def remembered() -> list[Figure]:
    """Return the figures of the C++ driver, each with its ratio to the floor of that machine."""
    return [
        Figure(f'create_driver in C++ (remembered), {name}: processor', share / THEIR_FLOOR,
               'x floor', beside=f'{share} % of a core')
        for name, share in THEIRS.items()]


def compared(what: str, shares: Sequence[float], floors: Sequence[float],
             target: float | None = None) -> Figure:
    """Return the ratio to the floor of the same repetition."""
    return repeated(what, [a / b for a, b in zip(shares, floors)], 'x floor', target,
                    f'{median(shares):.1f} % of a core')


if __name__ == '__main__':
    run('bench_cost', measure)
