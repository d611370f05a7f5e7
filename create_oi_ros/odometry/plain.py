# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Odometry as the robot reports it: every reading is taken for the truth."""

from math import cos, sin

from .estimate import Estimate, Geometry, Increment
from .hypotheses import DEGREE, MM

LOST_DISTANCE, LOST_ANGLE = MM ** 2 / 3, DEGREE ** 2 / 3
"""Variance of what one reading drops, m² and rad², if drops were independent; they are not."""


class PlainOdometry:
    """Adds up whole millimetres and degrees."""

    def __init__(self, geometry: Geometry) -> None:
        self.geometry = geometry
        self._waiting = 0.0

    def after(self, before: Estimate, increment: Increment) -> Estimate:
        """Return the estimate that follows."""
        self._waiting += increment.dt
        if increment.distance is None or increment.angle is None:
            return before
        g, dt, self._waiting = self.geometry, self._waiting, 0.0
        distance = increment.distance * MM * g.linear_scale
        angle = increment.angle * DEGREE * g.angular_scale
        middle = before.yaw + angle / 2
        chord = distance * (sin(angle / 2) / (angle / 2) if angle else 1.0)
        dx, dy = chord * cos(middle), chord * sin(middle)
        right = (distance + angle * g.wheel_separation / 2) / g.wheel_radius
        left = (distance - angle * g.wheel_separation / 2) / g.wheel_radius
        moving = bool(distance or angle or increment.right or increment.left)
        return Estimate(
            x=before.x + dx, y=before.y + dy, yaw=before.yaw + angle,
            linear=distance / dt, angular=angle / dt,
            pose_covariance=_grown(before.pose_covariance, dx, dy, moving),
            twist_covariance=(LOST_DISTANCE / dt ** 2, LOST_ANGLE / dt ** 2),
            right_wheel=before.right_wheel + right, right_wheel_speed=right / dt,
            left_wheel=before.left_wheel + left, left_wheel_speed=left / dt)


def _grown(p: tuple[float, ...], dx: float, dy: float, moving: bool) -> tuple[float, ...]:
    """Carry a covariance over a displacement, and add what a reading may have lost."""
    xx, xy, xa, _, yy, ya, _, _, aa = p
    far, turn = (LOST_DISTANCE, LOST_ANGLE) if moving else (0.0, 0.0)
    xx, xy, yy = (xx - 2 * dy * xa + dy * dy * aa + far,
                  xy + dx * xa - dy * ya - dx * dy * aa,
                  yy + 2 * dx * ya + dx * dx * aa + far)
    xa, ya = xa - dy * aa, ya + dx * aa
    return xx, xy, xa, xy, yy, ya, xa, ya, aa + turn
