# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The wanted mode and the actual one: why the robot left it, and when the driver may enter it again.

In Safe mode the robot itself falls to Passive on a cliff, a wheel drop or a powered charger
(manual: Safe Mode). `Supervision` notices, names the cause, and decides when a fresh command may
bring the wanted mode back.
"""

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from math import inf

from .. import oi

CLEAR_FOR = 1.0
"""Seconds that the cause must have been gone before the wanted mode may be entered again."""
RETRY_INTERVAL, MOST_TRIES = 0.2, 3
"""Seconds after which a mode should have been entered, and how often it is tried."""
SETTLING = 2.0
"""Seconds after the robot was found, or a mode was asked for, in which frames from before may
still come on a busy computer."""
MODE_COMMANDS = {oi.Mode.PASSIVE: oi.Start, oi.Mode.SAFE: oi.Safe, oi.Mode.FULL: oi.Full}
LEFT_DROP, RIGHT_DROP, CASTER_DROP = map(int, (
    oi.BumpsAndWheelDrops.WHEEL_DROP_LEFT, oi.BumpsAndWheelDrops.WHEEL_DROP_RIGHT,
    oi.BumpsAndWheelDrops.WHEEL_DROP_CASTER))

NO_ROBOT = 'no robot answers'
"""Why the mode is not known, as a rule."""
HOME_BASE = int(oi.ChargingSources.HOME_BASE)


class Cause(Enum):
    """What takes the robot out of Safe mode."""

    CLIFF_LEFT = 'cliff left'
    CLIFF_FRONT_LEFT = 'cliff front left'
    CLIFF_FRONT_RIGHT = 'cliff front right'
    CLIFF_RIGHT = 'cliff right'
    WHEEL_DROP_LEFT = 'left wheel dropped'
    WHEEL_DROP_RIGHT = 'right wheel dropped'
    WHEEL_DROP_CASTER = 'caster dropped'
    CHARGER = 'charger powered'
    POWER = 'robot was switched off'
    MODE_UNKNOWN = 'it reports a mode that the manual does not have'
    UNKNOWN = 'unknown cause'


HAZARD_FIELDS = (
    'bumps_and_wheel_drops', 'cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right')
hazard_numbers = oi.Readings.numbers(*HAZARD_FIELDS)


def causes_in(readings: oi.Readings) -> tuple[Cause, ...]:
    """Name what in these readings would take the robot out of Safe mode."""
    hazards, sources = hazard_numbers(readings), _sources(readings)
    if not sources and not any(hazards):
        return ()  # as in nearly all frames
    drops, left, front_left, front_right, right = hazards
    seen = (
        (Cause.CLIFF_LEFT, left), (Cause.CLIFF_FRONT_LEFT, front_left),
        (Cause.CLIFF_FRONT_RIGHT, front_right), (Cause.CLIFF_RIGHT, right),
        (Cause.WHEEL_DROP_LEFT, drops & LEFT_DROP), (Cause.WHEEL_DROP_RIGHT, drops & RIGHT_DROP),
        (Cause.WHEEL_DROP_CASTER, drops & CASTER_DROP), (Cause.CHARGER, sources))
    return tuple(cause for cause, present in seen if present)


def _sources(readings: oi.Readings) -> int:
    """Return the chargers that the robot sees, as bits; 0 while it has not said."""
    return readings.number('charging_sources', 0)


@dataclass(frozen=True)
class ModeStatus:
    """
    What is known of the robot's mode.

    `actual` is None while there is no robot, and where it reports a mode that does not exist:
    then the cause is MODE_UNKNOWN.
    """

    actual: oi.Mode | None
    wanted: oi.Mode
    causes: tuple[Cause, ...] = ()

    @cached_property
    def can_drive(self) -> bool:
        """Whether the robot follows velocities in its mode."""
        return self.actual in oi.DriveDirect.modes

    @cached_property
    def unknown(self) -> bool:
        """Whether the robot reports a mode that does not exist: it must stop, as if it drove."""
        return Cause.MODE_UNKNOWN in self.causes

    @property
    def reason(self) -> str:
        """Why the robot is not in the wanted mode, for people; empty where it is."""
        if self.actual is None and not self.causes:
            return NO_ROBOT
        return ', '.join(cause.value for cause in self.causes)

    @property
    def name(self) -> str:
        """The name of the mode, for people."""
        return 'no known mode' if self.actual is None else self.actual.name


class Supervision:
    """Watches the mode frame by frame."""

    def __init__(self, wanted: oi.Mode, *, recover: bool) -> None:
        self.recover = recover
        self.status = ModeStatus(None, wanted)
        self._before: tuple[Cause, ...] = ()
        self._cause_seen_at = -inf
        self._tries = 0
        self._entered_at = self._asked_at = -inf
        self.docked = False
        """Whether the robot was on the contacts of a Home Base in the newest frame."""

    def want(self, mode: oi.Mode) -> None:
        """Change the wanted mode; why the robot left the last one no longer matters."""
        causes = self.status.causes if self.status.actual is None else ()
        self.status = ModeStatus(self.status.actual, mode, causes)
        self._tries = 0

    def lost(self) -> None:
        """Note that no robot answers."""
        self.status = ModeStatus(None, self.status.wanted)
        self._tries = 0

    def entering(self, now: float) -> None:
        """Note that the wanted mode is being entered."""
        if self._tries == 0:
            self._asked_at = now
        self._tries += 1
        self._entered_at = now

    @property
    def is_entering(self) -> bool:
        """Whether the wanted mode was commanded and may still come: nothing has kept it away."""
        return 0 < self._tries and not self.status.causes

    def must_enter_again(self, now: float) -> bool:
        """Tell whether the robot seems to have missed the command to enter the wanted mode."""
        status = self.status
        if status.actual in (None, status.wanted) or now - self._entered_at <= RETRY_INTERVAL:
            return False
        # Full instead of Safe, or Safe instead of Full: no safety stop, but a damaged command.
        damaged = status.actual in oi.ACTUATE and status.wanted in oi.ACTUATE
        return damaged or not status.causes and 0 < self._tries < MOST_TRIES

    def observe(self, readings: oi.Readings, now: float) -> bool:
        """Take a frame's readings in; True when the robot has just left the wanted mode."""
        present = causes_in(readings)
        self.docked = bool(_sources(readings) & HOME_BASE)
        if present:
            self._cause_seen_at = now
        before, actual = self.status, readings.oi_mode
        left = before.actual == before.wanted != actual
        # Without a cause it may only seem so: a frame from before the mode was entered came late.
        dropped = left and (bool(present) or now - self._asked_at > SETTLING)
        dropped |= actual is None and (left or before.can_drive)
        causes = before.causes
        if actual is None:
            causes = (Cause.MODE_UNKNOWN,)
        elif dropped:
            causes = present or self._before or (
                (Cause.POWER,) if actual is oi.Mode.OFF else (Cause.UNKNOWN,))
        elif actual == before.wanted:
            causes, self._tries = (), 0
        elif left:
            self._tries = 1
        elif before.unknown or self._refused(present, now):
            causes = present or (Cause.UNKNOWN,)
        self._before = present
        if (actual, causes) != (before.actual, before.causes):
            self.status = ModeStatus(actual, before.wanted, causes)
        return dropped

    def _refused(self, present: tuple[Cause, ...], now: float) -> bool:
        """Tell whether the robot will not enter the wanted mode, however often it is told to."""
        return (not self.status.causes and 0 < self._tries
                and now - self._entered_at > RETRY_INTERVAL
                and (bool(present) or self._tries >= MOST_TRIES))

    def may_recover(self, now: float) -> bool:
        """Tell whether a fresh non-zero command may bring the wanted mode back."""
        status = self.status
        return (
            self.recover and bool(status.causes)
            and status.actual is not None and status.actual != status.wanted
            and now - self._cause_seen_at >= CLEAR_FOR)
