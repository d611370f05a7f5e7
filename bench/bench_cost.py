"""
What the node costs: `python bench/bench_cost.py`, two minutes, a table.

Processor time as a share of one core, of the node with its dead-man, at 66.7 frames a second,
one subscriber on each topic, which is another process; standing, and driving in a circle with
`cmd_vel` ten times a second. Memory is what is resident then. The floor (programs/floor.py) has
imported the same message packages, and publishes one Odometry a frame to one subscriber.
"""

from time import sleep

from processes import processor_shares, resident
from results import Figure, repeated, run
from scene import scene

from create_oi_ros.topics import PUBLISHED

REPETITIONS = 3
SETTLE, WATCH = 4.0, 8.0
"""Seconds before, and while the processor time is counted."""
MESSAGES = (
    'builtin_interfaces.msg', 'create_oi_msgs.msg', 'create_oi_msgs.srv', 'diagnostic_msgs.msg',
    'geometry_msgs.msg', 'nav_msgs.msg', 'rcl_interfaces.msg', 'sensor_msgs.msg',
    'std_msgs.msg', 'std_srvs.srv', 'tf2_msgs.msg')


def floor() -> tuple[float, float]:
    """Return the processor share and memory of the floor."""
    with scene() as stage:
        stage.robot()
        stage.listener('odom')
        driver = stage.driver(floor=True, imports=MESSAGES)
        sleep(SETTLE)
        share, = processor_shares([driver.pid], WATCH)
        return share, resident(driver.pid)


def node() -> tuple[float, float, float]:
    """Return the processor share of the node standing and driving, and its memory."""
    with scene() as stage:
        stage.robot()
        stage.listener(*(topic.name for topic in PUBLISHED))
        driver = stage.driver()
        sleep(SETTLE)
        standing, = processor_shares([driver.pid], WATCH)
        stage.program('circle')
        sleep(SETTLE)
        driving, = processor_shares([driver.pid], WATCH)
        return standing, driving, resident(driver.pid)


def measure() -> list[Figure]:
    """Measure everything."""
    least, most = [], []
    for _ in range(REPETITIONS):
        least.append(floor())
        most.append(node())
    shares, memory = zip(*least)
    standing, driving, ours = zip(*most)
    return [
        repeated('floor: processor', shares, '% of a core'),
        repeated('node, standing: processor', standing, '% of a core', 4.4),
        repeated('node, standing: processor', [a / b for a, b in zip(standing, shares)],
                 'x floor', 2.0),
        repeated('node, driving: processor', driving, '% of a core', 4.4),
        repeated('node, driving: processor', [a / b for a, b in zip(driving, shares)],
                 'x floor', 2.0),
        repeated('floor: memory', memory, 'MB'),
        repeated('node: memory', ours, 'MB'),
        repeated('node: memory over the floor', [a - b for a, b in zip(ours, memory)], 'MB', 15),
    ]


if __name__ == '__main__':
    run('bench_cost', measure)
