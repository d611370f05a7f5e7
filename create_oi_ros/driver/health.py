# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of driver and robot at one moment, for diagnostics and status lines."""

from dataclasses import dataclass

from .. import oi
from ..odometry import Knowledge, Known
from .battery_watch import BatteryLevel
from .events import LinkCounts
from .state import Activity
from .supervision import Cause, ModeStatus


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
