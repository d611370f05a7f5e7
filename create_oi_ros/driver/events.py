# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What goes into the driver and comes out: its settings, what it reports, its health.

Settings are fixed before it starts; events are frames, mode changes and notices; `Health` is all
that is known at one moment, for diagnostics and status lines.
"""

from collections import deque
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate, Geometry, Knowledge, Known
from ..oi.codes import START_BAUDS
from .motion import MotionLimits
from .state import Activity
from .supervision import Cause, ModeStatus


class LowBatteryAction(Enum):
    """What to do when the battery is nearly empty."""

    NONE = 'none'
    STOP = 'stop'
    DOCK = 'dock'


class BatteryLevel(Enum):
    """State of the battery by its voltage."""

    FINE = 'fine'
    LOW = 'low'
    EMPTY = 'nearly empty'


@dataclass(frozen=True)
class BatteryLimits:
    """Voltages of the whole battery, V, and what to do below the lower one."""

    low: float = 13.5
    empty: float = 12.5
    action: LowBatteryAction = LowBatteryAction.NONE


@dataclass(frozen=True)
class Settings:
    """Settings in SI units."""

    baud: int = START_BAUDS[0]
    """Bits per second; 0 searches for the robot's rate."""
    mode_on_start: oi.Mode = oi.Mode.SAFE
    mode_on_exit: oi.Mode = oi.Mode.PASSIVE
    recover_mode: bool = True
    """Whether a fresh velocity command brings back a mode that a hazard ended."""
    reset_when_not_charging: bool = False
    """Whether a robot that does not charge on its dock is restarted."""
    odometry_window: float = 1.0
    """Seconds between readings of distance and angle; 0 reads them in every frame."""
    battery: BatteryLimits = field(default_factory=BatteryLimits)
    limits: MotionLimits = field(default_factory=MotionLimits)
    geometry: Geometry = field(default_factory=Geometry)
    dock_pose: tuple[float, float, float] | None = None
    """x, y and yaw of a robot on its dock in the odometry frame, m and rad; None: not known."""
    robot: Knowledge | None = None
    """What is known of this robot; None: the odometry learns everything."""


class Severity(Enum):
    """How serious a notice is."""

    INFO = 'info'
    WARNING = 'warning'
    ERROR = 'error'


class Notice(NamedTuple):
    """Something a person should read, reported once."""

    severity: Severity
    text: str


class Moved(NamedTuple):
    """A frame was taken in."""

    stamp: float
    """When the frame left the robot, in the clock of `now`."""
    readings: oi.Readings
    """The newest value of every packet that has arrived so far."""
    estimate: Estimate


class ModeChanged(NamedTuple):
    """The robot's mode, the wanted one, or the reason why they differ has changed."""

    status: ModeStatus


DriverEvent = Notice | Moved | ModeChanged


class EventQueue(deque[DriverEvent]):
    """Events on their way to whoever uses the driver, oldest first."""

    def notice(self, severity: Severity, text: str) -> None:
        """Append a notice."""
        self.append(Notice(severity, text))


@dataclass
class LinkCounts:
    """What has come over the line since the driver was made."""

    frames: int = 0
    checksum_failures: int = 0
    garbage_bytes: int = 0
    implausible_frames: int = 0
    odd_values: int = 0
    """Values that no Create should have, in frames that were taken nevertheless."""
    impossible_jumps: int = 0
    silences: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Health:
    """What is known now. Nothing in it changes afterwards."""

    activity: Activity
    answered: bool
    """Whether the robot answers."""
    busy: str | None
    """Why the robot takes no commands now, and what to do; None where it takes them."""
    mode: ModeStatus
    hazards: tuple[Cause, ...]
    """What would take the robot out of Safe mode now."""
    readings: oi.Readings
    """The newest value of every packet that has arrived so far."""
    odd: dict[str, int]
    """Values that no Create should have, by packet, in the newest frames."""
    counts: LinkCounts
    line_problem: str | None
    """What is wrong with port or line; None while nothing is."""
    frame_age: float | None
    """Seconds since the last frame; None before the first."""
    spare_bytes: int
    """Bytes that still fit into a frame."""
    checksum: oi.Checksum | None
    """The checksum convention of the robot, once it is known."""
    ignores_commands: bool
    """Whether the robot ignores commands, stop included."""
    suspects_commands: bool
    """Whether it may ignore commands: it shows no sign that it takes them."""
    angle_stuck: bool
    """Whether the angle does not change though the robot is told to turn."""
    frame_period: Known
    """Seconds between two frames."""
    robot: Knowledge | None
    """What the odometry has learned of this robot; None before it has learned anything."""
    battery: BatteryLevel
    songs: tuple[int, ...]
    """Numbers of the songs that are stored."""
