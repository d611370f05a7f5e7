# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The computer's side of the line: a state machine that decides what to send. Pure: no I/O."""

from .events import (
    BatteryLevel,
    Charging,
    DriverEvent,
    Health,
    LinkCounts,
    LowBatteryAction,
    ModeStatus,
    MotionLimits,
    Moved,
    Notice,
    Settings,
    Severity,
)
from .machine import Driver
from .motion import wheel_speeds
from .outbox import DEAD_MAN_STOP, Outcome, Pending
from .state import Activity
