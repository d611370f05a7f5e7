# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Reports a low battery, and does what the user chose for one that is nearly empty."""

from .. import oi
from ..robot import MILLI
from .battery_watch import BatteryLevel, BatteryLimits, BatteryWatch, LowBatteryAction
from .demos import Demos
from .events import EventQueue, Severity
from .modes import Modes

DOES = {LowBatteryAction.DOCK: 'looks for its dock',
        LowBatteryAction.STOP: 'stops and stays in Passive'}
"""What the robot does, in the words of a notice."""


class BatteryGuard:
    """Acts on the battery's level."""

    def __init__(
        self, limits: BatteryLimits, demos: Demos, modes: Modes, events: EventQueue,
    ) -> None:
        self._watch = BatteryWatch(limits)
        self._action = limits.action
        self._demos = demos
        self._modes = modes
        self._events = events
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
            self._events.notice(
                Severity.WARNING, f'battery {self.level.value} ({volts:.1f} V): charge it')
            self._due, self._refusal = self._action is not LowBatteryAction.NONE, ''
        if self._due and self.level is BatteryLevel.EMPTY:
            self._act(now)

    def _act(self, now: float) -> None:
        """Do what the user chose; where the robot refuses it, say so once and try again."""
        outcome = (self._demos.start(oi.DemoNumber.COVER_AND_DOCK)
                   if self._action is LowBatteryAction.DOCK else self._modes.rest(now)).outcome
        does = f'battery {self.level.value}: the robot {DOES[self._action]}'
        if outcome is None or outcome.ok:
            self._due = False
            self._events.notice(
                Severity.ERROR, f'{does}, as low_battery_action says; charge it')
        elif outcome.text != self._refusal:
            self._refusal = outcome.text
            self._events.notice(
                Severity.ERROR, f'{does} as soon as it can ({outcome.text}); charge it')
