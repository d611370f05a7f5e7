"""The host's machine: wanted mode, watchdog, limits, stream plan. Pure: no clock, no I/O."""

from .events import DriverEvent, Link, LinkCounts, Moved, Notice, Severity
from .machine import Driver
from .motion import MotionLimits, wheel_speeds
from .requests import Reply
from .settings import Settings
from .supervision import Cause, ModeStatus

__all__ = [
    'Cause', 'Driver', 'DriverEvent', 'Link', 'LinkCounts', 'ModeStatus', 'MotionLimits', 'Moved',
    'Notice', 'Reply', 'Settings', 'Severity', 'wheel_speeds',
]
