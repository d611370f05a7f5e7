"""The host's machine: wanted mode, watchdog, limits, stream plan. Pure: no clock, no I/O."""

from .machine import (
    Driver,
    DriverEvent,
    Link,
    LinkCounts,
    Moved,
    Notice,
    Reply,
    Settings,
    Severity,
)
from .motion import MotionLimits, wheel_speeds
from .supervision import Cause, ModeStatus

__all__ = [
    'Cause', 'Driver', 'DriverEvent', 'Link', 'LinkCounts', 'ModeStatus', 'MotionLimits', 'Moved',
    'Notice', 'Reply', 'Settings', 'Severity', 'wheel_speeds',
]
