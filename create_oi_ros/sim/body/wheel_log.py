# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A recording of real wheels: encoder counts over time, for a body that replays them."""

from __future__ import annotations

from bisect import bisect_right
import csv
from dataclasses import dataclass

C2_TICK = 0.0004446
"""Metres a count of a Create 2."""
COUNTS = 65536


@dataclass(frozen=True, slots=True)
class WheelLog:
    """Metres that each wheel has travelled at each moment, seconds."""

    times: tuple[float, ...]
    right: tuple[float, ...]
    left: tuple[float, ...]

    @classmethod
    def parse(cls, text: str, tick: float = C2_TICK) -> WheelLog:
        """Read a CSV with the columns time_s, encoder_left and encoder_right (16 bits)."""
        rows = list(csv.DictReader(text.splitlines()))
        if len(rows) < 2:
            raise ValueError('a recording has two rows or more')
        return cls(tuple(float(row['time_s']) for row in rows),
                   _unwrapped([int(row['encoder_right']) for row in rows], tick),
                   _unwrapped([int(row['encoder_left']) for row in rows], tick))

    def wheel(self, side: str) -> LoggedWheel:
        """Return what replays one wheel, 'right' or 'left'."""
        return LoggedWheel(self.times, self.right if side == 'right' else self.left)


class LoggedWheel:
    """Turns as recorded, then stands."""

    def __init__(self, times: tuple[float, ...], travelled: tuple[float, ...]) -> None:
        self.speed = 0.0
        self._times, self._travelled = times, travelled
        self._now = times[0]

    def aim(self, goal: float) -> None:
        """Ignore what is asked."""

    def horizon(self, longest: float) -> float:
        """Return the seconds until the next row, at most `longest`."""
        after = bisect_right(self._times, self._now + 1e-9)
        if after == len(self._times):
            return longest
        return min(longest, self._times[after] - self._now)

    def roll(self, h: float) -> float:
        """Let h seconds pass; return the metres travelled."""
        before = self._at(self._now)
        self._now += h
        travel = self._at(self._now) - before
        self.speed = travel / h if h else 0.0
        return travel

    def _at(self, now: float) -> float:
        times, travelled = self._times, self._travelled
        after = bisect_right(times, now)
        if after == 0 or after == len(times):
            return travelled[min(after, len(times) - 1)]
        a, b = times[after - 1], times[after]
        part = (now - a) / (b - a)
        return travelled[after - 1] * (1 - part) + travelled[after] * part


def _unwrapped(counts: list[int], tick: float) -> tuple[float, ...]:
    """Return metres since the first count, from counts that wrap at 16 bits."""
    total, metres = 0, [0.0]
    for a, b in zip(counts, counts[1:]):
        total += (b - a + COUNTS // 2) % COUNTS - COUNTS // 2
        metres.append(total * tick)
    return tuple(metres)
