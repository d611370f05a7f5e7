# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What ends a motion: the bumper, a cliff, a wheel that drops, wheels that do not follow."""

from ... import oi
from ..motion import BUMPS, Velocity
from .goal import Code, LEAST_SPEED, Over, View

DROPS = int(oi.BumpsAndWheelDrops.WHEEL_DROP_LEFT | oi.BumpsAndWheelDrops.WHEEL_DROP_RIGHT
            | oi.BumpsAndWheelDrops.WHEEL_DROP_CASTER)
WHEELS = int(oi.Overcurrents.LEFT_WHEEL | oi.Overcurrents.RIGHT_WHEEL)
OVERLOADED = 0.5
"""Seconds for which a wheel must draw too much current to count as held."""
WATCHED, FOLLOWED = 0.15, 0.3
"""Metres of a wheel after which it is compared with what it was told, and the least part of that
which a wheel that is not held travels."""
AT_LEAST = 2.0
"""Seconds over which it is compared at least."""
SIDES = {BUMPS: 'in front', int(oi.BumpsAndWheelDrops.BUMP_LEFT): 'on the left',
         int(oi.BumpsAndWheelDrops.BUMP_RIGHT): 'on the right'}
CLIFFS = {'cliff_left': 'on the left', 'cliff_front_left': 'at the front left',
          'cliff_front_right': 'at the front right', 'cliff_right': 'on the right'}
FROM_CLIFF = 'call set_mode with SAFE, then drive backwards'
"""Advice at a cliff, where the robot leaves Safe by itself."""
AGAIN = 'wait a second, then send the goal again'
TO_FLOOR = f'put the robot on the floor, {AGAIN}'
LIFTED = Over(Code.WHEEL_DROP, f'a wheel hangs in the air: {TO_FLOOR}')
NO_SPEED = Over(
    Code.STALL, 'max_wheel_speed is 0, or too little to turn a wheel: set the parameter to '
    f'{LEAST_SPEED} m/s or more')


def bumps(readings: oi.Readings) -> int:
    """Return the bits of the bumper's halves that are pressed."""
    return int(readings.bumps_and_wheel_drops) & BUMPS


def dropped(readings: oi.Readings) -> bool:
    """Tell whether a wheel hangs in the air."""
    return bool(int(readings.bumps_and_wheel_drops) & DROPS)


def cliffs(readings: oi.Readings) -> list[str]:
    """Return where a cliff is seen."""
    return [where for name, where in CLIFFS.items() if getattr(readings, name)]


class Hazards:
    """
    Watches a motion.

    What is there when the motion begins does not end it while it leads away: backwards, or for the
    bumper in place. Once it has gone and come back, it does.
    """

    def __init__(self, *, bumper: bool = True) -> None:
        """Watch the bumper too, unless bumps are no error for the goal."""
        self._bumper = bumper
        self._known_bump = self._known_cliff = True

    def begin(self, view: View, *, forward: bool, backward: bool) -> Over | None:
        """Return why the motion cannot begin; tell which way it leads, neither for a turn."""
        readings = view.readings
        if dropped(readings):
            return LIFTED
        if forward and self._bumper and bumps(readings):
            return _bump(readings)
        if not backward and cliffs(readings):
            return _cliff(readings)
        return None

    def check(self, view: View, *, forward: bool) -> Over | None:
        """Return what ends the motion in this frame; `forward` says where it leads now."""
        readings = view.readings
        if dropped(readings):
            return LIFTED
        cliff = bool(cliffs(readings))
        self._known_cliff = self._known_cliff and cliff
        if cliff and (forward or not self._known_cliff):
            return _cliff(readings)
        bump = self._bumper and bool(bumps(readings))
        self._known_bump = self._known_bump and bump
        if bump and (forward or not self._known_bump):
            return _bump(readings)
        return None


class Stall:
    """Notices wheels that do not follow what they are told."""

    def __init__(self) -> None:
        self._overloaded = 0.0
        self._restart()

    def _restart(self) -> None:
        self._told = self._went = self._seconds = 0.0

    def check(self, view: View, told: Velocity) -> Over | None:
        """Return what ends the motion; `told` is the velocity since the frame before."""
        readings, dt = view.readings, view.dt
        overloaded = readings.has('overcurrents') and int(readings.overcurrents) & WHEELS
        self._overloaded = self._overloaded + dt if overloaded else 0.0
        if self._overloaded > OVERLOADED:
            return Over(Code.STALL, 'a wheel draws too much current: is it held or blocked?')
        half = view.limits.wheel_separation / 2
        self._told += (abs(told.linear) + abs(told.angular) * half) * dt
        self._went += (abs(view.estimate.linear) + abs(view.estimate.angular) * half) * dt
        self._seconds += dt
        if self._told < WATCHED or self._seconds < AT_LEAST:
            return None
        stalled = self._went < FOLLOWED * self._told
        self._restart()
        if not stalled:
            return None
        return Over(Code.STALL, 'the wheels do not follow: are they held, or is the robot stuck?')


def _bump(readings: oi.Readings) -> Over:
    return Over(Code.BUMP, f'the bumper is pressed {SIDES[bumps(readings)]}: drive backwards or '
                'turn away')


def _cliff(readings: oi.Readings) -> Over:
    return Over(Code.CLIFF, f'there is no floor {", ".join(cliffs(readings))}: {FROM_CLIFF}')
