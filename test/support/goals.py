# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals given to a driver that plays against the simulated robot in memory."""

from math import degrees, radians
from typing import NamedTuple

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings
from create_oi_ros.driver.goals import (
    Code,
    DriveArc,
    DriveDistance,
    Goal,
    NavigateToPosition,
    RotateAngle,
)
from create_oi_ros.driver.state import Activity
from create_oi_ros.sim.body.config import BodyConfig, DEFAULT_BODY
from support.loop import Loop, STEP

FRAME = oi.SLOT
SPEED, TURNING = 0.3, 1.9
PATIENCE = 200.0
"""Seconds in which every goal of a test ends."""


def distance(metres: float, speed: float = SPEED, allowance: float = 0.0) -> DriveDistance:
    """Return a goal that drives straight."""
    return DriveDistance(metres, speed, allowance)


def angle(turn: float, speed: float = TURNING, allowance: float = 0.0) -> RotateAngle:
    """Return a goal that turns, by degrees."""
    return RotateAngle(radians(turn), speed, allowance)


def arc(turn: float, radius: float, direction: int = 1, speed: float = SPEED) -> DriveArc:
    """Return a goal that drives on a circle, by degrees."""
    return DriveArc(radians(turn), radius, direction, speed, 0.0)


def place(x: float, y: float, heading: float | None = None) -> NavigateToPosition:
    """Return a goal that drives to a place, with a heading in degrees."""
    return NavigateToPosition(
        x, y, None if heading is None else radians(heading), SPEED, TURNING, 0.0)


def start(loop: Loop, goal: Goal) -> Goal:
    """Give the driver a goal."""
    return loop.driver.goals.start(goal, loop.now)


class Ending(NamedTuple):
    """How a goal ended."""

    code: Code
    text: str
    docked: bool


def until_ended(loop: Loop, running: Goal, within: float = PATIENCE) -> Ending:
    """Let time pass until the goal has ended; return how."""
    deadline = loop.now + within
    while running.outcome is None:
        assert loop.now < deadline, 'the goal has not ended'
        loop.turn()
    assert running.outcome.ok is (running.code is Code.NONE)
    return Ending(running.code, running.outcome.text, running.docked)


def pursue(loop: Loop, goal: Goal) -> Ending:
    """Give the driver a goal, and let time pass until it has ended."""
    return until_ended(loop, start(loop, goal))


def reach(loop: Loop, goal: Goal) -> tuple[float, float]:
    """Pursue a goal that succeeds; return the true way, m, and turn, degrees."""
    before = loop.body.truth()
    ending = pursue(loop, goal)
    assert ending.code is Code.NONE, ending
    loop.run(1.0)
    after = loop.body.truth()
    return after.travelled - before.travelled, degrees(after.turned - before.turned)


def met(limits: MotionLimits | None = None, *, settings: Settings | None = None,
        config: BodyConfig = DEFAULT_BODY, **options) -> Loop:
    """Return a robot and a driver that have met, in Safe mode."""
    loop = Loop(settings or Settings(limits=limits or MotionLimits()), config=config, **options)
    loop.run(1.0)
    return loop


def moving(loop: Loop, goal=None):
    """Start a goal and wait until the robot moves."""
    running = start(loop, goal or distance(1.0))
    loop.run(1.0)
    assert running.outcome is None
    assert any(loop.robot.actuators.wheels)
    return running


def ended(loop: Loop, running, within: float = 2 * FRAME) -> Ending:
    """Return how a goal ended, which must be very soon; the wheels are told to stand then."""
    ending = until_ended(loop, running, within)
    loop.run(2 * STEP)
    assert loop.robot.actuators.wheels == (0, 0)
    assert loop.driver.state.activity is not Activity.GOAL
    return ending
