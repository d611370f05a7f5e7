# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a goal is, and how it ends."""

from enum import auto, Enum, IntEnum
from typing import NamedTuple

from ...odometry import Estimate
from ..outbox import Awaited


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
