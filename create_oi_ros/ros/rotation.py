# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Yaw to and from a quaternion: a robot on a floor turns about the vertical only. Pure."""

from math import atan2, cos, remainder, sin, tau
from typing import Any


def of_yaw(yaw: float) -> tuple[float, float]:
    """Return z and w of the quaternion that turns by `yaw` radians; its x and y are 0."""
    return sin(yaw / 2), cos(yaw / 2)


def yaw_of(rotation: Any) -> float:
    """Return the yaw of a quaternion, -pi to pi."""
    return remainder(2 * atan2(rotation.z, rotation.w), tau)
