# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The moves of a check, and what each is for. Speeds in mm/s, right wheel first.

Every move begins and ends at rest. It is answered by its opposite, so that the robot stays near
its place.
"""

from enum import Enum
from typing import NamedTuple

from ...robot import SLOT

REST = 1.3
"""Seconds of rest after each move, in which the slowest wheel comes to a stop."""
TELLING_WAY = 15.0
"""Millimetres of a wheel between two readings: what a unit hides is little of it."""


class Reads(Enum):
    """When distance and angle are read during a move; at its end they always are."""

    END = 'end'
    """Only at the end: what is below a unit is lost once."""
    OFTEN = 'often'
    """Some times after each change of speed: to see how it grows and falls."""
    EVERY = 'every'
    """In every frame: to see what becomes of fractions."""


class Segment(NamedTuple):
    """Requested speeds for a while."""

    seconds: float
    right: int
    left: int


class Move(NamedTuple):
    """Segments, one after the other, and a rest."""

    segments: tuple[Segment, ...]
    reads: Reads

    @property
    def seconds(self) -> float:
        """How long it takes, rest included."""
        return sum(segment.seconds for segment in self.segments) + REST

    @property
    def intervals(self) -> tuple[int, ...]:
        """
        Frames from one reading to the next, in turn.

        They vary: steady motion that is read at even intervals is rounded alike each time.
        """
        if self.reads is not Reads.OFTEN:
            return (1,) if self.reads is Reads.EVERY else ()
        fastest = max(max(abs(segment.right), abs(segment.left)) for segment in self.segments)
        frames = TELLING_WAY / (fastest * SLOT)
        return tuple(max(3, round(part * frames)) for part in (1.0, 0.7, 1.3, 0.85, 1.15))


CREEPING = (4, 8, 10, 12, 15, 18, 22, 26)
"""mm/s, around the slowest speed that moves a wheel."""


class CheckStep(NamedTuple):
    """Moves that a person confirms together."""

    about: str
    """What the robot is going to do, and the space it needs."""
    moves: tuple[Move, ...]


def _both(seconds: float, right: int, left: int, reads: Reads, times: int = 1) -> list[Move]:
    """Return a move and its opposite, so many times."""
    return [Move((Segment(seconds, sign * right, sign * left),), reads)
            for _ in range(times) for sign in (1, -1)]


def _turned_back(seconds: float, right: int, left: int, times: int) -> list[Move]:
    """Return moves that reverse at full speed."""
    return [Move((Segment(seconds, sign * right, sign * left),
                  Segment(seconds, -sign * right, -sign * left)), Reads.OFTEN)
            for _ in range(times) for sign in (1, -1)]


STEPS = (
    CheckStep('very slowly, to find the slowest speed that moves it: 0.1 m ahead', tuple(
        move for speed in CREEPING for move in _both(2.2, speed, speed, Reads.END))),
    CheckStep('slowly, while it is asked how far it came in every frame: 0.2 m ahead', (
        *_both(3.0, 48, 48, Reads.EVERY), *_both(2.5, 44, 44, Reads.EVERY),
        *_both(2.5, 110, -110, Reads.EVERY))),
    CheckStep('straight ahead and back, more and more slowly: 0.5 m ahead', (
        *_both(1.8, 150, 150, Reads.OFTEN, 2), *_both(2.2, 76, 76, Reads.OFTEN, 3),
        *_both(2.6, 50, 50, Reads.OFTEN, 4), *_both(2.6, 35, 35, Reads.END))),
    CheckStep('ahead, and back without a pause: 0.5 m ahead and behind', (
        *_turned_back(0.9, 250, 250, 3), *_turned_back(0.8, 120, 120, 2))),
    CheckStep('one wheel at a time: half a metre around', (
        *_both(2.0, 180, 0, Reads.OFTEN), *_both(2.0, 0, 180, Reads.OFTEN))),
    CheckStep('turns in place, both ways: no space but its own', (
        *_both(3.0, 220, -220, Reads.END), *_both(1.5, 220, -220, Reads.END),
        *_both(1.5, 150, -150, Reads.OFTEN, 2),
        *_turned_back(0.9, 250, -250, 2))),
    CheckStep('straight ahead and back, quickly: 0.9 m of free floor ahead', (
        *_both(2.5, 300, 300, Reads.END), *_both(1.5, 300, 300, Reads.END),
        *_both(1.3, 300, 300, Reads.OFTEN, 3))),
)
"""Quick and long moves come last: they tell the gains best, and gains may change with time."""
