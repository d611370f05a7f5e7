# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a goal is: it takes every frame, and returns an order for the driver; how far it is and ends.

A goal has no clock and touches nothing. `begin` gets the first view, `step` that and each later
one. The driver carries out what they order, and ends the goal for reasons that are not its own: a
stop, another goal, a lost robot.
"""

from abc import ABC, abstractmethod
from enum import auto, Enum, IntEnum
from math import isfinite, tau
from typing import NamedTuple

from ... import oi
from ...odometry import Estimate
from ...robot import MILLI
from ..events import MotionLimits
from ..motion import Velocity
from ..outbox import Awaited

LONGEST, MOST_TURN = 1000.0, 1000 * tau
"""Metres and radians of one goal at most: the odometry is worth little after that."""
ROUNDING = 1e-6
"""Part by which a float32 may be beyond a limit: it is 0.30000001 for 0.3."""

LEAST_SPEED, LEAST_TURN = MILLI, 0.008
"""m/s and rad/s: the wheels are told whole millimetres per second, so less does not move them."""


class Code(IntEnum):
    """How a goal ended; the numbers are those of `error_code` in the actions."""

    NONE = 0
    """The goal was reached."""
    TIMEOUT = 1
    BUMP = 2
    CLIFF = 3
    WHEEL_DROP = 4
    STALL = 5
    MODE = 6
    NO_ROBOT = 7
    LINK = 8
    NO_DOCK = 9
    SUPERSEDED = 10
    STOPPED = 11
    CANCELED = 12


class Phase(Enum):
    """What a goal of several phases is doing."""

    TURNING_TO_PLACE = auto()
    DRIVING = auto()
    TURNING_TO_HEADING = auto()
    LOOKING = auto()
    SEES_DOCK = auto()
    DOCKED = auto()
    CHARGING = auto()
    SEARCHING = auto()
    ENGAGED = auto()


class Progress(NamedTuple):
    """How far a goal is."""

    distance: float = 0.0
    """Metres that are left, not negative."""
    angle: float = 0.0
    """Radians that are left, not negative."""
    phase: Phase | None = None
    infrared: int = 0
    """Character that the infrared receiver receives; 0 for a goal that does not look."""


class Ending(NamedTuple):
    """How a goal ended."""

    code: Code
    text: str
    """For people: what was done; or why not, and what to do."""
    estimate: Estimate = Estimate()
    """Where the robot was then."""
    seconds: float = 0.0
    """How long the goal ran."""
    docked: bool = False
    """Whether the robot was on the contacts of a Home Base then."""


class Running(Awaited[Ending]):
    """A goal that was given to the driver."""

    def __init__(self) -> None:
        super().__init__()
        self.progress = Progress()

    @property
    def ending(self) -> Ending | None:
        """How it ended; None while it runs."""
        return self.result

    def end(self, ending: Ending) -> None:
        """End the goal."""
        self.settle(ending)


class Malformed(ValueError):
    """A goal that no robot could follow: what is wrong with it, and what is allowed."""


class View(NamedTuple):
    """What a goal knows when a frame has come."""

    now: float
    """Seconds."""
    dt: float
    """Seconds since the view before."""
    estimate: Estimate
    readings: oi.Readings
    """The newest of every packet."""
    measured: bool
    """Whether distance and angle came with this frame."""
    limits: MotionLimits


class Enter(NamedTuple):
    """An order: stand still and enter a mode."""

    mode: oi.Mode
    why: str = ''
    """What to tell the user; empty: nothing."""


class DockDemo(Enum):
    """An order about the demo that finds the Home Base."""

    PLAY = auto()
    GO_ON = auto()


class Over(NamedTuple):
    """An order: the goal is over."""

    code: Code
    text: str


Order = Velocity | Enter | DockDemo | Over
"""A velocity to drive at, or one of the orders above."""


class Goal(ABC):
    """One goal; SI units."""

    needs_driving = True
    """Whether the robot must follow velocities when the goal begins."""
    hint = ''
    """What may be a mistake of whoever sent the goal; it is pursued all the same."""

    def __init__(self, allowance: float) -> None:
        """Take the seconds that the goal may take; 0 leaves that to the goal."""
        check_number('time_allowance', allowance, 's')
        if allowance < 0:
            raise Malformed(f'time_allowance = {allowance:g} s; allowed: 0 or more')
        self.allowance = allowance
        self._allowed = allowance > 0

    @abstractmethod
    def begin(self, view: View) -> Over | None:
        """Start here and now; or say why that is not possible, or not necessary."""

    @abstractmethod
    def step(self, view: View) -> Order:
        """Return what to do until the next frame."""

    @property
    @abstractmethod
    def progress(self) -> Progress:
        """How far the goal is."""

    @property
    def wants_reading(self) -> bool:
        """Whether the robot should be asked soon how far it went."""
        return False

    def way(self, seconds: float) -> str:
        """Say how far the goal has got in so many seconds, as in "stopped after 0.42 m"."""
        return f'after {seconds:.1f} s'

    def timed_out(self) -> Over:
        """Return how the goal ends when its time is over."""
        if self._allowed:
            return Over(Code.TIMEOUT, f'time_allowance of {self.allowance:.1f} s is over: allow '
                        'more time, or a higher speed')
        return Over(Code.TIMEOUT, f'{self.allowance:.1f} s are over, twice what it should take: '
                    'is something in the way, or do the wheels slip?')


def check_number(name: str, value: float, unit: str) -> None:
    """Refuse a value that is no number."""
    if not isfinite(value):
        raise Malformed(f'{name} = {value} {unit} is not finite')


def check_amount(name: str, value: float, most: float, unit: str) -> None:
    """Refuse a distance or an angle that is no number, or too long."""
    check_number(name, value, unit)
    if abs(value) > most * (1 + ROUNDING):
        raise Malformed(f'{name} = {value:g} {unit}; allowed: {-most:g} to {most:g}')


def check_positive(name: str, value: float, unit: str) -> None:
    """Refuse a radius that is not above 0."""
    check_number(name, value, unit)
    if value <= 0:
        raise Malformed(f'{name} = {value:g} {unit}; allowed: above 0')


def check_speed(value: float) -> None:
    """Refuse m/s that are no whole mm/s for the wheels."""
    _check_least('max_translation_speed', value, LEAST_SPEED, 'm/s')


def check_turning(value: float) -> None:
    """Refuse rad/s that are no whole mm/s for the wheels."""
    _check_least('max_rotation_speed', value, LEAST_TURN, 'rad/s')


def _check_least(name: str, value: float, least: float, unit: str) -> None:
    check_number(name, value, unit)
    if value < least:
        raise Malformed(f'{name} = {value:g} {unit}; allowed: {least:g} or more')


def docked(readings: oi.Readings) -> bool:
    """Tell whether the robot is on the contacts of a Home Base; charging or full."""
    return (readings.has('charging_sources')
            and oi.ChargingSources.HOME_BASE in readings.charging_sources)
