# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Distance and angle in; pose, twist and covariance out. Pure: no clock, no I/O, SI units."""

from ..robot import Rounding
from .estimate import (
    Estimate,
    Geometry,
    GyroSettings,
    Increment,
    Knowledge,
    Known,
    KnownGyro,
    SignSource,
)
from .gyro import GyroState
from .odometry import Odometry
