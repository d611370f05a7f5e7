"""What the driver tells of: what happened, and how the line is."""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate
from .supervision import ModeStatus


class Severity(Enum):
    """How loud a notice is."""

    INFO = 'info'
    WARNING = 'warning'
    ERROR = 'error'


class Notice(NamedTuple):
    """Something a person should read, said once."""

    severity: Severity
    text: str


class Moved(NamedTuple):
    """A frame was taken in."""

    stamp: float
    """When the frame left the robot, in the clock of `now`."""
    readings: oi.Readings
    """The newest of every packet that has arrived so far."""
    estimate: Estimate


class ModeChanged(NamedTuple):
    """The robot's mode, the wanted one, or why they differ is another than before."""

    status: ModeStatus


DriverEvent = Notice | Moved | ModeChanged


class Link(Enum):
    """State of the line to the robot."""

    CLOSED = 'port closed'
    WAKING = 'no answer yet'
    UP = 'robot answers'


@dataclass
class LinkCounts:
    """What has come over the line since the driver was made."""

    frames: int = 0
    checksum_failures: int = 0
    garbage_bytes: int = 0
    implausible_frames: int = 0
    impossible_jumps: int = 0
    silences: int = 0
