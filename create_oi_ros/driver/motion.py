"""
From a wanted velocity to wheel speeds that the robot may be sent.

The watchdog lives here too: the Open Interface has no timeout, the last Drive holds for ever.
"""

from dataclasses import dataclass
from math import isfinite

from .. import oi

MM = 1000
"""Millimetres in a metre."""


@dataclass(frozen=True)
class MotionLimits:
    """What may be asked of the wheels."""

    wheel_separation: float = 0.258
    """Metres between the wheels' contact points."""
    max_wheel_speed: float = 0.5
    """m/s for either wheel."""
    timeout: float = 0.5
    """Seconds that a command holds."""


def wheel_speeds(linear: float, angular: float, limits: MotionLimits) -> tuple[int, int]:
    """
    Return right and left wheel speed in mm/s for m/s forward and rad/s counter-clockwise.

    Too fast a command is slowed down as a whole, both wheels by one factor, so that the curve is
    kept.
    """
    turn = angular * limits.wheel_separation / 2
    right, left = linear + turn, linear - turn
    fastest = max(abs(right), abs(left))
    scale = min(1.0, limits.max_wheel_speed / fastest) if fastest else 1.0
    return round(right * scale * MM), round(left * scale * MM)


STOPPED = (0, 0)


class Motion:
    """The newest command, how long it holds, and what of it the robot knows."""

    def __init__(self, limits: MotionLimits) -> None:
        self.limits = limits
        self._wanted = STOPPED
        self._commanded_at = -float('inf')
        self._sent: tuple[int, int] | None = None
        self._sent_at = -float('inf')

    def command(self, linear: float, angular: float, now: float) -> bool:
        """Take a command in; False when it is not finite, which stops the robot."""
        self._commanded_at = now
        finite = isfinite(linear) and isfinite(angular)
        self._wanted = wheel_speeds(linear, angular, self.limits) if finite else STOPPED
        return finite

    def stop(self) -> None:
        """Want the wheels to stand."""
        self._wanted = STOPPED

    @property
    def moving(self) -> bool:
        """Whether wheels are wanted to turn."""
        return self._wanted != STOPPED

    def expired(self, now: float) -> bool:
        """Tell whether the newest command is too old to hold."""
        return now - self._commanded_at > self.limits.timeout

    def forget(self) -> None:
        """Assume nothing about what the robot's wheels were told last."""
        self._sent = None

    def next_drive(self, now: float) -> oi.DriveDirect | None:
        """
        Return the command to send, if the robot must be told something new.

        No more often than the robot listens (one slot), except that a stop never waits.
        """
        if self.expired(now):
            self._wanted = STOPPED
        if self._wanted == self._sent:
            return None
        if self._wanted != STOPPED and now - self._sent_at < oi.SLOT:
            return None
        self._sent, self._sent_at = self._wanted, now
        right, left = self._wanted
        return oi.DriveDirect(right=right, left=left)
