# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Turns the battery's voltage into a level: fine, low or nearly empty."""

from dataclasses import dataclass
from enum import Enum
from math import inf

from .. import oi
from ..robot import MILLI

SETTLE = 5.0
"""Seconds that the voltage must stay below a limit: motors that start pull it down."""
RISE = 0.3
"""Volts above a limit at which the battery counts as better again."""


class LowBatteryAction(Enum):
    """What to do when the battery is nearly empty."""

    NONE = 'none'
    STOP = 'stop'
    DOCK = 'dock'


class BatteryLevel(Enum):
    """State of the battery by its voltage."""

    FINE = 'fine'
    LOW = 'low'
    EMPTY = 'nearly empty'


@dataclass(frozen=True)
class BatteryLimits:
    """Voltages of the whole battery, V, and what to do below the lower one."""

    low: float = 13.5
    empty: float = 12.5
    action: LowBatteryAction = LowBatteryAction.NONE


class BatteryWatch:
    """Turns voltages into a level, with a delay and a hysteresis."""

    def __init__(self, limits: BatteryLimits) -> None:
        self.limits = limits
        self.level = BatteryLevel.FINE
        self._below_since: dict[BatteryLevel, float] = {}

    def observe(self, readings: oi.Readings, now: float) -> bool:
        """Take readings in; True when the level has just become worse."""
        if not readings.has('voltage', 'charging_sources'):
            return False
        if readings.voltage is None:
            self._below_since.clear()
            self.level = BatteryLevel.FINE  # nobody knows
            return False
        voltage = inf if readings.charging_sources else readings.voltage * MILLI
        if not self._below_since and voltage > max(self.limits.low, self.limits.empty):
            return False  # as in most frames
        before = self.level
        self.level = BatteryLevel.FINE
        for level, limit in ((BatteryLevel.LOW, self.limits.low),
                             (BatteryLevel.EMPTY, self.limits.empty)):
            if self._stays_below(level, limit, voltage, now):
                self.level = level
        levels = list(BatteryLevel)
        return levels.index(self.level) > levels.index(before)

    def _stays_below(self, level: BatteryLevel, limit: float, voltage: float, now: float) -> bool:
        since = self._below_since.get(level)
        if voltage > limit + (RISE if since is not None else 0.0):
            self._below_since.pop(level, None)
            return False
        return now - self._below_since.setdefault(level, now) >= SETTLE
