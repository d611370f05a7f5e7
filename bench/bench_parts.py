# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Processor time of one frame, by parts: `python bench/bench_parts.py`, forty seconds, a table.

The node runs as a process, standing, with one subscriber on each topic in another process. The
reading thread is profiled (programs/timed.py): a call that has a row of its own counts only in
that row. The time of the node's other threads and of its dead-man process is what the kernel
counts beyond the reading thread. Taking the time costs time, too; that is in the rest.

The last rows show the cost of waking up: the same work in a tight loop, and after 15 ms of sleep.
"""

from collections.abc import Callable
from random import Random
from time import sleep, thread_time_ns
from typing import Any, NamedTuple

from bench_oi import FULL_AT_57600, plausible_frame
from create_oi_ros import oi
from create_oi_ros.ros.topics import PUBLISHED
from processes import family, processor_shares
from results import Figure, repeated, run
from scene import scene

REPETITIONS = 3
# Seconds to wait before a measurement, and its duration.
SETTLE, WATCH = 2.0, 5.0
PARTS = {
    'Publisher.publish': 'publish of rclpy',
    'Odometry.update': 'odometry',
    'Port.read': 'reading the port',
    'StreamReader.next_event': 'finding and verifying the frame',
    'Tracking.take': 'its readings, whether they can be true, its stamp',
    'Driver.receive': 'what else a frame sets off in the driver at once',
    'FramePublisher.publish': 'deciding which messages are due, and filling them',
    'Driver.poll': 'what follows from a frame: mode, hazards, battery, line, motion, stream plan',
}
REST = 'locks, events and calls between them, and the taking of time'
THREADS = "the node's other threads: executor, middleware"
DEAD_MAN = 'the dead-man'
ROUNDS = 100


class Profile(NamedTuple):
    """One run of the node, averaged over its frames."""

    microseconds: dict[str, float]
    """Processor time of each part for one frame."""
    messages: float
    """Messages published for one frame."""


def measured() -> Profile:
    """Run the node once."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener(*(topic.name for topic in PUBLISHED))
        node = stage.program('timed', '--ros-args', '-p', f'port:={stage.port}')
        listener.line()
        sleep(SETTLE)
        whole, *others = processor_shares([node.pid, *family(node.pid)[1:]], WATCH)
        return profile(node.result(), whole, sum(others))


def profile(result: Any, whole: float, others: float) -> Profile:
    """
    Divide the processor time of a run into parts.

    `result` is what programs/timed.py prints; `whole` and `others` are the processor shares of
    the node with its children and of the children, % of a core.
    """
    calls, spent = result['calls'], result['spent']
    frames = calls['Odometry.update']
    parts = {name: spent[key] / frames / 1e3 for key, name in PARTS.items()}
    thread = result['thread'] / frames / 1e3
    slot = 1e6 * oi.SLOT / 100  # microseconds of a frame in one per cent of a core
    parts[REST] = thread - sum(parts.values())
    parts[THREADS] = (whole - others) * slot - thread
    parts[DEAD_MAN] = others * slot
    return Profile(parts, calls['Publisher.publish'] / frames)


def sum_of_a_hundred() -> None:
    """Add a hundred numbers: work that is nothing but Python."""
    total = 0
    for number in range(100):
        total += number


def decoding() -> Callable[[], None]:
    """Return a function that decodes one frame."""
    frame = plausible_frame(FULL_AT_57600, Random(1))
    reader = oi.StreamReader([FULL_AT_57600])

    def decode() -> None:
        reader.feed(frame)
        event = reader.next_event()
        assert isinstance(event, oi.Frame)
        assert event.readings is not None
    return decode


def wake_up(name: str, work: Callable[[], None]) -> list[Figure]:
    """Time work in a tight loop, and the same work after a sleep each time."""
    times: dict[float, list[float]] = {0.0: [], oi.SLOT: []}
    for pause, took in times.items():
        for _ in range(ROUNDS):
            if pause:
                sleep(pause)
            begun = thread_time_ns()
            work()
            took.append((thread_time_ns() - begun) / 1e3)
    return [repeated(f'{name}, again and again', times[0.0], 'us'),
            repeated(f'{name}, after a slot of sleep', times[oi.SLOT], 'us')]


def measure() -> list[Figure]:
    """Return the figures of all parts."""
    runs = [measured() for _ in range(REPETITIONS)]
    totals = [sum(each.microseconds.values()) for each in runs]
    messages = sorted(each.messages for each in runs)[REPETITIONS // 2]
    figures = []
    for part in runs[0].microseconds:
        values = [each.microseconds[part] for each in runs]
        share = 100 * sum(values) / sum(totals)
        many = f', {messages:.1f} messages' if part == PARTS['Publisher.publish'] else ''
        figures.append(repeated(part, values, 'us', beside=f'{share:.0f} %{many}'))
    return [*figures, repeated('all of it', totals, 'us', beside='100 %'),
            *wake_up('a loop of a hundred additions', sum_of_a_hundred),
            *wake_up('a frame, from its bytes to its readings', decoding())]


if __name__ == '__main__':
    run('bench_parts', measure)
