# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Drives for `bench_odometry`: a body with wheels and encoders, a line that delays, an odometry.

The robot's motion does not depend on who reads it, so each drive is simulated once (`Drive`) and
then read under every rounding by every estimator (`follow`). Requests take effect from the start
of the slot in which they arrive, as in `sim.firmware`, or at any moment of it.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import degrees, hypot, tau
from random import Random
from typing import NamedTuple

import numpy as np

from create_oi_ros.odometry import Estimate, Geometry, Increment, Odometry
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import IDEAL
from create_oi_ros.sim.body.mechanics import Accumulator, Rounding
from create_oi_ros.sim.world import World
from drives import mixed
from robots import spread

SLOT = 0.015
HALF_TRACK = 0.129
FLOOR = Geometry().slip
DEMO = 5.0
"""Seconds after which a demo changes its mind, at most."""


class Instant(NamedTuple):
    """What a frame could say, and the truth at that moment."""

    counted: float
    """Millimetres by the encoders since the start, unrounded; likewise degrees."""
    counted_angle: float
    right: int
    left: int
    driven: bool
    lifted: bool
    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Condition:
    """What the world does to a drive."""

    name: str
    gain: float = 0.03
    """Wheels run up to this part faster or slower than asked."""
    latency: float = 0.0
    """Seconds of delay on the line each way, at most."""
    any_moment: bool = False
    """Whether requests take effect within their slot, not from its start."""
    happens: str = ''
    """slip, held, lifted, pushed or demo."""
    slip: float = FLOOR
    """What the estimator is told of the floor."""
    seconds: float = 90.0


CONDITIONS = (
    Condition('ideal', gain=0.0, seconds=300),
    Condition('3 % speed error', seconds=300),
    Condition('and latency', latency=0.03, any_moment=True, seconds=300),
    Condition('slip bursts', latency=0.03, happens='slip', slip=0.03),
    Condition('wheels held', latency=0.03, happens='held'),
    Condition('lifted', latency=0.03, happens='lifted'),
    Condition('pushed', latency=0.03, happens='pushed'),
    Condition('demo', latency=0.03, happens='demo'),
)


def wheel_speeds(random: Random, seconds: float) -> Iterator[tuple[float, int, int]]:
    """Yield moments and wheel speeds of a mixed drive, mm/s, none of them above the top speed."""
    for at, linear, angular in mixed(random, seconds):
        right, left = linear + angular * HALF_TRACK, linear - angular * HALF_TRACK
        scale = 1000 * 0.5 / max(abs(right), abs(left), 0.5)
        yield at, round(right * scale), round(left * scale)


def simulate(seed: int, condition: Condition) -> list[Instant]:
    """Drive once; return what happened, slot by slot."""
    random = Random(seed)
    body = Body(World(), config=replace(
        IDEAL, wheel_acceleration=spread(random, 0.5, 2.0),
        right_speed_gain=1 + random.uniform(-condition.gain, condition.gain),
        left_speed_gain=1 + random.uniform(-condition.gain, condition.gain)))
    requests = deque(arrivals(random, condition))
    event = EVENTS.get(condition.happens, nothing)(random, body)
    right = left = 0
    instants = []
    for slot in range(round(condition.seconds / SLOT)):
        driven = next(event)
        left_over = SLOT
        while requests and requests[0][0] < (slot + 1) * SLOT:
            at, right, left = requests.popleft()
            if condition.any_moment:
                first = max(0.0, at - (slot + 1) * SLOT + left_over)
                body.step(first)
                left_over -= first
            if driven or condition.happens == 'demo':
                body.drive(right=right / 1000, left=left / 1000)
        if condition.happens == 'lifted':
            body.drive(right=right / 1000 * driven, left=left / 1000 * driven)
        body.step(left_over)
        truth = body.truth()
        instants.append(Instant(body.distance_total, body.angle_total, right, left, driven,
                                condition.happens == 'lifted' and not driven,
                                truth.pose.x, truth.pose.y, truth.turned))
    return instants


def arrivals(random: Random, condition: Condition) -> Iterator[tuple[float, int, int]]:
    """Yield requests when the robot hears them."""
    last = 0.0
    for at, right, left in wheel_speeds(random, condition.seconds):
        last = max(last, at + random.uniform(0, SLOT) + random.uniform(0, condition.latency))
        yield last, right, left


# What may happen: each is told of every slot, and says whether the wheels obey in it.

def nothing(random: Random, body: Body) -> Iterator[bool]:
    """Leave the robot alone."""
    while True:
        yield True


def bursts(random: Random, every: float, last: float) -> Iterator[tuple[bool, bool]]:
    """Yield for each slot whether a burst begins in it and whether one is on."""
    slot, begin, end = 0, random.uniform(2, every), 0.0
    while True:
        now = slot * SLOT
        begins = now >= begin
        if begins:
            end = now + random.uniform(last / 3, last)
            begin = end + random.uniform(2, every)
        yield begins, now < end
        slot += 1


def slip(random: Random, body: Body) -> Iterator[bool]:
    """Let wheels lose up to half of their travel for up to half a second."""
    for begins, _ in bursts(random, 10, 0.5):
        if begins:
            body.slip(right=random.uniform(0, 0.5), left=random.uniform(0, 0.5), seconds=0.3)
        yield True


def held(random: Random, body: Body) -> Iterator[bool]:
    """Hold the wheels for up to three seconds."""
    for _, on in bursts(random, 20, 3):
        body.hold(right=on, left=on)
        yield True


def lifted(random: Random, body: Body) -> Iterator[bool]:
    """Lift the robot for up to three seconds: its wheels drop, so it stops and goes Passive."""
    for _, on in bursts(random, 20, 3):
        body.lift(on)
        yield not on


def pushed(random: Random, body: Body) -> Iterator[bool]:
    """Roll the robot forward in Passive, for up to three seconds."""
    for begins, _ in bursts(random, 5, 3):
        if begins:
            speed = random.uniform(0.05, 0.3)
            rate = random.uniform(-0.8, 0.8) * speed / HALF_TRACK
            body.push(speed=speed, rate=rate, seconds=random.uniform(0.5, 3))
        yield False


def demo(random: Random, body: Body) -> Iterator[bool]:
    """Let the robot drive of its own will: the requests are not what a frame says."""
    while True:
        yield False


EVENTS: dict[str, Callable[[Random, Body], Iterator[bool]]] = {
    'slip': slip, 'held': held, 'lifted': lifted, 'pushed': pushed, 'demo': demo}


class Score(NamedTuple):
    """How well an odometry followed a drive."""

    turn: float
    """Degrees of yaw error at the end per 360 degrees of rotation, in whichever direction."""
    distance: float
    """Position error at the end, per cent of the path's length."""
    nees: float


def follow(instants: list[Instant], rounding: Rounding, condition: Condition) -> Score:
    """Let an odometry follow a drive over a line with delays, and judge its last estimate."""
    odometry = Odometry(Geometry(slip=condition.slip), window=1.0)
    latency, random = condition.latency, Random(len(instants))
    distance, angle = Accumulator(rounding), Accumulator(rounding)
    switches: deque[tuple[float, bool]] = deque()
    full = asked = False
    counted = counted_angle = heard = 0.0
    for slot, instant in enumerate(instants, 1):
        now = slot * SLOT
        distance.add(instant.counted - counted)
        angle.add(instant.counted_angle - counted_angle)
        counted, counted_angle = instant.counted, instant.counted_angle
        while switches and switches[0][0] <= now:
            full = switches.popleft()[1]
        estimate = odometry.update(Increment(
            dt=SLOT, right=instant.right / 1000, left=instant.left / 1000, driven=instant.driven,
            lifted=instant.lifted, distance=distance.take() if full else None,
            angle=angle.take() if full else None))
        if odometry.reading_due != asked:
            asked = not asked
            heard = max(heard, now + random.uniform(0, latency) + random.uniform(0, latency))
            switches.append((heard, asked))
    end = instants[-1]
    turned = sum(abs(b.yaw - a.yaw) for a, b in zip(instants, instants[1:]))
    path = sum(hypot(b.x - a.x, b.y - a.y) for a, b in zip(instants, instants[1:]))
    return Score(degrees(abs(estimate.yaw - end.yaw)) / max(turned / tau, 1e-9),
                 100 * hypot(estimate.x - end.x, estimate.y - end.y) / max(path, 1e-9),
                 nees_of(end.x, end.y, end.yaw, estimate))


def nees_of(x: float, y: float, yaw: float, estimate: Estimate) -> float:
    """Return the normalised estimation error squared at a true pose: 3 on average is honest."""
    error = np.array([estimate.x - x, estimate.y - y, estimate.yaw - yaw])
    covariance = np.array(estimate.pose_covariance).reshape(3, 3)
    return float(error @ np.linalg.solve(covariance, error))
