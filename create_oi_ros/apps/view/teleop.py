# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Driving by keys. Pure.

A terminal reports when a key is pressed and when it repeats, but not when it is released. So each
press drives for HOLD seconds, and a held key renews it. Forward and turn end separately: hold one
key and tap the other to drive a curve. While no key drives, nothing is published, so that other
programs may drive; the last command is a single zero.
"""

from __future__ import annotations

from math import inf

from ...driver.motion import Velocity
from ...robot import TOP_SPEED
from .keys import DriveKey

HOLD = 0.6
"""Seconds that a press drives: a little longer than keyboards wait before they repeat."""
PERIOD = 0.05
"""Seconds between two commands."""
FASTEST, FASTEST_TURN = TOP_SPEED, 3.8
"""m/s; rad/s, reached when both wheels run at almost top speed in opposite directions."""
STEP = 1.25
"""Factor between two speeds."""
LEAST = 0.02
"""m/s; the keys go no slower."""
STANDSTILL = Velocity(0.0, 0.0)


class _Axis:
    """One direction of motion: its sign, and until when it drives."""

    def __init__(self) -> None:
        self.direction = 0
        self.until = -inf

    def press(self, direction: int, now: float) -> None:
        if direction:
            self.direction, self.until = direction, now + HOLD

    def at(self, now: float) -> int:
        return self.direction if now < self.until else 0


class Teleop:
    """Decides which velocity is commanded, and when."""

    def __init__(self, linear: float = 0.2, angular: float = 1.0) -> None:
        """Start with these speeds, m/s and rad/s."""
        self.speeds = Velocity(linear, angular)
        self.driving = False
        """Whether the last command was not zero."""
        self._forward, self._turn = _Axis(), _Axis()
        self._next = -inf

    def press(self, drive: DriveKey, now: float) -> None:
        """Press a key; its command is due at once."""
        self._forward.press(drive.forward, now)
        self._turn.press(drive.turn, now)
        self.driving, self._next = True, now

    def release(self) -> None:
        """Release all keys; if one was driving, a zero is due at once."""
        self._forward, self._turn, self._next = _Axis(), _Axis(), -inf

    def change_speed(self, steps: int) -> None:
        """Change the speeds, within the robot's limits; negative: slower."""
        factor = STEP ** steps
        linear = min(self.speeds.linear * factor, FASTEST)
        angular = min(self.speeds.angular * factor, FASTEST_TURN)
        if linear >= LEAST:
            self.speeds = Velocity(linear, angular)

    def due(self, now: float) -> Velocity | None:
        """Return the velocity to command now; None: nothing is due."""
        if not self.driving or now < self._next:
            return None
        self._next = now + PERIOD
        wanted = Velocity(self._forward.at(now) * self.speeds.linear,
                          self._turn.at(now) * self.speeds.angular)
        self.driving = wanted != STANDSTILL
        return wanted

    def wait(self, now: float) -> float:
        """Return the seconds until a command may be due; inf: not before a key is pressed."""
        return max(0.0, self._next - now) if self.driving else inf
