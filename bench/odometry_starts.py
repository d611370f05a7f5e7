# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The first half minute of robots that nobody knows: demonstrations are given at the start.

Short drives of the kinds of `drives`, and one more: turns at one speed for long, as in the logs of
real wheels. What counts is how far the yaw is off, in degrees, not what that is for each turn.
"""

from collections.abc import Iterator
from math import degrees
from multiprocessing.pool import Pool as Workers
from random import Random
from statistics import mean
from typing import NamedTuple

from drives import DRIVES, REST, Wish
from odometry_loop import Journey
from results import Figure
from rivals import Rival
from robots import CLASSES

KIND, FIRST = 'all ranges', 730_000
"""Class of the robots, and their first seed."""
STARTS_EACH = 10
"""Drives of each kind."""
SHORTEST, LONGEST, LATENCY = 15.0, 40.0, 0.005
"""Seconds."""


class Start(NamedTuple):
    """How far the yaw was off in a short drive, degrees; and a reading a second at its end."""

    end: float
    most: float
    """At any moment."""
    rival: float


def circling(random: Random, seconds: float) -> Iterator[Wish]:
    """Turn at one speed for long, then at another."""
    at = REST
    while at < seconds:
        yield at, random.uniform(0.03, 0.3), random.uniform(0.1, 1.5) * random.choice((1, -1))
        at += random.uniform(6.0, 20.0)


STYLES = {**DRIVES, 'circling': circling}


def start(style: str, seed: int) -> Start:
    """Drive a robot that nobody knows for a short time."""
    random = Random(f'start {KIND} {seed}')
    robot = CLASSES[KIND](random)
    seconds = random.uniform(SHORTEST, LONGEST)
    journey = Journey(robot, seed, latency=LATENCY)
    journey.drive(list(STYLES[style](random, seconds)), seconds)
    off = [degrees(abs(e.yaw - truth.turned)) for _, e, truth in journey.moves]
    rival = Rival(robot, 1.0).follow(journey.counts)
    turned = journey.body.truth().turned
    return Start(off[-1], max(off), degrees(abs(rival.yaw - turned)))


def starts(pool: Workers) -> list[Figure]:
    """Drive all; return how far they were off."""
    jobs = [(style, FIRST + i) for i in range(STARTS_EACH) for style in STYLES]
    every = pool.starmap(start, jobs)
    rival = mean(each.rival for each in every)
    return [Figure('the first half minute: off at the end', mean(each.end for each in every),
                   'deg', beside=f'a reading a second {rival:.1f}',
                   worst=max(each.end for each in every)),
            Figure('the first half minute: off at any moment', mean(each.most for each in every),
                   'deg', worst=max(each.most for each in every))]
