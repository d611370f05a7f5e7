"""Yaw to and from a quaternion: a robot on a floor turns about the vertical only. Pure."""

from math import atan2, cos, remainder, sin, tau
from typing import Any


def set_yaw(rotation: Any, yaw: float) -> None:
    """Make a quaternion the rotation by `yaw` radians; x and y stay 0."""
    rotation.z = sin(yaw / 2)
    rotation.w = cos(yaw / 2)


def yaw_of(rotation: Any) -> float:
    """Return the yaw of a quaternion, -pi to pi."""
    return remainder(2 * atan2(rotation.z, rotation.w), tau)
