# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Notices a robot that stands on its dock and does not charge, and restarts it if it may.

Passive, entered on the dock, is reported not always to begin to charge; a restart (opcode 7) does.
"""

from .. import oi
from .events import EventQueue, Severity
from .outbox import Outbox
from .supervision import Supervision

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

    def __init__(self, supervision: Supervision, outbox: Outbox, events: EventQueue, *,
                 reset: bool) -> None:
        self._supervision = supervision
        self._outbox = outbox
        self._events = events
        self._reset = reset
        self._since: float | None = None
        self._was_reset = self._reported = False

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Take readings in; report a robot that does not charge, and restart it once."""
        status = self._supervision.status
        if not self._supervision.docked or not readings.has('charging_state'):
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
            self._events.notice(Severity.WARNING, f'{says}: restarting it (opcode 7)')
            self._outbox.send_raw(RESET)
        elif not self._reported:
            self._reported = True
            advice = ('even after a restart: are the contacts clean, is the battery in?'
                      if self._was_reset else 'clean the contacts, or set '
                      'reset_when_not_charging, which restarts it')
            self._events.notice(Severity.WARNING, f'{says}: {advice}')
