"""What processes use, as the kernel counts it (Linux)."""

import os
from pathlib import Path
from time import monotonic, sleep

PAGE = os.sysconf('SC_PAGE_SIZE')
MEGA = 1 << 20


def machine_seconds() -> float:
    """Return the seconds that all cores together have been busy."""
    with open('/proc/stat', encoding='ascii') as file:
        user, nice, system, _, _, irq, soft, steal, *_ = map(int, file.readline().split()[1:])
    return (user + nice + system + irq + soft + steal) / os.sysconf('SC_CLK_TCK')


def family(number: int) -> list[int]:
    """Return a process and all that it has started."""
    children = [int(child) for task in Path(f'/proc/{number}/task').iterdir()
                for child in (task / 'children').read_text('ascii').split()]
    return [number, *(each for child in children for each in family(child))]


def processor_seconds(number: int) -> float:
    """Return the processor time that a process and its children have used, to the nanosecond."""
    return sum(
        int((task / 'schedstat').read_text('ascii').split()[0]) / 1e9
        for each in family(number) for task in Path(f'/proc/{each}/task').iterdir())


def processor_shares(numbers: list[int], seconds: float) -> list[float]:
    """Return how much of one core each process takes, per cent, over some time."""
    before, begun = [processor_seconds(number) for number in numbers], monotonic()
    sleep(seconds)
    passed = monotonic() - begun
    return [100 * (processor_seconds(number) - used) / passed
            for number, used in zip(numbers, before)]


def resident(number: int) -> float:
    """Return the memory of a process that is in use, MB, its children's not included."""
    return int(Path(f'/proc/{number}/statm').read_text('ascii').split()[1]) * PAGE / MEGA
