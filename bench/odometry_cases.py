# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Trials of the odometry beside drives of random robots: a damaged line, logs of real wheels."""

from collections.abc import Callable, Sequence
import csv
from itertools import accumulate, pairwise
from math import degrees
from pathlib import Path
from random import Random
from typing import NamedTuple

from create_oi_ros.odometry import Increment, Odometry
from create_oi_ros.robot import FIRMWARE_SEPARATION
from create_oi_ros.sim.body.config import IDEAL
from create_oi_ros.sim.body.mechanics import Accumulator, Rounding
from odometry_loop import Journey
from rivals import Counts, Rival
from robots import Robot

C2_TICK = 0.0004446
"""Metres a count of a Create 2."""
COUNTS = 1 << 16
"""Its encoders begin again after so many."""
DAMAGED, SHORT, NOISY = 0.05, 0.05, 0.05
"""Probability that a byte of a frame is wrong, that one is missing, that garbage follows."""
SPEED, WAY, BEGIN = 0.1, 2.5, 2.0
"""m/s, m and seconds of the drive over a damaged line."""


def damage(random: Random) -> Callable[[bytes], bytes]:
    """Return what a bad line does to each piece that a robot sends."""
    def damaged(piece: bytes) -> bytes:
        if not piece:
            return piece
        made, where = bytearray(piece), random.randrange(len(piece))
        chance = random.random()
        if chance < DAMAGED:
            made[where] ^= random.randrange(1, 256)
        elif chance < DAMAGED + SHORT:
            del made[where]
        if random.random() < NOISY:
            made += random.randbytes(random.randint(1, 20))
        return bytes(made)
    return damaged


def damaged_line(rounding: Rounding, seed: int) -> float:
    """Drive straight over a damaged line; return the error, per cent of the way."""
    journey = Journey(Robot(IDEAL, rounding, 0.015), seed, damage=damage(Random(seed)))
    seconds = BEGIN + WAY / SPEED
    journey.drive([(BEGIN, SPEED, 0.0), (seconds, 0.0, 0.0)], seconds + 2)
    return 100 * abs(journey.estimate.x - journey.body.truth().pose.x) / WAY


class Row(NamedTuple):
    """A row of a log: seconds, requested m/s, metres that the encoders have counted."""

    time: float
    right: float
    left: float
    right_way: float
    left_way: float


def rows_of(path: Path) -> list[Row]:
    """Return a log of the wheels of a Create 2, a CSV with a row for each moment."""
    rows = list(csv.DictReader(path.read_text('utf-8').splitlines()))
    ways = (metres([int(row[f'encoder_{side}']) for row in rows]) for side in ('right', 'left'))
    return [Row(float(row['time_s']), int(row['requested_right_mm_s']) / 1000,
                int(row['requested_left_mm_s']) / 1000, *way)
            for row, *way in zip(rows, *ways)]


def metres(counts: Sequence[int]) -> list[float]:
    """Return what a wheel has rolled since the first count."""
    steps = ((b - a + COUNTS // 2) % COUNTS - COUNTS // 2 for a, b in pairwise(counts))
    return [C2_TICK * total for total in accumulate(steps, initial=0)]


def follow_log(log: Sequence[Row], rounding: Rounding) -> tuple[float, float]:
    """
    Let an odometry follow logged wheels, and its rival, which reads once a second.

    Return the error of both headings at the end, degrees; what the encoders count is the truth.
    """
    odometry = Odometry(window=1.0)
    rival = Rival(Robot(IDEAL, rounding, log[1].time - log[0].time), 1.0)
    distance, angle = Accumulator(rounding), Accumulator(rounding)
    counts = Counts(0.0, 0.0)
    turned = 0.0
    for before, row in pairwise(log):
        right, left = row.right_way - before.right_way, row.left_way - before.left_way
        turn = (right - left) / FIRMWARE_SEPARATION
        turned += turn
        far = 500 * (right + left)
        distance.add(far)
        angle.add(degrees(turn))
        counts = Counts(counts.distance + far, counts.angle + degrees(turn))
        rival.frame(counts, last=row is log[-1])
        due = odometry.reading_due
        odometry.update(Increment(
            dt=row.time - before.time, right=row.right, left=row.left,
            distance=distance.take() if due else None, angle=angle.take() if due else None))
    return degrees(odometry.estimate.yaw - turned), degrees(rival.yaw - turned)
