# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bodies of simulated robots with sums that are easy."""

from dataclasses import replace

from create_oi_ros.sim.body import Body as AnyBody
from create_oi_ros.sim.body.config import IDEAL
from create_oi_ros.sim.world import parse, World

B = IDEAL.wheel_separation
FRAME = 0.015
WALL_AHEAD = parse('wall 1 -5 1 5', 'wall')


def Body(world, *, config=IDEAL, **kwargs):
    """Return a body whose wheels ramp without delay, so that sums are easy."""
    return AnyBody(world, config=config, **kwargs)


def ideal(**changes):
    """Return the ideal wheels with some changes."""
    return replace(IDEAL, **changes)


def run(body, seconds, dt=FRAME):
    for _ in range(round(seconds / dt)):
        body.step(dt)


def body_at_speed(right, left, world=None, **kwargs):
    """Return a body that drives at these speeds and whose accumulators are empty."""
    body = Body(world or World(), **kwargs)
    body.drive(right=right, left=left)
    body.step(1.2)
    body.take_distance(), body.take_angle()
    return body
