# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How fast Drive turns each wheel (manual: Drive, opcode 137, and its special cases)."""

from typing import NamedTuple

from .codes import Radius

STRAIGHT = (Radius.STRAIGHT, Radius.STRAIGHT_7FFF, 0)
"""Radii that mean straight. The manual allows 0 but does not explain it; straight is a guess."""


class WheelSpeeds(NamedTuple):
    """Speeds of the two wheels, mm/s; forward is positive."""

    right: float
    left: float


def wheel_speeds(velocity: float, radius: int, separation: float) -> WheelSpeeds:
    """
    Return the wheel speeds that Drive requests: velocity in mm/s, radius and separation in mm.

    The outer wheel may exceed the robot's top speed.
    """
    if radius in STRAIGHT:
        return WheelSpeeds(velocity, velocity)
    if radius == Radius.IN_PLACE_CLOCKWISE:
        return WheelSpeeds(-velocity, velocity)
    if radius == Radius.IN_PLACE_COUNTER_CLOCKWISE:
        return WheelSpeeds(velocity, -velocity)
    difference = velocity * separation / 2 / radius
    return WheelSpeeds(velocity + difference, velocity - difference)
