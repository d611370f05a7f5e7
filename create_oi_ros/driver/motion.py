# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
From a commanded velocity to the wheel speeds that are sent to the robot.

The Open Interface has no timeout: the robot keeps the last speeds for ever. So a velocity command
holds only for `MotionLimits.timeout`. Then the wheels stop.
"""

from math import inf, isfinite
from typing import NamedTuple

from .. import oi
from ..oi.commands import WheelSpeeds
from ..robot import MM_PER_M, SLOT
from .core import Core
from .events import MotionLimits, Severity
from .mode import Modes, PAUSE
from .outbox import HALT
from .state import Activity, StateEvent
from .stream import requested_speeds

REPORT_TIMEOUT = 10 * SLOT
"""Seconds after which the robot should report the speeds that it was sent."""
RAMP_STEP = 2 * SLOT
"""Most seconds of acceleration between two commands, however far apart they are."""
IN_PLACE = 1e-6
"""mm/s of the mean below which the robot turns in place."""
STOPPED = WheelSpeeds(0.0, 0.0)
BUMPS = int(oi.BumpsAndWheelDrops.BUMP_LEFT | oi.BumpsAndWheelDrops.BUMP_RIGHT)
AWAY = 'the robot was away, or in another mode, while commands went on'
MIN_SENSIBLE_SPEED = 1e-300
"""Speed, m/s or rad/s, below which no sender means what it sends, unless it is 0: the bits of a
whole 1 are 5e-324. What senders round is larger."""


class Velocity(NamedTuple):
    """How fast the robot is to drive and turn."""

    linear: float = 0.0
    """m/s, forward."""
    angular: float = 0.0
    """rad/s, counter-clockwise."""


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
    place stay symmetric, so that it does not creep (their difference is 1 mm/s off at most).
    """
    mean, difference = (speeds.right + speeds.left) / 2, speeds.right - speeds.left
    if abs(mean) < IN_PLACE:
        half = round(difference / 2)
        return half, -half
    difference = round(difference)
    right = round(mean + difference / 2)
    return right, right - difference


class Motion:
    """Follows the newest velocity: decides whether the robot may, and sends the wheel speeds."""

    def __init__(self, core: Core, modes: Modes) -> None:
        self._core = core
        self._modes = modes
        self._wanted = STOPPED
        """Wheel speeds of the newest velocity."""
        self._commanded_at = -inf
        self._speeds = STOPPED
        """Wheel speeds that the acceleration limits have allowed so far."""
        self._ramped_at = -inf
        self._sent: tuple[int, int] | None = None
        """What was sent last; None where it must be sent again."""
        self._sent_at = -inf
        self._reported: tuple[int, int] | None = None
        """What the robot reports."""
        self.missed_since: float | None = None
        """When the first of the speeds was sent that the robot has not taken; None: none was."""
        self._refusal_reported = self._tiny_reported = self._not_finite = False

    # Velocity commands.

    def command(self, linear: float, angular: float, now: float) -> None:
        """Follow a command, m/s and rad/s, until the next one or the timeout; or say why not."""
        if not (isfinite(linear) and isfinite(angular)):
            self.stop()
            linear = angular = 0.0
        state = self._core.state
        if not self.follow(linear, angular, now):
            if state.activity is Activity.HOLDING:
                self._core.handle(StateEvent.HALTED)
        elif not state.answered:
            self.stop()
        elif why := self._refusal(now):
            self.stop()
            if state.activity is Activity.DRIVING:
                self._core.handle(StateEvent.HALTED)
            if not self._refusal_reported:  # the first of some in a row
                self._refusal_reported = True
                self._core.notice(Severity.WARNING, f'not driving: {why}')
        else:
            self._refusal_reported = False
            self._core.handle(StateEvent.VELOCITY)
        self._send_speeds(now)

    def _refusal(self, now: float) -> str | None:
        """Say why a command is not followed, and what to do; None where it is."""
        if self._core.state.drive_refusal is not None:
            return self._core.state.drive_refusal
        if self._core.state.activity is not Activity.HOLDING:
            why = self._modes.allow_driving(now)
            return None if why is None else f'{why}; {self._modes.advice()}'
        if self._core.status.causes:
            return f'{self._modes.wrong_mode()}; {self._modes.advice()}'
        return f'{AWAY}; {PAUSE}, or call set_mode with SAFE'

    def check_numbers(self, linear: float, angular: float) -> bool:
        """Tell whether a command is finite; report the first of several that are not, or tiny."""
        if not (isfinite(linear) and isfinite(angular)):
            if not self._not_finite:
                self._not_finite = True
                does = 'ignored, since a goal runs' if self._core.state.pursues else 'stopped'
                self._core.notice(
                    Severity.WARNING, f'velocity ({linear} m/s, {angular} rad/s) is not finite: '
                    f'{does}; send finite numbers, and -1.0, not -1')
            return False
        self._not_finite = False
        for speed in linear, angular:
            if 0 < abs(speed) < MIN_SENSIBLE_SPEED and not self._tiny_reported:
                self._tiny_reported = True
                self._core.notice(
                    Severity.WARNING, f'cmd_vel asks for a speed of {speed:.3g}, which moves '
                    'nothing: did the sender write 1 for 1.0?')
        return True

    def poll(self, now: float) -> None:
        """Stop the wheels when the newest command is too old; send speeds that have changed."""
        if (now > self._commanded_at + self._core.limits.timeout
                and self._core.state.activity in (Activity.HOLDING, Activity.DRIVING)):
            self._core.handle(StateEvent.HALTED)
        self._send_speeds(now)

    # The wheels.

    def follow(self, linear: float, angular: float, now: float) -> bool:
        """Want a velocity, m/s and rad/s; True when it asks for motion."""
        self._commanded_at = now
        self._wanted = wheel_speeds(linear, angular, self._core.limits)
        return self._wanted != STOPPED

    def stop(self) -> None:
        """Want the wheels to stand, at once."""
        self._wanted = self._speeds = STOPPED

    def resume(self) -> None:
        """
        Send speeds again: the robot may have missed some, so on from those that it reports.

        The newest may be on their way yet. Wheels that were told to stand do not brake gently.
        """
        if self._speeds != STOPPED:
            reported = WheelSpeeds(*(self._reported or STOPPED))
            self._speeds = next_speeds(reported, self._speeds, RAMP_STEP, self._core.limits)
        self.missed_since = None
        self.send_again()

    def send_again(self) -> None:
        """Send the next speeds even where the robot was sent the same before."""
        if self._core.listening.may_send:
            self._sent = None

    def warn_again(self) -> None:
        """Report the next velocity that is refused."""
        self._refusal_reported = False

    def observe(self, readings: oi.Readings, now: float) -> None:
        """
        Take in the speeds that a frame reports; what the robot missed is sent again.

        A robot that stopped without being told, for somebody pressed a button or another program
        did it, starts from rest. While speeds are held back, only a change shows that it obeys.
        """
        status, reported, before = self._core.status, requested_speeds(readings), self._reported
        obeys = self._core.state.takes_commands and (status.can_drive or status.unknown)
        if not obeys:
            self._reported = None  # the wheels stand, or turn for somebody else
        if not obeys or None in reported:
            self.missed_since = None
            return
        self._reported = reported
        if self._sent == reported:
            if before != reported or not self._core.listening.open:
                self.missed_since = None
        elif self._sent is not None and now - self._sent_at > REPORT_TIMEOUT:
            if self.missed_since is None:
                self.missed_since = self._sent_at
                if reported == (0, 0):
                    self._speeds = STOPPED
            self.send_again()

    def _send_speeds(self, now: float) -> None:
        status = self._core.status
        if self._core.state.takes_commands and (status.can_drive or status.unknown):
            drive = self.next_drive(now)
            if drive is not None:
                self._core.outbox.send_at_once(drive, now)
        if (self._core.state.activity is Activity.DRIVING
                and self._wanted == self._speeds == STOPPED):
            self._core.handle(StateEvent.HALTED)

    def next_drive(self, now: float) -> oi.DriveDirect | None:
        """
        Return the command to send, if the robot must be told something new.

        At most one a slot, since the robot takes no more; but a stop never waits.
        """
        limits = self._core.limits
        since, self._ramped_at = min(now - self._ramped_at, RAMP_STEP), now
        bumps = self._core.readings.number('bumps_and_wheel_drops', 0) & BUMPS
        blocked = bool(bumps) and limits.bump_stop
        if not self._core.listening.may_send:  # but one zero
            if self._sent == (0, 0) or not blocked and self._wanted != STOPPED:
                return None
            self._sent, self._sent_at = (0, 0), now
            return HALT
        if self._speeds != self._wanted:
            self._speeds = next_speeds(self._speeds, self._wanted, since, limits)
        if blocked:
            right, left = self._speeds
            forward = max(0.0, (right + left) / 2)
            self._speeds = WheelSpeeds(right - forward, left - forward)  # turns as before
        # While they change, an error lasts a slot: each wheel follows its own ramp.
        speeds = (rounded(self._speeds) if self._speeds == self._wanted else
                  (round(self._speeds.right), round(self._speeds.left)))
        if speeds == self._sent or speeds != (0, 0) and now - self._sent_at < SLOT:
            return None
        self._sent, self._sent_at = speeds, now
        return oi.DriveDirect(right=speeds[0], left=speeds[1])
