# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The computer's side of the line: a state machine that decides what to send. Pure: no I/O."""

from .battery_watch import BatteryLevel, BatteryLimits, LowBatteryAction
from .events import DriverEvent, LinkCounts, ModeChanged, Moved, Notice, Severity
from .health import Health
from .machine import Driver
from .motion import MotionLimits, wheel_speeds
from .pending import Outcome, Pending
from .settings import Settings
from .state import Activity
from .stopping import LAST_WORDS
from .supervision import Cause, ModeStatus

__all__ = [
    'Activity', 'BatteryLevel', 'BatteryLimits', 'Cause', 'Driver', 'DriverEvent', 'Health',
    'LAST_WORDS', 'LinkCounts', 'LowBatteryAction', 'ModeChanged', 'ModeStatus', 'MotionLimits',
    'Moved', 'Notice', 'Outcome', 'Pending', 'Settings', 'Severity', 'wheel_speeds',
]
