# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Goals about the Home Base.

The robot finds it by itself, with the demo Cover and Dock, in Passive. Two things are reported of
real robots there: docked in Safe one may not move until it is full, and one in Passive may not
begin to charge.
"""

from collections.abc import Iterator

from ... import oi
from ...oi.codes import BEAMS
from ..battery import charges, charging
from ..events import Cause, Charging
from ..mode import docked
from ..motion import Velocity
from .goal import Code, Enter, Goal, Instruction, Order, Over, Phase, Progress
from .legs import Leg, STRAIGHT
from .motions import dropped, Legs, LIFTED, MotionGoal, Stall

SEARCH_TIME = 240.0
"""Seconds in which the Home Base must be found."""
CHARGE_WAIT = 4.0
"""Seconds on the contacts in which the current should begin."""
AWAY, SPEED = 0.3, 0.1
"""Metres and m/s by which a robot leaves its dock."""
HELD_TIME, MODE_WAIT = 1.5, 0.6
"""Seconds in Safe after which a docked robot that has not left counts as held, and in which a
mode should be entered."""


class Dock(Goal):
    """Find the Home Base and charge there."""

    needs_driving = False
    leaves_in = oi.Mode.PASSIVE

    def __init__(self, allowance: float) -> None:
        """Take seconds; 0: as long as a search may take."""
        super().__init__(allowance)
        self.allowance = self.allowance or SEARCH_TIME
        self._seen = False
        """Whether a beam of the dock was seen."""

    def hazard(self) -> Over | None:
        """Look for the dock; return what ends the search."""
        readings = self.view.readings
        beams = readings.infrared if readings.has('infrared') else 0
        sees = BEAMS < beams < oi.Infrared.NONE
        self._seen = self._seen or sees
        phase = Phase.SEES_DOCK if sees else Phase.LOOKING
        if docked(readings):
            phase = Phase.CHARGING if charges(readings) else Phase.DOCKED
        self.progress = Progress(phase=phase, infrared=beams if sees else BEAMS)
        if readings.oi_mode is None:
            return Over(Code.MODE, f'{Cause.MODE_UNKNOWN.value}: switch the robot off and on')
        return LIFTED if dropped(readings) else None

    def orders(self) -> Iterator[Order]:
        """Let the demo run until the robot charges."""
        yield from self._charge()
        yield Instruction.SEEK_DOCK
        while True:
            yield from self._charge()
            yield Instruction.GO_ON

    def _charge(self) -> Iterator[Order]:
        """Wait on the contacts until the robot charges; end when they are lost."""
        seconds = 0.0
        while docked(readings := self.view.readings):
            if readings.oi_mode is not oi.Mode.PASSIVE:
                yield Enter(oi.Mode.PASSIVE)
                continue
            seconds += self.view.dt
            does = charging(readings)
            if charges(readings):
                yield Over(Code.NONE, f'docked; the battery {does.value}')
            if seconds > CHARGE_WAIT:
                yield Over(Code.NONE, f'docked, but the battery {does.value}: see the log'
                           if does is Charging.FAILS else
                           'docked; whether the battery charges is not known')
            yield Instruction.GO_ON

    def timed_out(self) -> Over:
        if self._seen:
            return Over(Code.TIMEOUT, 'the Home Base was seen, but not reached in '
                        f'{self.allowance:.0f} s: free the way to it, or allow more time')
        return Over(Code.NO_DOCK, f'no beam of a Home Base was seen in {self.allowance:.0f} s: is '
                    'it plugged in, is the way to it free?')


class Undock(MotionGoal):
    """Leave the Home Base backwards: in Safe, or in Full where Safe does not let the robot go."""

    needs_driving = False

    def __init__(self, allowance: float) -> None:
        """Take seconds; 0: twice what it should take."""
        super().__init__(allowance, -1, speed=SPEED)
        self._by = ''

    def hazard(self) -> Over | None:
        if self._docked:  # the dock may press the bumper, and let it go, and press it
            self.known_cliff = self.known_bump = True
        if self._docked and self._mode is not oi.Mode.FULL:
            self.stall = Stall()  # Safe may hold the robot
        if self.begun_at is None and not self._docked:
            return Over(Code.NO_DOCK, 'the robot is on no dock: there is nothing to leave')
        return super().hazard()

    def orders(self) -> Iterator[Order]:
        """Drive back; where Safe holds the robot, leave the dock in Full, and return to Safe."""
        self._measure()
        self.allowance = self.allowance or 2 * (self.leg.seconds() + HELD_TIME + 2 * MODE_WAIT)
        mode = first = oi.Mode.FULL if self._mode is oi.Mode.FULL else oi.Mode.SAFE
        driven = waited = 0.0
        why = ''
        while True:
            if self._docked and mode is oi.Mode.SAFE and (
                    driven > HELD_TIME or waited >= MODE_WAIT):
                held = ('docked, the robot does not stay in SAFE' if waited >= MODE_WAIT else
                        'docked in SAFE the robot does not move')
                why = f'{held}: it leaves the dock in FULL, then returns to SAFE'
                mode, driven, waited = oi.Mode.FULL, 0.0, 0.0
                self._measure()  # while it is held the odometry may believe that it moves
                self._by = ', by FULL, now in SAFE again'
            elif mode is not first and not self._docked:
                mode, driven, waited = first, 0.0, 0.0
            if self._mode is mode:
                yield self._step()
                driven, waited = driven + self.view.dt, 0.0
            elif waited < MODE_WAIT:
                yield Velocity() if waited else Enter(mode, why)
                waited, why = waited + self.view.dt, ''
            else:
                yield Over(Code.MODE, f'the robot does not enter {mode.name}: send the goal '
                           'again, or pull it off its dock')

    def legs(self) -> Legs:
        yield None, Leg(self.view, STRAIGHT, -AWAY, self.speed)

    def _measure(self) -> None:
        """Begin the way here."""
        (_, self.leg), = self.legs()
        self.progress = self.leg.progress()

    def _step(self) -> Order:
        order = self.leg.step(self.view)
        self.progress = self.leg.progress()
        if order is not None:
            return order
        if self._docked:
            return Over(Code.STALL, 'the robot still feels the contacts of its dock: if it takes '
                        'the dock along, lift it off')
        return Over(Code.NONE, f'left the dock{self._by}')

    @property
    def _docked(self) -> bool:
        return docked(self.view.readings)

    @property
    def _mode(self) -> oi.Mode | None:
        return self.view.readings.oi_mode
