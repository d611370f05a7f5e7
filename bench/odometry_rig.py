# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What may happen to a robot in a drive, and robots that do not do what they are asked."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from random import Random

from create_oi_ros.odometry import Estimate, Geometry, Increment, Odometry
from create_oi_ros.robot import SLOT
from create_oi_ros.sim.body import Body
from robots import anywhere, centre, Robot

Event = Callable[[Random, Body], Iterator[object]]


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
    """Hold one wheel or both now and then."""
    before = False
    for begins, on in bursts(random, 20, 3):
        if begins or before != on:
            body.hold(right=on, left=on and random.random() < 0.7)
        before = on
        yield True


def pushed(random: Random, body: Body) -> Iterator[bool]:
    """Push the robot along, the way that it drives, now and then."""
    for begins, _ in bursts(random, 15, 2.5):
        truth = body.truth()
        if begins and abs(truth.speed) > 0.15 * abs(truth.rate):  # no wheel runs backwards
            faster = random.uniform(1.2, 2.5)
            body.push(speed=truth.speed * faster, rate=truth.rate * faster,
                      seconds=random.uniform(0.3, 2.5))
        yield True


# Robots.

def slower(robot: Robot, right: float, left: float) -> Robot:
    """Return a robot whose wheels run at these parts of their speeds."""
    config = robot.config
    return replace(robot, config=replace(
        config, right_speed_gain=config.right_speed_gain * right,
        left_speed_gain=config.left_speed_gain * left))


def loaded(random: Random) -> Robot:
    """Return a robot with a load that costs it about half its speed."""
    part = random.uniform(0.4, 0.7)
    return slower(random.choice((centre, anywhere))(random), part, part)


def lame(random: Random) -> Robot:
    """Return a robot of which one wheel runs at about 60 %."""
    parts = random.choice(((1.0, 0.6), (0.6, 1.0)))
    return slower(random.choice((centre, anywhere))(random), *parts)


class Misled(Odometry):
    """An odometry that is told other requests in curves than the wheels were given."""

    def __init__(self, geometry: Geometry, random: Random) -> None:
        super().__init__(geometry, window=1.0)
        self._parts = random.uniform(0.4, 1.25), random.uniform(0.4, 1.25)

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        mean, half = ((increment.right + sign * increment.left) / 2 for sign in (1, -1))
        if abs(half) > 0.012 < abs(mean):
            mean, half = mean / self._parts[0], half / self._parts[1]
        return super().update(increment._replace(
            right=round(mean + half, 3), left=round(mean - half, 3)))
