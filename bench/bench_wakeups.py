# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What wakes the node, how often, and what that costs: `python bench/bench_wakeups.py`, a minute.

The node stands, then drives in a circle with ten commands a second, with one subscriber on each
topic in another process. The kernel counts how often each thread of node and dead-man went to
sleep by itself, and its processor time (proc(5): status, schedstat). The name of a thread tells
what woke it.
"""

from collections import Counter
from pathlib import Path
from time import monotonic, sleep
from typing import NamedTuple

from create_oi_ros.ros.topics import PUBLISHED
from processes import family
from results import Figure, run
from scene import scene

# Seconds to wait before a measurement, and its duration.
SETTLE, WATCH = 2.0, 10.0
MAIN = 'services, actions (thread of the executor)'
LAST = ('frames (thread that reads the port)', 'velocity commands (thread of their own)',
        'diagnostics (thread of their own)')
"""What wakes the threads that the node starts last, in their order."""
REST = 'the rest'
DEAD_MAN = 'dead-man: looks at the node'
MIDDLEWARE = {
    'dds.ev': 'middleware: its timers (heartbeats of reliable topics)',
    'dds.shm': 'middleware: shared memory (commands, acknowledgements)',
    'dds.udp': 'middleware: network (discovery)',
    'dds': 'middleware: the rest'}
"""Causes by the beginning of the thread's name; the longest counts."""


class Spent(NamedTuple):
    """What one thread has done so far."""

    wakes: int
    nanoseconds: int


def causes(node: int) -> dict[Path, str]:
    """Return all threads of the node and its dead-man, with what wakes them."""
    found: dict[Path, str] = {}
    others = []
    for process in family(node):
        for thread in Path(f'/proc/{process}/task').iterdir():
            name = (thread / 'comm').read_text().strip()
            known = [begin for begin in MIDDLEWARE if name.startswith(begin)]
            if process != node:
                found[thread] = DEAD_MAN
            elif known:
                found[thread] = MIDDLEWARE[max(known, key=len)]
            elif thread.name == str(node):
                found[thread] = MAIN
            else:
                others.append(thread)
    others.sort(key=lambda thread: int(thread.name))
    found.update(dict.fromkeys(others, REST))
    return found | dict(zip(others[-len(LAST):], LAST, strict=True))


def spent(node: int) -> dict[Path, tuple[str, Spent]]:
    """Return all threads of the node and its dead-man, with their causes."""
    found = {}
    for thread, why in causes(node).items():
        lines = dict(line.split(':', 1) for line in (thread / 'status').read_text().split('\n')
                     if ':' in line)
        nanoseconds = int((thread / 'schedstat').read_text().split()[0])
        found[thread] = why, Spent(int(lines['voluntary_ctxt_switches']), nanoseconds)
    return found


def watched(name: str, node: int) -> list[Figure]:
    """Return how often each cause woke the node in the next seconds."""
    before, begun = spent(node), monotonic()
    sleep(WATCH)
    after, passed = spent(node), monotonic() - begun
    wakes, times = Counter[str](), Counter[str]()
    for thread, (why, now) in after.items():
        then = before.get(thread, (why, Spent(0, 0)))[1]
        wakes[why] += now.wakes - then.wakes
        times[why] += now.nanoseconds - then.nanoseconds
    return [
        Figure(f'{name}: {why}', count / passed, 'a second',
               beside=f'{times[why] / count / 1e3:.0f} us each, '
                      f'{times[why] / passed / 1e7:.2f} % of a core')
        for why, count in wakes.most_common() if count]


def measure() -> list[Figure]:
    """Return the figures, standing and driving."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener(*(topic.name for topic in PUBLISHED))
        driver = stage.driver()
        listener.line()
        sleep(SETTLE)
        standing = watched('standing', driver.pid)
        stage.program('circle')
        sleep(SETTLE)
        return standing + watched('driving', driver.pid)


if __name__ == '__main__':
    run('bench_wakeups', measure)
