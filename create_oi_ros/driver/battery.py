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
from .events import BatteryLevel, LowBatteryAction, Severity
from .mode import docked, Modes
from .state import StateEvent

LEVEL_DELAY = 5.0
"""Seconds that the voltage must stay below a limit: motors that start pull it down."""
HYSTERESIS = 0.3
"""Volts above a limit at which the battery counts as better again."""
DOES = {LowBatteryAction.DOCK: 'looks for its dock',
        LowBatteryAction.STOP: 'stops and stays in Passive'}
"""What the robot does, in the words of a notice."""
CHARGE_WAIT = 5.0
"""Seconds on the dock, in Passive, in which the current should begin."""
RESET = bytes([7])
"""Restarts the robot. The manual does not list this opcode."""
NO_CURRENT = (oi.ChargingState.NOT_CHARGING, oi.ChargingState.FAULT)
"""States on a charger in which the battery is not charged though it is not full."""


def charges(readings: oi.Readings) -> bool:
    """Tell whether the battery is being charged, or full, on a charger; False if not known."""
    return readings.charging_state not in (None, *NO_CURRENT)


class BatteryGuard:
    """Reports the battery's level when it gets worse, and acts when it is nearly empty."""

    def __init__(self, core: Core, modes: Modes) -> None:
        self._core = core
        self._modes = modes
        self.level = BatteryLevel.FINE
        """State of the battery by its voltage."""
        self._below_since: dict[BatteryLevel, float] = {}
        self._action_due = False
        """Whether the action for an empty battery has still to be taken."""
        self._refusal = ''
        """Why the robot refused it last."""

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Take readings in; when the level has just become worse, report it and act."""
        if not readings.has('voltage', 'charging_sources'):
            return
        levels, before = list(BatteryLevel), self.level
        self.level = self._find_level(readings, now)
        if levels.index(self.level) > levels.index(before):
            volts = readings.number('voltage', 0) * MILLI
            self._core.notice(
                Severity.WARNING, f'battery {self.level.value} ({volts:.1f} V): charge it')
            self._action_due = self._core.settings.low_battery_action is not LowBatteryAction.NONE
            self._refusal = ''
        if self._action_due and self.level is BatteryLevel.EMPTY:
            self._act(now)

    def _find_level(self, readings: oi.Readings, now: float) -> BatteryLevel:
        """Return the level, with a delay and a hysteresis."""
        if readings.voltage is None:
            self._below_since.clear()
            return BatteryLevel.FINE  # nobody knows
        voltage = inf if readings.charging_sources else readings.voltage * MILLI
        found = BatteryLevel.FINE
        settings = self._core.settings
        for level, limit in ((BatteryLevel.LOW, settings.battery_low),
                             (BatteryLevel.EMPTY, settings.battery_empty)):
            if voltage > limit + (HYSTERESIS if level in self._below_since else 0.0):
                self._below_since.pop(level, None)
            elif now - self._below_since.setdefault(level, now) >= LEVEL_DELAY:
                found = level
        return found

    def _act(self, now: float) -> None:
        """Do what the user chose; where the robot refuses it, say so once and try again."""
        action = self._core.settings.low_battery_action
        outcome = (self._modes.start_demo(oi.DemoNumber.COVER_AND_DOCK)
                   if action is LowBatteryAction.DOCK else
                   self._modes.set(oi.Mode.PASSIVE, now, StateEvent.RESTED)).outcome
        does = f'battery {self.level.value}: the robot {DOES[action]}'
        if outcome is None or outcome.ok:
            self._action_due = False
            self._core.notice(Severity.ERROR, f'{does}, as low_battery_action says; charge it')
        elif outcome.text != self._refusal:
            self._refusal = outcome.text
            self._core.notice(
                Severity.ERROR, f'{does} as soon as it can ({outcome.text}); charge it')


class ChargeWatch:
    """Reports a robot that does not charge on its dock, and restarts it once."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self._since: float | None = None
        """Since when the robot waits for the current; None where it does not."""
        self._was_reset = False
        self._told = ''
        """What the user was told last, since the robot is on its dock."""

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Take readings in, and act when the robot has waited for too long."""
        status = self._core.status
        if not docked(readings) or not readings.has('charging_state'):
            self._since, self._was_reset, self._told = None, False, ''
        elif (readings.charging_state not in NO_CURRENT
                or not status.actual is status.wanted is oi.Mode.PASSIVE):
            self._since = None
        elif self._since is None:
            self._since = now
        elif now - self._since >= CHARGE_WAIT:
            self._act(readings)

    def _act(self, readings: oi.Readings) -> None:
        state = oi.ChargingState(readings.number('charging_state', 0)).name
        advice = ('even after a restart: are the contacts clean, is the battery in?'
                  if self._was_reset else
                  'clean the contacts, or set reset_when_not_charging, which restarts it')
        if self._core.settings.reset_when_not_charging and not self._was_reset:
            self._was_reset, self._since = True, None
            advice = 'restarting it (opcode 7)'
            self._core.outbox.send_raw(RESET)
        says = f'the robot is on its dock and does not charge (state {state}): {advice}'
        if says != self._told:
            self._told = says
            self._core.notice(Severity.WARNING, says)
