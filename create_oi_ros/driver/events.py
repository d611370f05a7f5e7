# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What goes into the driver and comes out: its settings, what it reports, its health.

Settings are fixed before it starts, but for the limits of motion; events are frames, mode changes
and notices; `Health` is all that is known at one moment, for diagnostics and status lines.
"""

from dataclasses import dataclass, field
from enum import Enum, IntEnum
from functools import cached_property
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate, Geometry, GyroSettings, GyroState, Knowledge
from ..oi.codes import START_BAUDS
from ..robot import TOP_SPEED, WHEEL_SEPARATION
from .state import Activity


class LowBatteryAction(Enum):
    """What to do when the battery is nearly empty."""

    NONE = 'none'
    STOP = 'stop'
    DOCK = 'dock'


class BatteryLevel(IntEnum):
    """State of the battery by voltage and charge."""

    FINE = 0
    LOW = 1
    EMPTY = 2


class Charging(Enum):
    """What a charger does; the value is the text for people."""

    NO_CHARGER = 'is on no charger'
    CHARGES = 'charges'
    FULL = 'is full'
    FAILS = 'does not charge'
    UNKNOWN = 'may charge'


@dataclass(frozen=True)
class MotionLimits:
    """Limits on the wheel speeds that are sent."""

    wheel_separation: float = WHEEL_SEPARATION
    """Metres between the wheels' contact points."""
    max_wheel_speed: float = TOP_SPEED
    """m/s for either wheel."""
    timeout: float = 0.5
    """Seconds that a command holds."""
    linear_acceleration: float = 1.0
    """m/s², faster and slower; 0 is no limit. A stop and the watchdog ignore it. Wheels can follow
    the default, so the odometry is right: docs/odometry.md has what else was tried."""
    angular_acceleration: float = 4.0
    """rad/s², likewise."""
    bump_stop: bool = False
    """Whether a pressed bumper lets no command drive forward."""
    commands_interrupt: bool = True
    """Whether a velocity command ends a goal that runs; else it is ignored meanwhile."""


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
    """Seconds, about, between readings of distance and angle."""
    battery_low: float = 13.5
    """V of the whole battery below which it is low."""
    battery_empty: float = 12.5
    """V below which it is nearly empty."""
    charge_known: bool = True
    """Whether packets 25 and 26 tell the charge; not with the alkaline pack."""
    low_battery_action: LowBatteryAction = LowBatteryAction.NONE
    """What to do then."""
    limits: MotionLimits = field(default_factory=MotionLimits)
    geometry: Geometry = field(default_factory=Geometry)
    dock_pose: tuple[float, float, float] | None = None
    """x, y and yaw of a robot on its dock in the odometry frame, m and rad; None: not known."""
    robot: Knowledge | None = None
    """What is known of this robot; None: the odometry learns everything."""
    gyro: GyroSettings | None = None
    """The gyro on the analog input; None: there is none."""
    output_names: tuple[str, ...] = ('output_0', 'output_1', 'output_2')
    """Names of the digital outputs 0, 1 and 2."""


NO_ROBOT = 'no robot answers'
"""Why the mode is not known, as a rule."""


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

    @property
    def described(self) -> str:
        """The name of the mode, and why the robot is in it, for people."""
        return f'{self.name} ({self.reason})' if self.reason else self.name


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
    dt: float = oi.SLOT
    """The robot's seconds since the last one."""
    brought: oi.Readings = oi.Readings()
    """What this frame brought; None is what cannot be true."""
    lost: bool = False
    """Whether a distance and an angle before it, or in it, may have been lost."""


DriverEvent = Notice | Moved | ModeStatus
"""A `ModeStatus` is an event when it has changed."""


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
    robot: Knowledge | None
    """What the odometry has learned of this robot; None before it has learned anything."""
    gyro: GyroState | None
    """What is thought of the gyro; None: there is none."""
    battery: BatteryLevel
    charging: Charging
    songs: tuple[int, ...]
    """Numbers of the songs that are stored."""
