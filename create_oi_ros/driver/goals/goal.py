# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a goal is: it takes every frame, and returns an order for the driver.

A goal has no clock and touches nothing. What it does reads from top to bottom in its generator
`orders`, which runs on with each frame's view. The driver carries out the orders, and ends the
goal for reasons that are not its own: a stop, another goal, a lost robot.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from enum import auto, Enum, IntEnum
from math import inf, isfinite, tau
from typing import NamedTuple

from ... import oi
from ...odometry import Estimate
from ...robot import MILLI
from ..events import MotionLimits
from ..motion import Velocity
from ..outbox import Pending

MAX_DISTANCE, MAX_ANGLE = 1000.0, 1000 * tau
"""Metres and radians of one goal at most: the odometry is worth little after that."""
ROUNDING = 1e-6
"""Part by which a float32 may be beyond a limit: it is 0.30000001 for 0.3."""

MIN_SPEED, MIN_TURN_RATE = MILLI, 0.008
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


class Progress(NamedTuple):
    """How far a goal is."""

    distance: float = 0.0
    """Metres that are left, not negative."""
    angle: float = 0.0
    """Radians that are left, not negative."""
    phase: Phase | None = None
    infrared: int = 0
    """Character that the infrared receiver receives; 0 for a goal that does not look."""


COAST, COAST_SPREAD = 0.35, 0.12
"""Coast, s, that is assumed before it is learned, and its standard deviation. It is longer than
that of most robots, so that they stop short."""
MIN_COAST, MAX_COAST = 0.03, 0.8
COAST_DRIFT, COAST_NOISE = 0.02, 0.002
"""Seconds by which the coast differs from stop to stop, and metres by which one is measured
wrongly."""


class StoppingModel:
    """How far one robot travels on after a stop; each stop teaches the next."""

    def __init__(self) -> None:
        self.coast = COAST
        """Seconds of its speed that the robot travels on after a stop."""
        self._variance = COAST_SPREAD ** 2

    def stopped(self, pace: float, way: float) -> None:
        """Learn from a stop at a pace, m/s, after which the robot still travelled a way, m."""
        self._variance += COAST_DRIFT ** 2
        gain = self._variance / (self._variance + (COAST_NOISE / pace) ** 2)
        coast = max(MIN_COAST, min(MAX_COAST, way / pace))
        self.coast += gain * (coast - self.coast)
        self._variance *= 1 - gain


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
    lost: bool
    """Whether some from before it may have been lost."""
    limits: MotionLimits
    straight: StoppingModel
    """How the robot coasts when it drives straight."""
    turning: StoppingModel
    """How it coasts when it turns."""


class Enter(NamedTuple):
    """An order: stand still and enter a mode."""

    mode: oi.Mode
    why: str = ''
    """What to tell the user; empty: nothing."""


class Instruction(Enum):
    """An order without a value."""

    SEEK_DOCK = auto()
    """Let the robot play the demo that finds the Home Base."""
    GO_ON = auto()
    """Let the robot do what it does."""
    MEASURE = auto()
    """Stand still, and ask soon how far the robot went."""


class Over(NamedTuple):
    """An order: the goal is over."""

    code: Code
    text: str


Order = Velocity | Enter | Instruction | Over
"""A velocity to drive at, or one of the orders above."""


class Goal(Pending, ABC):
    """One goal, pursued once; SI units."""

    needs_driving = True
    """Whether the robot must follow velocities when the goal begins."""
    leaves_in: oi.Mode | None = None
    """The mode in which the robot stays when the goal was reached; None: in which it is then."""
    hint = ''
    """What may be a mistake of whoever sent the goal; it is pursued all the same."""

    def __init__(self, allowance: float) -> None:
        """Take the seconds that the goal may take; 0 leaves that to the goal."""
        super().__init__()
        check_range('time_allowance', allowance, 's', 0.0)
        self.allowance = allowance
        self._allowed = allowance > 0
        self.begun_at: float | None = None
        """When the robot was in its mode and the goal began; None before."""
        self.progress = Progress()
        """How far the goal is."""
        self.code = Code.NONE
        """How it ended, as a number."""
        self.estimate = Estimate()
        """Where the robot was then."""
        self.docked = False
        """Whether the robot was on the contacts of a Home Base then."""
        self.view: View
        """The newest view; before the goal begins, that from when it was given to the driver."""
        self._orders = self.orders()

    def step(self, view: View) -> Order:
        """Return what to do until the next frame; the first view begins the goal."""
        self.view = view
        return self.hazard() or next(self._orders)

    @abstractmethod
    def hazard(self) -> Over | None:
        """Return what ends the goal in this view; None where it begins or goes on."""

    @abstractmethod
    def orders(self) -> Iterator[Order]:
        """Yield an order for each view, the last of which is `Over`."""

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


def check_finite(name: str, value: float, unit: str) -> None:
    """Refuse a value that is no number."""
    if not isfinite(value):
        raise ValueError(f'{name} = {value} {unit} is not finite')


def check_range(name: str, value: float, unit: str, least: float, most: float = inf) -> None:
    """Refuse a value that is no number, or beyond its limits."""
    check_finite(name, value, unit)
    if not least - ROUNDING * abs(least) <= value <= most * (1 + ROUNDING):
        allowed = f'{least:g} or more' if most == inf else f'{least:g} to {most:g}'
        raise ValueError(f'{name} = {value:g} {unit}; allowed: {allowed}')
