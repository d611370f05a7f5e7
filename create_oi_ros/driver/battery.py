# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The battery, judged in one place: its level, whether it is charged, and what the driver does.

The voltage falls while motors start, and rises while the battery is charged. The charge (packets
25 and 26) means nothing with the alkaline pack. Whether a charger charges is told by the current:
robots that wait on their dock (state 4) are reported to run flat there.

Passive, entered on the dock, is reported not always to begin to charge; a restart (opcode 7) does.
"""

from math import inf, isnan, nan

from .. import oi
from ..robot import MILLI, MOST_CHARGE
from .core import Core
from .events import BatteryLevel, Charging, LowBatteryAction, Severity
from .mode import docked, Modes
from .state import Activity, StateEvent

LEVEL_DELAY = 5.0
"""Seconds that the voltage must stay below a limit: motors that start pull it down."""
VOLTAGE_HYSTERESIS, CHARGE_HYSTERESIS = 0.3, 0.02
"""Volts, and fraction of the capacity, above a limit at which the battery counts as better."""
CHARGE_LIMITS = {BatteryLevel.LOW: 0.2, BatteryLevel.EMPTY: 0.05}
"""Fractions of the capacity below which the battery must be charged soon, or now."""
FULL_CHARGE = 0.9
"""Fraction of the capacity from which on a charger that waits has filled the battery (guess)."""
WORDS = {BatteryLevel.LOW: 'low', BatteryLevel.EMPTY: 'nearly empty'}
"""The levels that are reported, for people."""
DOES = {LowBatteryAction.DOCK: 'looks for its dock',
        LowBatteryAction.STOP: 'stops and stays in Passive'}
"""What the robot does, in the words of a notice; on its dock it only enters Passive."""
CHARGE_WAIT = 5.0
"""Seconds on the dock in which the current should begin."""
RESET = bytes([7])
"""Restarts the robot. The manual does not list this opcode."""
GIVES = (oi.ChargingState.RECONDITIONING, oi.ChargingState.FULL_CHARGING,
         oi.ChargingState.TRICKLE)
"""States in which a charger gives a current, where that itself is not known."""


def charge_fraction(readings: oi.Readings) -> float:
    """Return the charge over the capacity, 0 to 1; NaN where it is not known."""
    charge = readings.number('battery_charge', -1)
    capacity = readings.number('battery_capacity', 0)
    known = capacity and 0 <= charge <= MOST_CHARGE * capacity
    return min(charge / capacity, 1.0) if known else nan


def charging(readings: oi.Readings) -> Charging:
    """Tell what a charger does, if there is one."""
    if not readings.number('charging_sources', 0):
        return Charging.NO_CHARGER
    state, current = (getattr(readings, name) if readings.has(name) else None
                      for name in ('charging_state', 'current'))
    if state is oi.ChargingState.FAULT:
        return Charging.FAILS
    if state is None and current is None:
        return Charging.UNKNOWN
    waits = state in (oi.ChargingState.TRICKLE, oi.ChargingState.WAITING)
    if waits and charge_fraction(readings) >= FULL_CHARGE:
        return Charging.FULL
    gives = state in GIVES if current is None else current > 0
    return Charging.CHARGES if gives else Charging.FAILS


def charges(readings: oi.Readings) -> bool:
    """Tell whether a charger charges the battery, or has filled it."""
    return charging(readings) in (Charging.CHARGES, Charging.FULL)


class Battery:
    """Reports a battery that gets worse, or is not charged on the dock; acts when it is empty."""

    def __init__(self, core: Core, modes: Modes) -> None:
        self._core = core
        self._modes = modes
        self.level = BatteryLevel.FINE
        self._below_since: dict[BatteryLevel, float] = {}
        """Since when the voltage has been below the limit of a level."""
        self._action_due = False
        """Whether the action for an empty battery has still to be taken."""
        self._refusal = ''
        """Why the robot refused it last."""
        self._waits: tuple[float, oi.Mode | None] | None = None
        """Since when, and in which mode, the robot waits for the current on its dock."""
        self._was_reset = False
        self._told = ''
        """What the user was told last, since the robot is on its dock."""

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Take readings in; report what has become worse, and act."""
        if not readings.has('voltage', 'charging_sources'):
            return
        before, self.level = self.level, self._find_level(readings, now)
        if self.level > before:
            self._core.notice(
                Severity.WARNING,
                f'battery {WORDS[self.level]} ({_described(readings)}): charge it')
            self._action_due = self._core.settings.low_battery_action is not LowBatteryAction.NONE
            self._refusal = ''
        if self._action_due and self.level is BatteryLevel.EMPTY:
            self._act(now)
        self._watch_charger(readings, now)

    def _find_level(self, readings: oi.Readings, now: float) -> BatteryLevel:
        """Return the level by voltage, with a delay, and by charge; a charged battery is fine."""
        settings = self._core.settings
        if charges(readings):
            self._below_since.clear()
            return BatteryLevel.FINE
        volts = inf if readings.voltage is None else readings.voltage * MILLI
        charge = charge_fraction(readings) if settings.charge_known else nan
        found = BatteryLevel.FINE
        for level, limit in ((BatteryLevel.LOW, settings.battery_low),
                             (BatteryLevel.EMPTY, settings.battery_empty)):
            if volts > limit + (VOLTAGE_HYSTERESIS if level in self._below_since else 0.0):
                self._below_since.pop(level, None)
            elif now - self._below_since.setdefault(level, now) >= LEVEL_DELAY:
                found = level
            if charge < CHARGE_LIMITS[level] + CHARGE_HYSTERESIS * (self.level >= level):
                found = level
        return found

    def _act(self, now: float) -> None:
        """Do what the user chose; where the robot refuses it, say so once and try again."""
        action = self._core.settings.low_battery_action
        does = 'enters Passive on its dock' if docked(self._core.readings) else DOES[action]
        outcome = (self._modes.start_demo(oi.DemoNumber.COVER_AND_DOCK)
                   if does == DOES[LowBatteryAction.DOCK] else
                   self._modes.set(oi.Mode.PASSIVE, now, StateEvent.RESTED)).outcome
        text = f'battery {WORDS[self.level]}: the robot {does}'
        if outcome is None or outcome.ok:
            self._action_due = False
            self._core.notice(Severity.ERROR, f'{text}, as low_battery_action says; charge it')
        elif outcome.text != self._refusal:
            self._refusal = outcome.text
            self._core.notice(
                Severity.ERROR, f'{text} as soon as it can ({outcome.text}); charge it')

    # On the dock.

    def _watch_charger(self, readings: oi.Readings, now: float) -> None:
        """Report a robot that does not charge on its dock, and restart it once."""
        mode = self._core.status.actual
        if not docked(readings):
            self._was_reset, self._told = False, ''
        if (not docked(readings) or charging(readings) is not Charging.FAILS
                or self._core.state.activity is Activity.GOAL
                or not self._core.listening.may_send):
            self._waits = None
        elif self._waits is None or self._waits[1] is not mode:
            self._waits = now, mode
        elif now - self._waits[0] >= CHARGE_WAIT:
            self._report_charger(readings)

    def _report_charger(self, readings: oi.Readings) -> None:
        status = self._core.status
        if status.can_drive:
            advice = f', for it is in {status.name}: call set_mode with PASSIVE'
        elif not status.actual is status.wanted is oi.Mode.PASSIVE:
            return
        elif self._was_reset:
            advice = ' even after a restart: are the contacts clean, is the battery in, is it hot?'
        elif self._core.settings.reset_when_not_charging:
            self._was_reset, self._waits = True, None
            advice = ': restarting it (opcode 7)'
            self._core.outbox.send_raw(RESET)
        else:
            advice = ': clean the contacts, or set reset_when_not_charging, which restarts it'
        if advice != self._told:
            self._told = advice
            state = oi.ChargingState(readings.number('charging_state', 0)).name
            self._core.notice(Severity.WARNING, (
                f'the robot is on its dock and does not charge (state {state}){advice}'))


def _described(readings: oi.Readings) -> str:
    """Say what is known of the battery: volts, charge."""
    known, charge = [], charge_fraction(readings)
    if readings.voltage is not None:
        known.append(f'{readings.voltage * MILLI:.1f} V')
    if not isnan(charge):
        known.append(f'charge {charge:.0%}')
    return ', '.join(known)
