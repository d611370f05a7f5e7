# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How fast the Open Interface is: `python bench/bench_oi.py`, ten seconds, a table.

A frame is measured from its bytes to its readings: fed, found, verified, decoded. It is compared
with the least that any Python program must do: one `struct.unpack` of the same bytes into
header, length, ids, values and checksum, with nothing checked or named.
"""

from collections.abc import Callable
from math import inf
from operator import attrgetter
import os
from pathlib import Path
from random import Random
import struct
import subprocess
import sys
from tempfile import TemporaryDirectory
from timeit import repeat, timeit

from create_oi_ros import oi
from results import Figure, run

ROOT = Path(__file__).parent.parent
SINGLES = oi.PacketList(oi.PACKETS)
FULL_AT_57600 = oi.PacketList(number for number in oi.PACKETS if number not in (15, 16, 38))
CHUNK = 16  # bytes that a serial port returns at once


def microseconds(*works: Callable[[], object], number: int = 1000) -> list[float]:
    """
    Return the time of one call of each: the best of many runs, because noise only adds.

    They run in turn, so that a slow moment of the machine affects all of them.
    """
    best = [inf] * len(works)
    for _ in range(75):
        took = [timeit(work, number=number) for work in works]
        best = [*map(min, best, took)]
    return [seconds / number * 1e6 for seconds in best]


def plausible_frame(packets: oi.PacketList, random: Random) -> bytes:
    """Return a frame whose values are within the manual's ranges."""
    wires = [packet.wire for packet in packets.packets]
    return packets.pack_frame([
        random.choice([*filter(wire.allows, range(wire.low, wire.high + 1))]) for wire in wires])


def stream_figures(name: str, packets: oi.PacketList) -> list[Figure]:
    """Measure the frame of a list, from its bytes to its readings."""
    frame = plausible_frame(packets, Random(1))
    pieces = [frame[start:start + CHUNK] for start in range(0, len(frame), CHUNK)]
    reader = oi.StreamReader([packets])
    fields = struct.Struct(
        '>BB' + ''.join(f'B{packet.wire.format}' for packet in packets.packets) + 'B')
    values = struct.Struct('>' + ''.join(packet.wire.format for packet in packets.packets))
    reply, names = frame[-values.size:], packets.names
    every = attrgetter(*names)

    def whole() -> oi.Readings:
        reader.feed(frame)
        return reader.next_event().readings  # type: ignore[union-attr]

    def looked_at() -> object:
        return every(whole())

    def found_only() -> object:
        reader.feed(frame)
        return reader.next_event()

    def in_pieces() -> object:
        for piece in pieces:
            reader.feed(piece)
            found = reader.next_event()
        return found.readings  # type: ignore[union-attr]

    bare, spent, found, looked, cut, named = microseconds(
        lambda: fields.unpack(frame), whole, found_only, looked_at, in_pieces,
        lambda: dict(zip(names, values.unpack(reply))))
    text = f'{name} ({len(frame)} bytes)'
    return [
        Figure(f'{text}: bytes to readings', spent, 'us', 8),
        Figure(f'{text}: the same as multiple of a bare struct.unpack', spent / bare, 'x'),
        Figure(f'{text}: of that, to the verified frame', found, 'us'),
        Figure(f'{text}: with every value looked at', looked, 'us'),
        Figure(f'{text}: cut in pieces of {CHUNK} bytes', cut, 'us'),
        Figure(f'{text}: bare struct.unpack', bare, 'us'),
        Figure(f'{text}: struct.unpack and a dict of the names', named, 'us'),
    ]


def start_up(statement: str) -> float:
    """Return the milliseconds of a Python process from start to end, its modules compiled."""
    work = [sys.executable, '-c', statement]
    with TemporaryDirectory() as compiled:
        here = os.environ | {'PYTHONPYCACHEPREFIX': compiled, 'PYTHONDONTWRITEBYTECODE': ''}
        runs = repeat(
            lambda: subprocess.run(work, check=True, cwd=ROOT, env=here), number=1, repeat=15)
    return min(runs) * 1e3


def measure() -> list[Figure]:
    """Measure everything."""
    drive, = microseconds(lambda: oi.DriveDirect(right=300, left=-300).encode())
    return [
        *stream_figures('all that fit 57600 baud', FULL_AT_57600),
        *stream_figures('all 36', SINGLES),
        Figure('Drive Direct: construct and encode', drive, 'us', 5),
        Figure('import, beyond Python itself',
               start_up('import create_oi_ros.oi') - start_up('pass'), 'ms', 40),
    ]


if __name__ == '__main__':
    run('bench_oi', measure)
