# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Processor time and memory of processes, from /proc (Linux)."""

import os
from pathlib import Path
from time import monotonic, sleep

PAGE = os.sysconf('SC_PAGE_SIZE')
MEGA = 1 << 20


def machine_seconds() -> float:
    """Return the busy time of all cores together since the machine started, seconds."""
    with open('/proc/stat', encoding='ascii') as file:
        user, nice, system, _, _, irq, soft, steal, *_ = map(int, file.readline().split()[1:])
    return (user + nice + system + irq + soft + steal) / os.sysconf('SC_CLK_TCK')


def family(number: int) -> list[int]:
    """Return a process id and those of all its descendants."""
    children = [int(child) for task in Path(f'/proc/{number}/task').iterdir()
                for child in (task / 'children').read_text('ascii').split()]
    return [number, *(each for child in children for each in family(child))]


def processor_seconds(number: int) -> float:
    """Return the processor time that a process and its descendants have used so far, seconds."""
    return sum(
        int((task / 'schedstat').read_text('ascii').split()[0]) / 1e9
        for each in family(number) for task in Path(f'/proc/{each}/task').iterdir())


def processor_share(number: int, seconds: float) -> float:
    """Wait; return the processor share of a process and its descendants, % of one core."""
    used, begun = processor_seconds(number), monotonic()
    sleep(seconds)
    return 100 * (processor_seconds(number) - used) / (monotonic() - begun)


def resident(number: int) -> float:
    """Return the resident memory of a process without its children, MB."""
    return int(Path(f'/proc/{number}/statm').read_text('ascii').split()[1]) * PAGE / MEGA
