"""What a robot cannot have done: jumps, and turning without its angle ever changing."""

from math import degrees

from .. import oi
from .motion import MM

FASTEST, FASTEST_TURN = 1.0, 450.0
"""m/s and deg/s: twice what the wheels can do, for a robot that is pushed."""
SLACK, TURN_SLACK = 50, 20
"""mm and degrees allowed beyond that, for whole units and late frames."""
TURN_BY = 360.0
"""Degrees of asked-for turning after which the angle should have changed."""


class Jumps:
    """Refuses a distance or an angle that nothing could have made in the time."""

    def __init__(self) -> None:
        self._since: float | None = None

    def restart(self) -> None:
        """Forget when the last reading was: the next spans an unknown time."""
        self._since = None

    def possible(self, readings: oi.Readings, stamp: float) -> bool:
        """Tell whether a reading of distance and angle can be true."""
        elapsed = float('inf') if self._since is None else stamp - self._since
        self._since = stamp
        return (abs(readings.distance) <= FASTEST * elapsed * MM + SLACK
                and abs(readings.angle) <= FASTEST_TURN * elapsed + TURN_SLACK)


class TurnCheck:
    """Notices an angle that never changes though the robot is told to turn."""

    def __init__(self, wheel_separation: float) -> None:
        self._separation = wheel_separation
        self._asked = 0.0
        self.stuck = False
        """Whether the angle should have changed long since."""

    def observe(self, readings: oi.Readings, dt: float) -> bool:
        """Take a frame in, `dt` seconds after the last; True when it has just become stuck."""
        if readings.has('angle') and readings.angle:
            self._asked, self.stuck = 0.0, False
        elif readings.oi_mode in oi.ACTUATE:
            right, left = readings.requested_right_velocity, readings.requested_left_velocity
            self._asked += degrees((right - left) / MM / self._separation) * dt
        before, self.stuck = self.stuck, abs(self._asked) > TURN_BY
        return self.stuck and not before
