"""The host's machine: wanted mode, watchdog, limits, stream plan. Pure: no clock, no I/O."""

from .battery_watch import BatteryLevel, BatteryLimits, LowBatteryAction
from .baud_search import LAST_WORDS
from .events import DriverEvent, Link, LinkCounts, ModeChanged, Moved, Notice, Severity
from .machine import Driver
from .motion import MotionLimits, wheel_speeds
from .requests import Reply
from .settings import Settings
from .supervision import Cause, ModeStatus

__all__ = [
    'BatteryLevel', 'BatteryLimits', 'Cause', 'Driver', 'DriverEvent', 'LAST_WORDS', 'Link',
    'LinkCounts', 'LowBatteryAction', 'ModeChanged', 'ModeStatus', 'MotionLimits', 'Moved',
    'Notice', 'Reply', 'Settings', 'Severity', 'wheel_speeds',
]
