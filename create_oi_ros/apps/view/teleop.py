"""
Driving by keys; pure.

A terminal tells when a key is pressed and when it repeats, but never when it is let go. So each
press drives for a short time, and a key that is held renews it. Forward and turning run out each
by itself: who holds one and taps the other drives a curve. Nothing is said while nothing is
pressed, so that others may drive; the last word is one zero.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from .keys import Drive

HOLD = 0.6
"""Seconds that a press drives: a little more than keyboards wait before they repeat."""
PERIOD = 0.05
"""Seconds between two commands."""
FASTEST, FASTEST_TURN = 0.5, 3.8
"""m/s and rad/s: what the robot can."""
STEP = 1.25
LEAST = 0.02
"""m/s below which the keys do not slow down further."""


class Velocity(NamedTuple):
    """Metres and radians a second."""

    linear: float
    angular: float


STANDSTILL = Velocity(0.0, 0.0)


class _Axis:

    def __init__(self) -> None:
        self.way = 0
        self.until = -inf

    def press(self, way: int, now: float) -> None:
        if way:
            self.way, self.until = way, now + HOLD

    def at(self, now: float) -> int:
        return self.way if now < self.until else 0


class Teleop:
    """Decides what is commanded, and when."""

    def __init__(self, linear: float = 0.2, angular: float = 1.0) -> None:
        """Start with these speeds, m/s and rad/s."""
        self.speeds = Velocity(linear, angular)
        self.driving = False
        """Whether the last word was not a zero."""
        self._forward, self._turn = _Axis(), _Axis()
        self._next = -inf

    def press(self, drive: Drive, now: float) -> None:
        """Take a key in; it counts at once."""
        self._forward.press(drive.forward, now)
        self._turn.press(drive.turn, now)
        self.driving, self._next = True, now

    def release(self) -> None:
        """Let go of all keys: what is due next is a zero, if anything."""
        self._forward, self._turn, self._next = _Axis(), _Axis(), -inf

    def faster(self, steps: int) -> None:
        """Change the speeds, not beyond what the robot can; negative: slower."""
        factor = STEP ** steps
        linear = min(self.speeds.linear * factor, FASTEST)
        angular = min(self.speeds.angular * factor, FASTEST_TURN)
        if linear >= LEAST:
            self.speeds = Velocity(linear, angular)

    def due(self, now: float) -> Velocity | None:
        """Return what is to be commanded now, if anything."""
        if not self.driving or now < self._next:
            return None
        self._next = now + PERIOD
        wanted = Velocity(self._forward.at(now) * self.speeds.linear,
                          self._turn.at(now) * self.speeds.angular)
        self.driving = wanted != STANDSTILL
        return wanted

    def wait(self, now: float) -> float:
        """Return the seconds until something may be due; inf: not before a key."""
        return max(0.0, self._next - now) if self.driving else inf
