# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The driver's settings, fixed before it starts."""

from dataclasses import dataclass, field

from .. import oi
from ..odometry import Geometry, Knowledge
from ..oi.codes import START_BAUDS
from .battery_watch import BatteryLimits
from .motion import MotionLimits


@dataclass(frozen=True)
class Settings:
    """Settings in SI units."""

    baud: int = START_BAUDS[0]
    """Bits per second; 0 searches for the robot's rate."""
    mode_on_start: oi.Mode = oi.Mode.SAFE
    mode_on_exit: oi.Mode = oi.Mode.PASSIVE
    recover_mode: bool = True
    """Whether a fresh velocity command brings back a mode that a hazard ended."""
    reset_when_not_charging: bool = False
    """Whether a robot that does not charge on its dock is restarted."""
    odometry_window: float = 1.0
    """Seconds between readings of distance and angle; 0 reads them in every frame."""
    battery: BatteryLimits = field(default_factory=BatteryLimits)
    limits: MotionLimits = field(default_factory=MotionLimits)
    geometry: Geometry = field(default_factory=Geometry)
    robot: Knowledge | None = None
    """What is known of this robot; None: the odometry learns everything."""
