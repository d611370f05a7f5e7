"""
Where the time of a frame goes: `python bench/bench_parts.py`, forty seconds, a table.

The node runs as a process, standing, one subscriber on each topic, which is another process.
Thread time is taken around the steps of the thread that reads the port (programs/timed.py); what
a step calls that has a row of its own is counted there. What the node's other threads and its
dead-man take is what the kernel counts beyond that. Taking the time is work, too: it is part of
the rest.

And what waking up costs: the same work done again and again, and after a slot of sleep each.
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
SETTLE, WATCH = 2.0, 5.0
"""Seconds before, and while the processor time is counted."""
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


class Seen(NamedTuple):
    """One run of the node."""

    microseconds: dict[str, float]
    """What each part takes, a frame."""
    messages: float
    """Messages published, a frame."""


def watched() -> Seen:
    """Watch the node for a while."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener(*(topic.name for topic in PUBLISHED))
        node = stage.program('timed', '--ros-args', '-p', f'port:={stage.port}')
        listener.line()
        sleep(SETTLE)
        whole, *others = processor_shares([node.pid, *family(node.pid)[1:]], WATCH)
        return seen(node.told(), whole, sum(others))


def seen(told: Any, whole: float, others: float) -> Seen:
    """Divide what the kernel counted, % of a core, into what the node's thread told of."""
    calls, spent = told['calls'], told['spent']
    frames = calls['Odometry.update']
    parts = {name: spent[key] / frames / 1e3 for key, name in PARTS.items()}
    thread = told['thread'] / frames / 1e3
    slot = 1e6 * oi.SLOT / 100  # a per cent of a core, us a frame
    parts[REST] = thread - sum(parts.values())
    parts[THREADS] = (whole - others) * slot - thread
    parts[DEAD_MAN] = others * slot
    return Seen(parts, calls['Publisher.publish'] / frames)


def sum_of_a_hundred() -> None:
    """Do what is nothing but Python."""
    total = 0
    for number in range(100):
        total += number


def decoding() -> Callable[[], None]:
    """Return the work that every frame is."""
    frame = plausible_frame(FULL_AT_57600, Random(1))
    reader = oi.StreamReader([FULL_AT_57600])

    def decode() -> None:
        reader.feed(frame)
        event = reader.next_event()
        assert isinstance(event, oi.Frame)
        assert event.readings is not None
    return decode


def woken(name: str, work: Callable[[], None]) -> list[Figure]:
    """Compare work that is done again and again with work after a sleep."""
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
    """Measure everything."""
    runs = [watched() for _ in range(REPETITIONS)]
    totals = [sum(each.microseconds.values()) for each in runs]
    messages = sorted(each.messages for each in runs)[REPETITIONS // 2]
    figures = []
    for part in runs[0].microseconds:
        values = [each.microseconds[part] for each in runs]
        share = 100 * sum(values) / sum(totals)
        many = f', {messages:.1f} messages' if part == PARTS['Publisher.publish'] else ''
        figures.append(repeated(part, values, 'us', beside=f'{share:.0f} %{many}'))
    return [*figures, repeated('all of it', totals, 'us', beside='100 %'),
            *woken('a loop of a hundred additions', sum_of_a_hundred),
            *woken('a frame, from its bytes to its readings', decoding())]


if __name__ == '__main__':
    run('bench_parts', measure)
