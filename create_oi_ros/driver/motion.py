# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""From a commanded velocity to the wheel speeds that are sent to the robot."""

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from .. import oi
from ..oi.steering import WheelSpeeds
from ..robot import MM_PER_M, SLOT, TOP_SPEED, WHEEL_SEPARATION
from .outbox import HALT


class Velocity(NamedTuple):
    """How fast the robot is to drive and turn."""

    linear: float = 0.0
    """m/s, forward."""
    angular: float = 0.0
    """rad/s, counter-clockwise."""


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


REPORT_TIMEOUT = 10 * SLOT
"""Seconds after which the robot should report the speeds that it was sent."""
RAMP_STEP = 2 * SLOT
"""Most seconds of acceleration between two commands, however far apart they are."""
IN_PLACE = 1e-6
"""mm/s of the mean below which the robot turns in place."""
STOPPED = WheelSpeeds(0.0, 0.0)


def wheel_speeds(linear: float, angular: float, limits: MotionLimits) -> WheelSpeeds:
    """
    Return right and left wheel speed in mm/s for m/s forward and rad/s counter-clockwise.

    A command that is too fast is slowed down, both wheels by one factor: the curve stays the same.
    """
    # Calculated by halves: their sum fits into a float whatever was commanded.
    half, turn = linear / 2, angular * limits.wheel_separation / 4
    right, left = half + turn, half - turn
    fastest = max(abs(right), abs(left))
    scale = min(1.0, limits.max_wheel_speed / 2 / fastest) if fastest else 1.0
    return WheelSpeeds(right * scale * 2 * MM_PER_M, left * scale * 2 * MM_PER_M)


def next_speeds(
    before: WheelSpeeds, wanted: WheelSpeeds, seconds: float, limits: MotionLimits,
) -> WheelSpeeds:
    """
    Return the wheel speeds some seconds later, on the way from one pair of speeds to another.

    Both accelerations are reduced by one factor: a robot that starts from rest follows the
    commanded curve at once.
    """
    right, left = wanted.right - before.right, wanted.left - before.left
    linear = abs(right + left) / 2 / MM_PER_M
    angular = abs(right - left) / limits.wheel_separation / MM_PER_M
    fraction = 1.0
    for change, limit in ((linear, limits.linear_acceleration),
                          (angular, limits.angular_acceleration)):
        if limit and change:
            fraction = min(fraction, limit * seconds / change)
    if fraction == 1.0:
        return wanted
    return WheelSpeeds(before.right + fraction * right, before.left + fraction * left)


def rounded(speeds: WheelSpeeds) -> tuple[int, int]:
    """
    Return whole mm/s for right and left wheel, such that the robot turns as it should.

    Their difference is rounded first (0.5 mm/s off at most), then their mean. Wheels that turn in
    place stay symmetric, so that it does not creep.
    """
    mean, difference = (speeds.right + speeds.left) / 2, speeds.right - speeds.left
    if abs(mean) < IN_PLACE:
        half = round(difference / 2)
        return half, -half
    difference = round(difference)
    right = round(mean + difference / 2)
    return right, right - difference


def without_forward(speeds: WheelSpeeds) -> WheelSpeeds:
    """Return wheel speeds that turn as these do, but do not drive forward."""
    forward = max(0.0, (speeds.right + speeds.left) / 2)
    return WheelSpeeds(speeds.right - forward, speeds.left - forward)


class WheelCommands:
    """The newest velocity command, and the wheel speeds that were sent to follow it."""

    def __init__(self, limits: MotionLimits) -> None:
        self.limits = limits
        self._wanted = STOPPED
        self._commanded_at = -inf
        self._speeds = STOPPED
        """Wheel speeds that the acceleration limits have allowed so far."""
        self._ramped_at = -inf
        self._sent: tuple[int, int] | None = None
        self._rounded: WheelSpeeds | None = None
        """What `_sent` was rounded from; None where it must be sent again."""
        self._sent_at = -inf
        self._taken: tuple[int, int] | None = None
        """What the robot reports."""
        self.blocked = False
        """Whether the bumper is pressed."""
        self.missed_since: float | None = None
        """When the first of the speeds was sent that the robot has not taken; None: none was."""
        self.held = False
        """Whether the robot may not obey: then only a stop is sent, and once."""

    def command(self, linear: float, angular: float, now: float) -> bool:
        """Take a command, m/s and rad/s; True when it asks for motion."""
        self._commanded_at = now
        self._wanted = wheel_speeds(linear, angular, self.limits)
        return self._wanted != STOPPED

    def stop(self) -> None:
        """Want the wheels to stand, at once."""
        self._wanted = self._speeds = STOPPED

    @property
    def at_rest(self) -> bool:
        """Whether the wheels stand, or are to stand at once."""
        return self._wanted == self._speeds == STOPPED

    def expired(self, now: float) -> bool:
        """Tell whether the newest command is too old to hold."""
        return now > self._commanded_at + self.limits.timeout

    def forget_sent(self) -> None:
        """Forget which speeds were sent last, so that they are sent again."""
        if not self.held:
            self._sent = self._rounded = None

    def hold(self, held: bool) -> None:
        """Hold speeds back, or send them again, on from those that the robot reports."""
        if self.held and not held:
            self._speeds = WheelSpeeds(*(self._taken or STOPPED))
            self.missed_since = None
        self.held = held
        self.forget_sent()

    @property
    def stop_sent(self) -> bool:
        """Whether a stop was sent last."""
        return self._sent == (0, 0)

    def reported(self, right: int, left: int, now: float) -> None:
        """
        Note the requested speeds that the robot reports, mm/s; what it missed is sent again.

        A robot that stopped without being told, for somebody pressed a button or another program
        did it, starts from rest. While speeds are held back, only a change shows that it obeys.
        """
        changed, self._taken = (right, left) != self._taken, (right, left)
        if self._sent == self._taken:
            if changed or not self.held:
                self.missed_since = None
        elif self._sent is not None and now - self._sent_at > REPORT_TIMEOUT:
            if self.missed_since is None:
                self.missed_since = self._sent_at
                if self._taken == (0, 0):
                    self._speeds = STOPPED
            self.forget_sent()

    def next_drive(self, now: float) -> oi.DriveDirect | None:
        """
        Return the command to send, if the robot must be told something new.

        At most one a slot, since the robot takes no more; but a stop never waits.
        """
        since, self._ramped_at = min(now - self._ramped_at, RAMP_STEP), now
        blocked = self.blocked and self.limits.bump_stop
        if self.held:
            if self.stop_sent or not blocked and self._wanted != STOPPED:
                return None
            self._sent, self._sent_at = (0, 0), now
            return HALT
        if self._wanted == self._speeds == self._rounded and not blocked:
            return None  # as in most frames
        self._speeds = next_speeds(self._speeds, self._wanted, since, self.limits)
        if blocked:
            self._speeds = without_forward(self._speeds)
        # While they change, an error lasts a slot: each wheel follows its own ramp.
        speeds = (rounded(self._speeds) if self._speeds == self._wanted else
                  (round(self._speeds.right), round(self._speeds.left)))
        if speeds != (0, 0) and speeds != self._sent and now - self._sent_at < SLOT:
            return None
        before, self._sent, self._rounded = self._sent, speeds, self._speeds
        if speeds == before:
            return None
        self._sent_at = now
        return oi.DriveDirect(right=speeds[0], left=speeds[1])
