"""
From a wanted velocity to wheel speeds that the robot may be sent.

The watchdog lives here too: the Open Interface has no timeout, the last Drive holds for ever.
"""

from dataclasses import dataclass
from math import inf, isfinite

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
    linear_acceleration: float = 0.0
    """m/s2, faster and slower; 0 is no limit. A stop and the end of commands know none."""
    angular_acceleration: float = 0.0
    """rad/s2, likewise."""


UNHEARD = 10 * oi.SLOT
"""Seconds after which the robot should report the speeds that it was sent."""
RAMP_STEP = 2 * oi.SLOT
"""Seconds of acceleration at once, at most: nobody asked between two drives far apart."""
WheelSpeeds = tuple[float, float]
"""Right and left, mm/s."""
STOPPED = (0.0, 0.0)


def wheel_speeds(linear: float, angular: float, limits: MotionLimits) -> WheelSpeeds:
    """
    Return right and left wheel speed in mm/s for m/s forward and rad/s counter-clockwise.

    Too fast a command is slowed down as a whole, both wheels by one factor, so that the curve is
    kept.
    """
    # Reckoned by halves, whose sum a float can hold whatever was asked for.
    half, turn = linear / 2, angular * limits.wheel_separation / 4
    right, left = half + turn, half - turn
    fastest = max(abs(right), abs(left))
    scale = min(1.0, limits.max_wheel_speed / 2 / fastest) if fastest else 1.0
    return right * scale * 2 * MM, left * scale * 2 * MM


def next_speeds(
    before: WheelSpeeds, wanted: WheelSpeeds, seconds: float, limits: MotionLimits,
) -> WheelSpeeds:
    """
    Return what comes after some seconds on the way from one pair of wheel speeds to another.

    Both accelerations are cut by one factor, so that the way is straight: from a stand, the
    curve is the wanted one from the beginning.
    """
    right, left = wanted[0] - before[0], wanted[1] - before[1]
    linear = abs(right + left) / 2 / MM
    angular = abs(right - left) / limits.wheel_separation / MM
    part = 1.0
    for change, limit in ((linear, limits.linear_acceleration),
                          (angular, limits.angular_acceleration)):
        if limit and change:
            part = min(part, limit * seconds / change)
    if part == 1.0:
        return wanted
    return before[0] + part * right, before[1] + part * left


class Motion:
    """The newest command, how long it holds, and what of it the robot knows."""

    def __init__(self, limits: MotionLimits) -> None:
        self.limits = limits
        self._wanted = STOPPED
        self._commanded_at = -inf
        self._speeds = STOPPED
        """Where the acceleration limits have brought the wheels."""
        self._ramped_at = -inf
        self._sent: tuple[int, int] | None = None
        self._sent_at = -inf
        self.missed = 0
        """How many speeds in a row the robot did not take."""

    def command(self, linear: float, angular: float, now: float) -> bool:
        """Take a command in; False when it is not finite, which stops the robot."""
        self._commanded_at = now
        finite = isfinite(linear) and isfinite(angular)
        if finite:
            self._wanted = wheel_speeds(linear, angular, self.limits)
        else:
            self.stop()
        return finite

    def stop(self) -> None:
        """Want the wheels to stand, at once."""
        self._wanted = self._speeds = STOPPED

    @property
    def moving(self) -> bool:
        """Whether wheels are wanted to turn."""
        return self._wanted != STOPPED

    @property
    def at_rest(self) -> bool:
        """Whether the wheels stand, or are to stand at once."""
        return self._wanted == self._speeds == STOPPED

    def expired(self, now: float) -> bool:
        """Tell whether the newest command is too old to hold."""
        return now - self._commanded_at > self.limits.timeout

    def forget(self) -> None:
        """Assume nothing about what the robot's wheels were told last."""
        self._sent = None

    def reported(self, right: int, left: int, now: float) -> None:
        """Note what the robot says it was told, mm/s; what it missed is sent again."""
        if self._sent == (right, left):
            self.missed = 0
        elif self._sent is not None and now - self._sent_at > UNHEARD:
            self.forget()
            self.missed += 1

    def next_drive(self, now: float) -> oi.DriveDirect | None:
        """
        Return the command to send, if the robot must be told something new.

        No more often than the robot listens (one slot), except that a stop never waits.
        """
        if self.expired(now):
            self.stop()
        since = min(now - self._ramped_at, RAMP_STEP)
        self._speeds = next_speeds(self._speeds, self._wanted, since, self.limits)
        self._ramped_at = now
        told = round(self._speeds[0]), round(self._speeds[1])
        if told == self._sent or told != (0, 0) and now - self._sent_at < oi.SLOT:
            return None
        self._sent, self._sent_at = told, now
        return oi.DriveDirect(right=told[0], left=told[1])
