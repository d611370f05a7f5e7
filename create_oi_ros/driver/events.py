# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the driver reports: frames, mode changes, notices, and counts of the line."""

from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate
from .supervision import ModeStatus


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
