# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whether the wheels do what was requested.

Nothing tells but a reading: somebody holds or pushes the robot, or it goes its own way. What
unknown gains, dead times and encoders could explain is not disobedience.
"""

from math import exp

from ..robot import FIRMWARE_SEPARATION
from .states import DEGREE, MM
from .tracks import Tracks

SLACK, PART, LAG = 4.0, 0.25, 0.3
"""How far obedient wheels may be from a reading: units, a part of the way, and seconds times the
changes of speed."""
BELIEVABLE = 2.0, 0.06, 0.2
"""The same for wheels that did not obey: within this they are believed to obey again."""
TELLING_TIME = 0.2
"""Seconds that a window must last to tell."""


class ExpectedTravel:
    """What the wheels would do by their requests since the last reading."""

    def __init__(self) -> None:
        self._last = 0.0, 0.0
        self._since = 0.0
        """Seconds under these requests that are not added up yet."""
        self._recent = 0.0
        """m/s by which the requests changed, fading: wheels still follow these."""
        self.restart()

    def restart(self) -> None:
        """Begin a new window."""
        self._fade()
        self._seconds = self._far = self._turn = self._path = 0.0
        self._changes = self._recent

    def step(self, dt: float, right: float, left: float, tracks: Tracks) -> None:
        """Let time pass under these requests."""
        if (right, left) != self._last:
            self._add_up(tracks)
            change = abs(right - self._last[0]) + abs(left - self._last[1])
            self._changes, self._recent = self._changes + change, self._recent + change
            self._last = right, left
        self._since += dt

    def _add_up(self, tracks: Tracks) -> None:
        """Add what the wheels do in the time that has passed."""
        right, left = tracks.goals(*self._last)
        dt = self._fade()
        self._seconds += dt
        self._far += (right + left) / 2 * dt
        self._turn += (right - left) / FIRMWARE_SEPARATION * dt
        self._path += (abs(right) + abs(left)) / 2 * dt

    def _fade(self) -> float:
        """Let changes of the requests fade; return the seconds that passed since the last time."""
        dt, self._since = self._since, 0.0
        self._recent *= exp(-dt / LAG)
        return dt

    def judge(self, distance: int, angle: int, tracks: Tracks) -> None:
        """Free the wheels, or bind them to their requests, by what a reading says."""
        self._add_up(tracks)
        if self._seconds < TELLING_TIME:
            return
        misses = (abs(distance * MM - self._far), abs(angle * DEGREE - self._turn))
        if tracks.is_free:
            if self._within(misses, *BELIEVABLE):
                tracks.free(False)
        elif not self._within(misses, SLACK, PART, LAG) and not tracks.explains(distance, angle):
            tracks.free(True)

    def _within(self, misses: tuple[float, float], slack: float, part: float, lag: float) -> bool:
        way = part * self._path + lag * self._changes
        return (misses[0] <= slack * MM + way
                and misses[1] <= slack * DEGREE + way * 2 / FIRMWARE_SEPARATION)
