# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How fast the simulated Create is: `python bench/bench_sim.py`, 4 minutes, a table.

In memory: a robot drives while all single packets are streamed. Served: `create_sim` processes on
pseudo terminals, read by this process. The floor is `programs/line_floor.py`, as many of them and
as often, in turn with the robots. A frame's lateness is measured from the robot's earliest frame,
so delays of the reading process and of the scheduler count as well. Other work on the machine
shows: its load is printed.
"""

from collections.abc import Callable, Iterator
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
from typing import NamedTuple

from create_oi_ros import oi
from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import shipped
from processes import processor_seconds
from results import Figure, repeated, run

ALL = tuple(oi.PACKETS)
FIT = tuple(number for number in oi.PACKETS if number not in (15, 16, 38))
"""As many packets as fit into a slot at 57600 baud."""
SETTLE, WATCH = 2.0, 8.0
"""Seconds before and while a served robot is watched."""
ROUNDS = 5
"""Times that served robots are measured."""
FLOOR = Path(__file__).parent / 'programs' / 'line_floor.py'
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


def robot(port: Path) -> list[str]:
    """Return the command that serves a robot."""
    return [sys.executable, '-c', PROGRAMS['create_sim'], '--link', str(port), '--world', 'room']


def floor(port: Path) -> list[str]:
    """Return the command that writes as much as a robot, and does nothing else."""
    return [sys.executable, str(FLOOR), str(port), str(oi.PacketList(FIT).frame_size),
            str(oi.SLOT)]


@contextmanager
def served(command: list[str], port: Path) -> Iterator[tuple[int, int]]:
    """Run a program; yield its process number and a descriptor of its port."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
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
    earliest = min(offsets)
    return [offset - earliest for offset in offsets]


class Watched(NamedTuple):
    """What several programs did at once."""

    processor: float
    """Per cent of a core that each took."""
    came: float
    """Per cent of the frames that were due."""
    late: list[float]
    """Seconds after its slot of each frame, the least first."""


def watch(program: Callable[[Path], list[str]], count: int) -> Watched:
    """Run a program this many times at once."""
    with TemporaryDirectory() as folder, ExitStack() as stack:
        ports = (Path(folder) / f'create{n}' for n in range(count))
        robots = [stack.enter_context(served(program(port), port)) for port in ports]
        lines = [line for _, line in robots]
        arrivals(lines, SETTLE)
        before = [processor_seconds(number) for number, _ in robots]
        begin = monotonic()
        times = arrivals(lines, WATCH)
        passed = monotonic() - begin
        used = [processor_seconds(number) - past
                for (number, _), past in zip(robots, before, strict=True)]
    late = sorted(each for line in lines for each in lateness(times[line]))
    return Watched(100 * sum(used) / count / passed,
                   100 * len(late) * oi.SLOT / count / passed, late)


def served_figures(count: int) -> list[Figure]:
    """Measure robots and the floor in turn, several times: how dear code is varies by minutes."""
    robots, floors = [], []
    for _ in range(ROUNDS):
        robots.append(watch(robot, count))
        floors.append(watch(floor, count))
    name = f'{count} served' if count > 1 else 'one served'
    least = median(each.processor for each in floors)
    ratios = [each.processor / beside.processor
              for each, beside in zip(robots, floors, strict=True)]

    def late(what: str, part: float) -> Figure:
        return repeated(f'{name}: frames late, {what}',
                        [1e3 * each.late[int(len(each.late) * part)] for each in robots], 'ms')

    return [
        repeated(f'{name}: processor, of one core, a robot',
                 [each.processor for each in robots], '%', 2.5),
        repeated(f'{name}: processor, beside the floor', ratios, 'x floor',
                 beside=f'floor {least:.1f} % of a core'),
        repeated(f'{name}: frames within 2 ms of their slot',
                 [100 * sum(time <= ON_TIME for time in each.late) / len(each.late)
                  for each in robots], '%', 99, at_least=True),
        late('median', 0.5),
        late('99th percentile', 0.99),
        repeated(f'{name}: frames that came', [each.came for each in robots], '%',
                 at_least=True),
    ]


def measure() -> list[Figure]:
    """Measure everything."""
    return [
        *(Figure(f'in memory, all 36 packets streamed, {world}: faster than real time',
                 max(times_real_time(world) for _ in range(3)), 'x', 100, at_least=True)
          for world in ('empty', 'room', 'apartment')),
        Figure('in memory: a million random bytes', fuzz_seconds(), 's'),
        *served_figures(1),
        *served_figures(20),
    ]


if __name__ == '__main__':
    run('bench_sim', measure)
