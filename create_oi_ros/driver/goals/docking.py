# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Goals about the Home Base.

The robot finds it by itself, with the demo Cover and Dock, in Passive. Two things are reported of
real robots there: docked in Safe one may not move until it is full, and one in Passive may not
begin to charge.
"""

from ... import oi
from ...oi.codes import BEAMS
from ..battery import charges
from ..events import Cause, MotionLimits
from ..motion import Velocity
from .approach import Learned
from .goal import (
    Code,
    DockDemo,
    docked,
    Enter,
    Goal,
    LEAST_SPEED,
    Order,
    Over,
    Phase,
    Progress,
    View,
)
from .hazards import dropped, Hazards, LIFTED, NO_SPEED, Stall
from .legs import Straight

SEARCH = 240.0
"""Seconds in which the Home Base must be found."""
CHARGE_WAIT = 4.0
"""Seconds on the contacts in which the current should begin."""
AWAY, SPEED = 0.3, 0.1
"""Metres and m/s by which a robot leaves its dock."""
HELD, MODE_WAIT = 1.5, 0.6
"""Seconds in Safe after which a docked robot that has not left counts as held, and in which a
mode should be entered."""


class Dock(Goal):
    """Find the Home Base and charge there."""

    needs_driving = False

    def __init__(self, allowance: float) -> None:
        """Take seconds; 0: as long as a search may take."""
        super().__init__(allowance)
        self.allowance = self.allowance or SEARCH
        self._progress = Progress()
        self._seen = False
        self._contact = 0.0
        """Seconds on the contacts."""
        self._begun = False

    def begin(self, view: View) -> Over | None:
        """Start, unless a wheel hangs in the air."""
        return LIFTED if dropped(view.readings) else None

    def step(self, view: View) -> Order:
        """Let the demo run until the robot charges."""
        readings = view.readings
        self._look(readings)
        if readings.oi_mode is None:
            return Over(Code.MODE, f'{Cause.MODE_UNKNOWN.value}: switch the robot off and on')
        if dropped(readings):
            return LIFTED
        if docked(readings):
            return self._on_contacts(view)
        self._contact = 0.0
        order = DockDemo.GO_ON if self._begun else DockDemo.PLAY
        self._begun = True
        return order

    def _on_contacts(self, view: View) -> Order:
        readings = view.readings
        if readings.oi_mode is not oi.Mode.PASSIVE:
            return Enter(oi.Mode.PASSIVE)
        self._contact += view.dt
        if charges(readings):
            full = readings.charging_state in (oi.ChargingState.TRICKLE, oi.ChargingState.WAITING)
            return Over(Code.NONE, f'docked; the battery {"is full" if full else "charges"}')
        if self._contact > CHARGE_WAIT:
            unknown = readings.charging_state is None
            return Over(Code.NONE, 'docked; whether the battery charges is not known' if unknown
                        else 'docked, but the battery does not charge: see the log')
        return DockDemo.GO_ON

    def _look(self, readings: oi.Readings) -> None:
        seen = readings.infrared if readings.has('infrared') else 0
        sees = BEAMS < seen < oi.Infrared.NONE
        self._seen = self._seen or sees
        phase = Phase.SEES_DOCK if sees else Phase.LOOKING
        if docked(readings):
            phase = Phase.CHARGING if charges(readings) else Phase.DOCKED
        self._progress = Progress(phase=phase, infrared=seen if sees else BEAMS)

    @property
    def progress(self) -> Progress:
        """Whether the dock is seen, and which of its beams."""
        return self._progress

    def timed_out(self) -> Over:
        """Return how the goal ends when its time is over."""
        if self._seen:
            return Over(Code.TIMEOUT, 'the Home Base was seen, but not reached in '
                        f'{self.allowance:.0f} s: free the way to it, or allow more time')
        return Over(Code.NO_DOCK, f'no beam of a Home Base was seen in {self.allowance:.0f} s: is '
                    'it plugged in, is the way to it free?')


class Undock(Goal):
    """Leave the Home Base backwards: in Safe, or in Full where Safe does not let the robot go."""

    needs_driving = False

    def __init__(self, allowance: float, learned: Learned) -> None:
        """Take seconds; 0: twice what it should take."""
        super().__init__(allowance)
        self._learned = learned
        self._leg: Straight | None = None
        self._hazards, self._stall = Hazards(), Stall()
        self._told = Velocity()
        self._mode = oi.Mode.SAFE
        self._tried = 0.0
        """Seconds since the mode was ordered."""
        self._ordered: oi.Mode | None = None
        self._by_full = False

    def begin(self, view: View) -> Over | None:
        """Start, unless the robot is on no dock."""
        if not docked(view.readings):
            return Over(Code.NO_DOCK, 'the robot is on no dock: there is nothing to leave')
        limits = view.limits
        if limits.max_wheel_speed < LEAST_SPEED:
            return NO_SPEED
        if view.readings.oi_mode is oi.Mode.FULL:
            self._mode = oi.Mode.FULL
        self._leg = self._way(view)
        self.allowance = self.allowance or 2 * (self._leg.seconds() + HELD + 2 * MODE_WAIT)
        return self._hazards.begin(view, forward=False, backward=True)

    def step(self, view: View) -> Order:
        """Enter a mode that lets the robot go, and drive backwards."""
        if docked(view.readings):
            self._hazards = Hazards()  # the dock may press the bumper, and let it go, and press it
        over = self._hazards.check(view, forward=False)
        if over is not None:
            return over
        if self._by_full and self._mode is oi.Mode.FULL and not docked(view.readings):
            self._mode = oi.Mode.SAFE
        if view.readings.oi_mode is not self._mode:
            return self._wait_for_mode(view)
        self._tried += view.dt
        if self._ordered is not None:
            self._ordered, self._tried = None, 0.0
        held = docked(view.readings) and self._tried > HELD
        if held and self._mode is oi.Mode.SAFE:
            return self._go_by_full(view, 'docked in SAFE the robot does not move')
        return self._drive(view)

    def _wait_for_mode(self, view: View) -> Order:
        self._told = Velocity()
        if self._ordered is not self._mode:
            self._ordered, self._tried = self._mode, 0.0
            return Enter(self._mode)
        self._tried += view.dt
        if self._tried < MODE_WAIT:
            return Velocity()
        if docked(view.readings) and self._mode is oi.Mode.SAFE:
            return self._go_by_full(view, 'docked, the robot does not stay in SAFE')
        return Over(Code.MODE, f'the robot does not enter {self._mode.name}: send the goal again, '
                    'or pull it off its dock')

    def _go_by_full(self, view: View, why: str) -> Order:
        self._by_full = True
        self._mode = self._ordered = oi.Mode.FULL
        self._tried = 0.0
        self._leg, self._stall = self._way(view), Stall()
        return Enter(oi.Mode.FULL, f'{why}: it leaves the dock in FULL, then returns to SAFE')

    def _drive(self, view: View) -> Order:
        assert self._leg is not None
        over = self._stall.check(view, self._told)
        if over is not None and (self._mode is oi.Mode.FULL or not docked(view.readings)):
            return over
        velocity = self._leg.step(view)
        if velocity is not None:
            self._told = velocity
            return velocity
        by = ', by FULL, now in SAFE again' if self._by_full else ''
        if docked(view.readings):
            return Over(Code.STALL, 'the robot still feels the contacts of its dock: if it takes '
                        'the dock along, lift it off')
        return Over(Code.NONE, f'left the dock{by}')

    def _way(self, view: View) -> Straight:
        limits: MotionLimits = view.limits
        return Straight(view.estimate, -AWAY, view.estimate.yaw, SPEED, self._learned, limits)

    @property
    def progress(self) -> Progress:
        """How far the robot still has to go."""
        return Progress(distance=AWAY if self._leg is None else abs(self._leg.distance))

    def way(self, seconds: float) -> str:
        """Say how far the robot has gone."""
        return f'after {AWAY - self.progress.distance:.2f} m'
