# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The battery's level by its voltage, what the user chose for one that is nearly empty, and charging.

Passive, entered on the dock, is reported not always to begin to charge; a restart (opcode 7) does.
"""

from math import inf

from .. import oi
from ..robot import MILLI
from .core import Core
from .events import BatteryLevel, BatteryLimits, LowBatteryAction, Severity
from .mode import Modes

SETTLE = 5.0
"""Seconds that the voltage must stay below a limit: motors that start pull it down."""
RISE = 0.3
"""Volts above a limit at which the battery counts as better again."""


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


DOES = {LowBatteryAction.DOCK: 'looks for its dock',
        LowBatteryAction.STOP: 'stops and stays in Passive'}
"""What the robot does, in the words of a notice."""


class BatteryGuard:
    """Acts on the battery's level."""

    def __init__(self, core: Core, modes: Modes) -> None:
        self._core = core
        self._watch = BatteryWatch(core.settings.battery)
        self._action = core.settings.battery.action
        self._modes = modes
        self._due = False
        """Whether the action for an empty battery has still to be taken."""
        self._refusal = ''

    @property
    def level(self) -> BatteryLevel:
        """State of the battery by its voltage."""
        return self._watch.level

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Take readings in; when the level has just become worse, report it and act."""
        if self._watch.observe(readings, now):
            volts = readings.number('voltage', 0) * MILLI
            self._core.notice(
                Severity.WARNING, f'battery {self.level.value} ({volts:.1f} V): charge it')
            self._due, self._refusal = self._action is not LowBatteryAction.NONE, ''
        if self._due and self.level is BatteryLevel.EMPTY:
            self._act(now)

    def _act(self, now: float) -> None:
        """Do what the user chose; where the robot refuses it, say so once and try again."""
        outcome = (self._modes.start_demo(oi.DemoNumber.COVER_AND_DOCK)
                   if self._action is LowBatteryAction.DOCK else self._modes.rest(now)).outcome
        does = f'battery {self.level.value}: the robot {DOES[self._action]}'
        if outcome is None or outcome.ok:
            self._due = False
            self._core.notice(
                Severity.ERROR, f'{does}, as low_battery_action says; charge it')
        elif outcome.text != self._refusal:
            self._refusal = outcome.text
            self._core.notice(
                Severity.ERROR, f'{does} as soon as it can ({outcome.text}); charge it')


WAIT = 5.0
"""Seconds on the dock, in Passive, in which the current should begin."""
RESET = bytes([7])
"""Restarts the robot. The manual does not list this opcode."""
NO_CURRENT = (oi.ChargingState.NOT_CHARGING, oi.ChargingState.FAULT)
"""States on a charger in which the battery is not charged though it is not full."""


def charges(readings: oi.Readings) -> bool:
    """Tell whether the battery is being charged, or full, on a charger; False if not known."""
    return readings.charging_state not in (None, *NO_CURRENT)


class ChargeWatch:
    """Watches the charging state frame by frame."""

    def __init__(self, core: Core, modes: Modes) -> None:
        self._core = core
        self._modes = modes
        self._reset = core.settings.reset_when_not_charging
        self._since: float | None = None
        self._was_reset = self._reported = False

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Take readings in; report a robot that does not charge, and restart it once."""
        status = self._core.status
        if not self._modes.docked or not readings.has('charging_state'):
            self._since, self._was_reset, self._reported = None, False, False
            return
        waits = readings.charging_state in NO_CURRENT
        if not waits or not status.actual is status.wanted is oi.Mode.PASSIVE:
            self._since = None
            return
        if self._since is None:
            self._since = now
        if now - self._since >= WAIT:
            self._act(readings)

    def _act(self, readings: oi.Readings) -> None:
        state = oi.ChargingState(readings.number('charging_state', 0)).name
        says = f'the robot is on its dock and does not charge (state {state})'
        if self._reset and not self._was_reset:
            self._was_reset, self._since = True, None
            self._core.notice(Severity.WARNING, f'{says}: restarting it (opcode 7)')
            self._core.outbox.send_raw(RESET)
        elif not self._reported:
            self._reported = True
            advice = ('even after a restart: are the contacts clean, is the battery in?'
                      if self._was_reset else 'clean the contacts, or set '
                      'reset_when_not_charging, which restarts it')
            self._core.notice(Severity.WARNING, f'{says}: {advice}')
