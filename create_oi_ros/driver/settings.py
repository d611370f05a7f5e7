"""The driver's settings, fixed before it starts."""

from dataclasses import dataclass, field

from .. import oi
from ..odometry import Geometry
from .battery_watch import BatteryLimits
from .motion import MotionLimits


@dataclass(frozen=True)
class Settings:
    """Settings in SI units."""

    baud: int = 57600
    """Bits per second; 0 looks for the robot's rate."""
    mode_on_start: oi.Mode = oi.Mode.SAFE
    mode_on_exit: oi.Mode = oi.Mode.PASSIVE
    recover_mode: bool = True
    odometry_window: float = 1.0
    """Seconds between readings of distance and angle; 0 reads them in every frame."""
    battery: BatteryLimits = field(default_factory=BatteryLimits)
    limits: MotionLimits = field(default_factory=MotionLimits)
    geometry: Geometry = field(default_factory=Geometry)
