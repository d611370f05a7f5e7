# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a robot is asked to do: six kinds of drives, as velocities over time.

Each yields (seconds, m/s, rad/s): from that moment on this is wanted. A drive ends at rest.
"""

from collections.abc import Callable, Iterator
from math import atan2, copysign, cos, hypot, pi, radians, remainder, sin, tau
from random import Random

from robots import spread

REST = 2.0
"""Seconds of standing at both ends of a drive."""
TICK = 0.05
"""Seconds between two commands of whoever steers smoothly."""

Wish = tuple[float, float, float]


def mixed(random: Random, seconds: float) -> Iterator[Wish]:
    """Arcs, turns in place, lines, stops, reversals, all at once."""
    at = REST
    while at < seconds - REST:
        kind = random.choice(('arc', 'arc', 'arc', 'spin', 'spin', 'line', 'stop'))
        linear = angular = 0.0
        if kind in ('arc', 'line'):
            linear = spread(random, 0.01, 0.5) * random.choice((1, 1, -1))
        if kind in ('arc', 'spin'):
            angular = radians(spread(random, 2, 200)) * random.choice((1, -1))
        yield at, linear, angular
        at += random.uniform(0.3, 5.0)
    yield seconds - REST, 0.0, 0.0


def smooth(random: Random, seconds: float) -> Iterator[Wish]:
    """Follow a path planner: speed and curvature change steadily, 20 times a second."""
    at, linear, angular = REST, 0.0, 0.0
    goal, turn, until = 0.0, 0.0, 0.0
    while at < seconds - REST - 1.0:
        if at >= until:
            goal = random.choice((0.0, 0.1, 0.2, 0.26, 0.3, 0.3))
            turn = random.choice((0.0, random.uniform(-1.0, 1.0), random.uniform(-0.4, 0.4)))
            until = at + random.uniform(1.5, 6.0)
        linear += max(-2.5 * TICK, min(2.5 * TICK, goal - linear))
        angular += max(-3.2 * TICK, min(3.2 * TICK, turn - angular))
        wobble = 0.15 * sin(2 * pi * at / 2.3) if goal else 0.0
        yield at, linear, angular + wobble
        at += TICK
    yield seconds - REST - 1.0, 0.0, 0.0


def joystick(random: Random, seconds: float) -> Iterator[Wish]:
    """Let a child drive: full sticks, sudden reversals, and pauses."""
    at = REST
    while at < seconds - REST:
        linear = random.choice((0.0, 0.3, 0.5, 0.2, -0.3, -0.2))
        angular = random.choice((0.0, 0.0, 1.5, -1.5, 3.0, -3.0, 0.7))
        for _ in range(random.randint(1, 6)):
            if at < seconds - REST:
                yield (at, linear * random.uniform(0.6, 1.0), angular * random.uniform(0.6, 1.0))
            at += random.uniform(0.05, 0.6)
        if random.random() < 0.3 and at < seconds - REST:
            yield at, 0.0, 0.0
            at += random.uniform(0.1, 1.5)
    yield seconds - REST, 0.0, 0.0


def creeping(random: Random, seconds: float) -> Iterator[Wish]:
    """Slowly, for long: docking, lining up."""
    at = REST
    while at < seconds - REST:
        linear = spread(random, 0.012, 0.06) * random.choice((1, 1, 1, -1, 0))
        angular = radians(spread(random, 3, 20)) * random.choice((1, -1, 0))
        yield at, linear, angular
        at += random.uniform(3.0, 12.0)
    yield seconds - REST, 0.0, 0.0


def straight(random: Random, seconds: float) -> Iterator[Wish]:
    """Long lines with a turn in place at their ends, by a controller that holds the heading."""
    at = REST
    while at < seconds - REST - 12:
        linear, weave = random.choice((0.1, 0.15, 0.2, 0.3)), random.choice((0.0, 0.05))
        until = at + random.uniform(5.0, 15.0)
        while at < until:
            yield at, linear, weave * cos(at)
            at += 0.1 if weave else until - at
        yield at, 0.0, 0.0
        at += random.uniform(0.2, 1.0)
        rate = random.choice((0.5, 1.0, 1.5)) * random.choice((1, -1))
        yield at, 0.0, rate
        at += random.choice((pi / 2, pi, pi / 4)) / abs(rate)
        yield at, 0.0, 0.0
        at += random.uniform(0.2, 1.0)
    yield seconds - REST, 0.0, 0.0


def waypoints(random: Random, seconds: float) -> Iterator[Wish]:
    """From place to place in a room, with a small correction in each command, as Nav2 drives."""
    side, speed, rate = random.uniform(2, 7), random.uniform(0.1, 0.45), random.uniform(0.5, 2)
    gain, reached = random.uniform(1, 3), random.uniform(0.05, 0.1)
    aimed, sloppy = random.choice((0.1, 0.3, 0.6)), random.uniform(0, 0.01)
    pause = random.choice((TICK, 0.1, 0.2))
    at, x, y, yaw = REST, 0.0, 0.0, 0.0
    goal_x, goal_y = 0.0, 0.0
    while at < seconds - REST:
        if hypot(goal_x - x, goal_y - y) < reached:
            goal_x, goal_y = random.uniform(0, side), random.uniform(0, side)
        far = hypot(goal_x - x, goal_y - y)
        off = remainder(atan2(goal_y - y, goal_x - x) - yaw + random.gauss(0, sloppy), tau)
        linear, angular = min(speed, far), max(-rate, min(rate, gain * off))
        if abs(off) > aimed:
            linear, angular = 0.0, copysign(min(rate, 2 * abs(off)), off)
        yield at, linear, angular
        x += linear * pause * cos(yaw + angular * pause / 2)
        y += linear * pause * sin(yaw + angular * pause / 2)
        yaw += angular * pause
        at += pause
    yield seconds - REST, 0.0, 0.0


DRIVES: dict[str, Callable[[Random, float], Iterator[Wish]]] = {
    'mixed': mixed, 'smooth': smooth, 'joystick': joystick, 'creeping': creeping,
    'straight': straight}
