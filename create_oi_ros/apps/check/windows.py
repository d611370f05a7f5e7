# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the readings of a check say: requests of each frame, and counts between two readings."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...odometry import Increment, Rounding
from ...robot import FIRMWARE_SEPARATION, MILLI
from .notebook import Page
from .trial_wheels import Array, Index

DEGREE = np.pi / 180
UNITS = np.array([MILLI, DEGREE])
Interval = tuple[Array, Array]
"""Low and high ends, of distance and angle."""
UNKNOWN = np.full(2, -1.0), np.full(2, 1.0)
"""Where a carried rest is before the first reading."""


class Windows(NamedTuple):
    """All readings of some moves; a row a reading."""

    asked: Array
    """Requests, m/s; axes (wheel, move, frame)."""
    period: float
    move: Index
    first: Index
    """Frame of the reading before."""
    last: Index
    """Frame of this reading."""
    low: Array
    """Least amount that may be behind a reading, metres and radians; axes (reading, unit)."""
    high: Array

    def predicted(self, counts: Array, separation: Array) -> Array:
        """
        Return what readings should be, axes (kind, reading, unit).

        `counts` are of `simulate`, with one sign; `separation` is relative, of each kind.
        """
        ends = counts[:, :, self.move, self.last] - counts[:, :, self.move, self.first]
        right, left = ends[:, 0], ends[:, 1]
        width = FIRMWARE_SEPARATION * (1 + separation)[:, None]
        predicted: Array = np.stack([(right + left) / 2, (right - left) / width], axis=-1)
        return predicted


    def only(self, moves: Sequence[int]) -> 'Windows':
        """Return the readings of these moves."""
        chosen = np.isin(self.move, moves)
        return self._replace(
            asked=self.asked[:, list(moves)], move=np.searchsorted(moves, self.move[chosen]),
            first=self.first[chosen], last=self.last[chosen], low=self.low[chosen],
            high=self.high[chosen])


def windows(pages: Sequence[Page], rounding: Rounding, period: float) -> Windows:
    """Return the readings of moves, in their order, as the rounding has them."""
    moves = [_spread(page.frames, period) for page in pages]
    asked = np.zeros((2, len(moves), max(len(frames) for frames in moves)))
    rows: list[tuple[int, int, int]] = []
    intervals: list[Interval] = []
    rest = UNKNOWN
    for index, frames in enumerate(moves):
        before, start, sums = 0, rest, np.zeros(2)
        for number, frame in enumerate(frames):
            if number:
                asked[:, index, number - 1] = frame.right, frame.left
            if frame.distance is None or frame.angle is None:
                continue
            read, was = np.array([frame.distance, frame.angle], float), rest
            rest = _rest_after(read, rest, moving=bool(asked[:, index, before:number].any()))
            if not number:
                start = rest
                continue
            rows.append((index, before, number))
            intervals.append(_interval(read, rounding, was, rest))
            before, sums = number, sums + read
            if rounding is Rounding.CARRY:  # the sum is as exact as a single reading
                rows.append((index, 0, number))
                intervals.append(_interval(sums, rounding, start, rest))
    move, first, last = np.array(rows).T
    low, high = np.array(intervals).transpose(1, 0, 2)
    return Windows(asked, period, move, first, last, low * UNITS, high * UNITS)


def _spread(frames: Sequence[Increment], period: float) -> list[Increment]:
    """Return frames of one period each: before one that took longer some were lost."""
    spread = [frames[0]]
    for frame in frames[1:]:
        lost = max(0, round(frame.dt / period) - 1)
        spread += [frame._replace(distance=None, angle=None)] * lost + [frame]
    return spread


def _rest_after(read: Array, before: Interval, *, moving: bool) -> Interval:
    """Return where a carried rest can be: it has the sign of what was read."""
    low, high = before
    unclear = (read == 0) & moving
    return (np.where(read > 0, 0.0, np.where((read < 0) | unclear, -1.0, low)),
            np.where(read < 0, 0.0, np.where((read > 0) | unclear, 1.0, high)))


def _interval(read: Array, rounding: Rounding, before: Interval, after: Interval) -> Interval:
    """Return the ends of what may be behind a reading, or a sum of readings, in units."""
    match rounding:
        case Rounding.TRUNCATE:
            return read - (read <= 0), read + (read >= 0)
        case Rounding.ROUND:
            return read - 0.5, read + 0.5
        case Rounding.CARRY:
            return read + after[0] - before[1], read + after[1] - before[0]
