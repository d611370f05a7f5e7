# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Robots drawn at random from what was measured and reported (docs/simulator.md)."""

from dataclasses import dataclass, replace
from math import exp, log
from random import Random

from create_oi_ros.odometry import Geometry
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import BodyConfig, DEFAULT_BODY, EncoderSign
from create_oi_ros.sim.body.wheels import Response, TimeConstant

ROUNDINGS = tuple(Rounding)
JITTERS, WANDERS = (0.004, 0.025), (0.0, 0.05)
"""How unsteadily wheels run, as five logs of real wheels show it (docs/simulator.md)."""
SIGNS = (EncoderSign.DRIVE, EncoderSign.DRIVE, EncoderSign.UNTIL_REST, EncoderSign.COMMAND,
         EncoderSign.TRUE)


@dataclass(frozen=True)
class Robot:
    """A body, what the firmware adds to it, and what a calibration of it found."""

    config: BodyConfig
    rounding: Rounding
    period: float
    """Seconds between two frames."""

    @property
    def geometry(self) -> Geometry:
        """The geometry of a robot that was calibrated: angle and distance are true on average."""
        return Geometry(angular_scale=(
            self.config.encoder_separation / self.config.wheel_separation))


def spread(random: Random, low: float, high: float) -> float:
    """Draw a positive number whose logarithm is evenly spread."""
    return exp(random.uniform(log(low), log(high)))


def centre(random: Random) -> Robot:
    """Return the simulator's default robot, whatever is drawn."""
    return Robot(DEFAULT_BODY, Rounding.TRUNCATE, 0.015)


def anywhere(random: Random) -> Robot:
    """Draw each parameter from its whole range."""
    track = random.uniform(0.250, 0.266)
    gain = random.uniform(0.95, 1.05)
    ratio = random.uniform(0.95, 1.05) ** 0.5
    response = random.choice(tuple(Response))
    fastest = random.choice((0.076, 0.5))
    config = replace(
        DEFAULT_BODY, wheel_separation=track, encoder_separation=random.uniform(0.250, 0.266),
        response=response,
        time_constant=TimeConstant(
            spread(random, 0.03, 0.3) * (0.4 if response is Response.SECOND_ORDER else 1.0),
            random.choice((0.0, random.uniform(0, 1), 1.0)), fastest=fastest),
        overshoot=random.uniform(0.02, 0.4), wheel_acceleration=spread(random, 0.3, 3.0),
        braking=random.choice((1.0, spread(random, 0.3, 3.0))),
        dead_time=random.uniform(0, 0.15), dead_band=random.uniform(0, 0.025),
        right_speed_gain=gain / ratio, left_speed_gain=gain * ratio,
        encoder_tick=random.choice((0.0, 0.00027, 0.0004446)), encoder_sign=random.choice(SIGNS))
    return Robot(config, random.choice(ROUNDINGS), random.uniform(0.015, 0.015625))


def exact(random: Random) -> Robot:
    """Draw from the ranges a robot that carries fractions and knows its wheels' directions."""
    drawn = anywhere(random)
    return replace(drawn, rounding=Rounding.CARRY, config=replace(
        drawn.config, encoder_sign=EncoderSign.TRUE))


def unsteady(random: Random) -> Robot:
    """Draw from the ranges a robot whose wheels do not run steadily."""
    drawn = anywhere(random)
    return replace(drawn, config=replace(
        drawn.config, speed_jitter=spread(random, *JITTERS),
        speed_wander=random.uniform(*WANDERS)))
