# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How fast the simulated Create is: `python bench/bench_sim.py`, 40 seconds, a table.

In memory: a robot drives while all single packets are streamed. Served: `create_sim` processes on
pseudo terminals, read by this process. A frame's lateness is measured from the robot's earliest
frame, so delays of the reading process and of the scheduler count as well. Other work on the
machine shows: its load is printed.
"""

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import os
from pathlib import Path
from random import Random
import select
from statistics import median
import subprocess
import sys
from tempfile import TemporaryDirectory
from time import monotonic, perf_counter

from create_oi_ros import oi
from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import shipped
from processes import processor_seconds
from results import Figure, run

ALL = tuple(oi.PACKETS)
FIT = tuple(number for number in oi.PACKETS if number not in (15, 16, 38))
"""As many packets as fit into a slot at 57600 baud."""
SETTLE, WATCH = 2.0, 8.0
"""Seconds before and while a served robot is watched."""
ROUNDS = 5
"""Times that served robots are measured."""
ON_TIME = 0.002
"""Seconds after its slot by which a frame counts as on time."""


def begun(packets: tuple[int, ...]) -> bytes:
    """Return the bytes that make a robot drive in circles and stream."""
    return (oi.Start().encode() + oi.Safe().encode() + oi.Stream(packets=packets).encode()
            + oi.Drive(velocity=200, radius=300).encode())


def times_real_time(world: str, seconds: float = 60.0) -> float:
    """Return how much faster than real time a robot runs in memory."""
    create = Create(Body(shipped(world)))
    create.receive(begun(ALL), 0.0)
    begin = perf_counter()
    for slot in range(1, round(seconds / oi.SLOT)):
        create.poll(slot * oi.SLOT)
        create.data_to_send()
    return seconds / (perf_counter() - begin)


def fuzz_seconds(count: int = 1_000_000) -> float:
    """Return how long random bytes take; a power failure ends each wait."""
    random, create = Random(1), Create(
        Body(shipped('room')), guesses=Guesses(boot_seconds=0.0, opcode_7_resets=False))
    create.receive(begun(ALL), 0.0)
    begin = perf_counter()
    for part in range(count // 100):
        now = part * oi.SLOT
        create.receive(random.randbytes(100), now)
        create.data_to_send()
        if create.waiting:
            create.lose_battery(now)
            create.receive(begun(ALL), now)
    return perf_counter() - begin


@contextmanager
def served(port: Path) -> Iterator[tuple[int, int]]:
    """Run a robot; yield its process number and a descriptor of its port."""
    process = subprocess.Popen(
        [sys.executable, '-c', PROGRAMS['create_sim'], '--link', str(port), '--world', 'room'],
        stdout=subprocess.PIPE)
    try:
        assert process.stdout is not None
        process.stdout.readline()
        line = os.open(port, os.O_RDWR | os.O_NOCTTY)
        try:
            os.write(line, begun(FIT))
            yield process.pid, line
        finally:
            os.close(line)
    finally:
        process.terminate()
        process.communicate()


def arrivals(lines: list[int], seconds: float) -> dict[int, list[float]]:
    """Return when the frames of each line were complete."""
    size = oi.PacketList(FIT).frame_size
    times: dict[int, list[float]] = {line: [] for line in lines}
    pending = dict.fromkeys(lines, 0)
    poll = select.epoll()
    for line in lines:
        poll.register(line, select.EPOLLIN)
    end = monotonic() + seconds
    while monotonic() < end:
        for line, _ in poll.poll(0.1):
            pending[line] += len(os.read(line, 65536))
            now = monotonic()
            times[line] += [now] * (pending[line] // size)
            pending[line] %= size
    poll.close()
    return times


def lateness(times: list[float]) -> list[float]:
    """Return the delay of each frame after its slot, relative to the earliest."""
    offsets = [time - place * oi.SLOT for place, time in enumerate(times)]
    return [offset - min(offsets) for offset in offsets]


def served_figures(count: int) -> list[Figure]:
    """Measure this many robots at once, a process each."""
    with TemporaryDirectory() as folder, ExitStack() as stack:
        robots = [stack.enter_context(served(Path(folder) / f'create{n}')) for n in range(count)]
        lines = [line for _, line in robots]
        arrivals(lines, SETTLE)
        before = [processor_seconds(number) for number, _ in robots]
        begin = monotonic()
        times = arrivals(lines, WATCH)
        passed = monotonic() - begin
        used = [processor_seconds(number) - past
                for (number, _), past in zip(robots, before, strict=True)]
    late = sorted(each for line in lines for each in lateness(times[line]))
    name = f'{count} served' if count > 1 else 'one served'
    expected = count * passed / oi.SLOT
    return [
        Figure(f'{name}: processor, of one core, a robot', 100 * sum(used) / count / passed,
               '%', 2.5),
        Figure(f'{name}: frames within 2 ms of their slot',
               100 * sum(each <= ON_TIME for each in late) / len(late), '%', 99, at_least=True),
        Figure(f'{name}: frames late, median', 1e3 * late[len(late) // 2], 'ms'),
        Figure(f'{name}: frames late, 99th percentile', 1e3 * late[len(late) * 99 // 100], 'ms'),
        Figure(f'{name}: frames that came', 100 * len(late) / expected, '%',
               at_least=True),
    ]


def repeated_figures(count: int) -> list[Figure]:
    """Measure the same several times: how dear code is after a sleep varies."""
    runs = [served_figures(count) for _ in range(ROUNDS)]
    rows = ((row[0], [each.value for each in row]) for row in zip(*runs, strict=True))
    return [first._replace(value=median(values), worst=(min if first.at_least else max)(values))
            for first, values in rows]


def measure() -> list[Figure]:
    """Measure everything."""
    return [
        *(Figure(f'in memory, all 36 packets streamed, {world}: faster than real time',
                 max(times_real_time(world) for _ in range(3)), 'x', 100, at_least=True)
          for world in ('empty', 'room', 'apartment')),
        Figure('in memory: a million random bytes', fuzz_seconds(), 's'),
        *repeated_figures(1),
        *repeated_figures(20),
    ]


if __name__ == '__main__':
    run('bench_sim', measure)
