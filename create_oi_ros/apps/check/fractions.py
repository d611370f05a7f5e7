# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What becomes of the fractions of distance and angle: cut off, rounded, or carried.

The robot is read in every frame while it moves by less than a unit a frame. A robot that cuts off
then reports nothing at all, one that rounds reports too much, one that carries reports what it is.
"""

from collections.abc import Sequence
from math import copysign, exp, pi
from typing import NamedTuple

from ...odometry import Increment, Rounding
from ...robot import FIRMWARE_SEPARATION, MM_PER_M
from .moves import Reads
from .notebook import Page

STEADY = 1.1
"""Seconds after the begin of a move from which on the wheels run evenly."""
TICKS = (0.0, 0.27, 0.4446)
"""Millimetres of a wheel's travel for each count: none, and what was reported of two robots."""
ROUGH, LEAST = 0.06, 2.0
"""How far a sum may be off: a part of the motion, and units."""
MOST = 8.0
"""Greatest cost of one sum: something else may have gone wrong."""


class Steady(NamedTuple):
    """The steady part of a move that was read in every frame."""

    frames: int
    right: float
    """Requested way of the right wheel in a frame, mm."""
    left: float
    """The same of the left wheel."""
    distance: int
    angle: int


def roundings(pages: Sequence[Page], period: float) -> dict[Rounding, float]:
    """Return the probability of each rounding."""
    line, turn = _gain(pages, 1), _gain(pages, -1)
    steady = [_steady(page, period) for page in pages if page.move.reads is Reads.EVERY]
    costs = {}
    for rounding in Rounding:
        by_tick = [sum(_cost(each, rounding, tick, line, turn) for each in steady)
                   for tick in TICKS]
        costs[rounding] = min(by_tick)
    weights = {each: exp(min(costs.values()) - cost) for each, cost in costs.items()}
    return {each: weight / sum(weights.values()) for each, weight in weights.items()}


def _gain(pages: Sequence[Page], side: int) -> float:
    """
    Return what is counted over what is asked, of lines (side 1) or of turns (-1).

    The difference of a long and a short move is free of what starting and stopping cost.
    """
    counted: dict[tuple[int, float], list[int]] = {}
    for page in pages:
        segment = page.move.segments[0]
        if page.move.reads is Reads.END and segment.left == side * segment.right:
            key = abs(segment.right), segment.seconds
            counted.setdefault(key, []).append(abs(page.counted[0 if side == 1 else 1]))
    fastest = max(speed for speed, _ in counted)
    means = {seconds: sum(each) / len(each) for (speed, seconds), each in counted.items()
             if speed == fastest}
    short, long = min(means), max(means)
    asked = fastest * (long - short)
    if side == -1:
        asked *= 2 / FIRMWARE_SEPARATION / MM_PER_M * 180 / pi
    return float((means[long] - means[short]) / asked)


def _steady(page: Page, period: float) -> Steady:
    segment = page.move.segments[0]
    seconds, frames = 0.0, []
    for frame in page.frames[1:]:
        seconds += frame.dt
        if STEADY < seconds < segment.seconds:
            frames.append(frame)
    return Steady(
        round(sum(frame.dt for frame in frames) / period), segment.right * period,
        segment.left * period, _sum(frames, 'distance'), _sum(frames, 'angle'))


def _sum(frames: Sequence[Increment], name: str) -> int:
    return sum(getattr(frame, name) or 0 for frame in frames)


def _cost(steady: Steady, rounding: Rounding, tick: float, line: float, turn: float) -> float:
    """Return how badly a rounding explains the sums of a steady move."""
    middle = (steady.right + steady.left) / 2 * line
    half = (steady.right - steady.left) / 2 * turn
    right, left = middle + half, middle - half
    ways = [(_at(right, tick, n), _at(left, tick, n)) for n in range(steady.frames + 1)]
    total = 0.0
    width = FIRMWARE_SEPARATION * MM_PER_M
    for read, counted in ((steady.distance, [(r + left) / 2 for r, left in ways]),
                          (steady.angle, [(r - left) / width * 180 / pi for r, left in ways])):
        expected = _read(counted, rounding)
        spread = ROUGH * abs(counted[-1]) + LEAST
        total += min(((read - expected) / spread) ** 2 / 2, MOST)
    return total


def _at(step: float, tick: float, frames: int) -> float:
    """Return what an encoder has counted after some frames, mm."""
    way = step * frames
    return int(way / tick + copysign(1e-6, way)) * tick if tick else way


def _read(counted: Sequence[float], rounding: Rounding) -> float:
    """Return the sum of what is read in every frame."""
    if rounding is Rounding.CARRY:
        return counted[-1]
    nudge = 0.5 if rounding is Rounding.ROUND else 1e-6
    steps = (b - a for a, b in zip(counted, counted[1:]))
    return float(sum(int(step + copysign(nudge, step)) for step in steps))
