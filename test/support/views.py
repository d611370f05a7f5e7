# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Views of a robot, made by hand: what a goal is told of one frame."""

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits
from create_oi_ros.driver.goals.goal import View
from create_oi_ros.odometry import Estimate

QUIET = {'bumps_and_wheel_drops': 0, 'cliff_left': 0, 'cliff_front_left': 0,
         'cliff_front_right': 0, 'cliff_right': 0, 'oi_mode': int(oi.Mode.SAFE)}
"""Readings of a robot that feels nothing."""
LIMITS = MotionLimits(wheel_separation=0.25)
"""Limits with a wheel separation that makes sums easy: half of it is an eighth."""


def view(dt: float = 0.1, now: float = 0.0, *, estimate: Estimate | None = None,
         measured: bool = False, limits: MotionLimits = LIMITS, **readings: int) -> View:
    """Return a view; readings that are not given are those of a robot that feels nothing."""
    return View(now, dt, estimate or Estimate(), oi.Readings({**QUIET, **readings}), measured,
                limits)
