"""
How fast a script lets the wheels run, as the robot's echoes tell.

The last Drive has its echo in packets 39 and 40, the last Drive Direct in 41 and 42, and neither
tells which of them came last. So a script is followed if it uses only one of them.
"""

from .. import oi
from ..oi.script import commands_of
from ..oi.steering import wheel_speeds
from ..robot import TOP_SPEED
from .motion import MM
from .stream_plan import ECHOES

CLEARED = oi.Drive(velocity=0, radius=oi.Radius.STRAIGHT)
"""Sent before a script plays, for an echo may be left from the one before."""

Speeds = tuple[float, float]
"""Of the right and the left wheel, m/s."""


class Echoes:
    """Reads the speeds of the wheels from the echoes that tell them for one script."""

    def __init__(
        self, script: oi.Script | None, wheel_separation: float, *, cleared: bool,
    ) -> None:
        """Follow this script, if it is known; the separation is in metres."""
        commands = commands_of(script) if script else []
        used: set[type[oi.Command]] = {type(command) for command in commands}
        self._separation = wheel_separation * MM
        self._drive = oi.Drive in used
        mixed = self._drive and oi.DriveDirect in used
        self.tell = cleared and script is not None and not mixed and oi.Script not in used
        """Whether they tell how the wheels run."""
        self.recounts = self.tell and not used.isdisjoint((oi.WaitDistance, oi.WaitAngle))
        """Whether the script sets distance and angle to zero as it waits for them (manual), so
        that they tell less than the echoes. Where these tell nothing, a part is better."""

    def speeds(self, readings: oi.Readings) -> Speeds:
        """Return what the wheels are to do by a frame's echoes."""
        if not self._drive:
            return asked_directly(readings)
        if not readings.has(*ECHOES):
            return 0.0, 0.0
        right, left = wheel_speeds(
            readings.requested_velocity, readings.requested_radius, self._separation)
        return _possible(right), _possible(left)


def asked_directly(readings: oi.Readings) -> Speeds:
    """Return what the last Drive Direct asked for."""
    return readings.requested_right_velocity / MM, readings.requested_left_velocity / MM


def _possible(speed: float) -> float:
    """Return in m/s how fast a wheel runs that is asked to run so many mm/s."""
    return max(-TOP_SPEED, min(TOP_SPEED, speed / MM))
