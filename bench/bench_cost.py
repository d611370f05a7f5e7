"""
Processor time and memory of the node: `python bench/bench_cost.py`, three minutes, a table.

The node runs with its dead-man process at 66.7 frames a second, with one subscriber on each topic
in another process. Its processor time, as a share of one core, is measured standing, and driving
in a circle with `cmd_vel` ten times a second. Memory is resident memory.

The floor (programs/floor.py) imports the same message packages and publishes one Odometry for each
frame to one subscriber. The variants are the floor with one change (programs/variant.py). Node,
floor and variants take turns.
"""

from collections.abc import Sequence
from statistics import median
from time import sleep

from create_oi_ros.ros.topics import PUBLISHED
from processes import processor_shares, resident
from results import Figure, repeated, run
from scene import scene

REPETITIONS = 3
# Seconds to wait before a measurement, and its duration.
SETTLE, WATCH = 1.5, 4.0
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


def node() -> tuple[float, float, float]:
    """Return the node's processor share standing and driving, and its memory."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener(*ALL)
        driver = stage.driver()
        listener.line()
        sleep(SETTLE)
        standing, = processor_shares([driver.pid], WATCH)
        stage.program('circle')
        sleep(2 * SETTLE)
        driving, = processor_shares([driver.pid], WATCH)
        return standing, driving, resident(driver.pid)


def measure() -> list[Figure]:
    """Run all in turn; return the figures."""
    least, most = [], []
    others: dict[str, list[float]] = {which: [] for which in VARIANTS}
    for _ in range(REPETITIONS):
        least.append(floor())
        others['messages'].append(variant('messages'))
        most.append(node())
        for which in ('bytes', 'timer', 'events'):
            others[which].append(variant(which))
    shares, memory = zip(*least)
    standing, driving, ours = zip(*most)
    return [
        repeated('floor: processor', shares, '% of a core'),
        repeated('node, standing: processor', standing, '% of a core', 4.4),
        compared('node, standing: processor', standing, shares, 2.0),
        repeated('node, driving: processor', driving, '% of a core', 4.4),
        compared('node, driving: processor', driving, shares, 2.0),
        *(compared(f'{name}: processor', others[which], shares)
          for which, name in VARIANTS.items()),
        repeated('node, standing, beside the floor that publishes all: processor',
                 [a / b for a, b in zip(standing, others['messages'])], 'x'),
        repeated('floor: memory', memory, 'MB'),
        repeated('node: memory', ours, 'MB'),
        repeated('node: memory over the floor', [a - b for a, b in zip(ours, memory)], 'MB', 15),
    ]


def compared(what: str, shares: Sequence[float], floors: Sequence[float],
             target: float | None = None) -> Figure:
    """Return the ratio to the floor of the same repetition."""
    return repeated(what, [a / b for a, b in zip(shares, floors)], 'x floor', target,
                    f'{median(shares):.1f} % of a core')


if __name__ == '__main__':
    run('bench_cost', measure)
