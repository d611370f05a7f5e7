"""
When a frame left the robot, estimated from when frames arrived.

The robot sends a frame every 15 ms by its own clock; the line adds a delay that is never
negative. So the earliest arrivals, not the average, tell where the robot's slots lie: the
estimate is the lower envelope of the arrivals over the last second or so.
"""

from collections import deque

from .. import oi

WINDOW = 64
"""Frames over which the earliest arrival counts: about a second."""


class FrameClock:
    """Turns arrivals into stamps that never go backwards, free of most of the line's jitter."""

    def __init__(self) -> None:
        self._lateness: deque[float] = deque(maxlen=WINDOW)
        self._count = 0
        self._stamp: float | None = None

    def restart(self) -> None:
        """Forget the robot's slots: it was away."""
        self._lateness.clear()
        self._count = 0

    def stamp(self, arrival: float, wire_time: float) -> tuple[float, float]:
        """
        Return when a frame left, and the seconds since the one before (0 for the first).

        `arrival` is when its last byte was received, `wire_time` how long its bytes took.
        """
        self._count += 1
        ideal = self._count * oi.SLOT
        self._lateness.append(arrival - wire_time - ideal)
        stamp = ideal + min(self._lateness)
        before = self._stamp
        self._stamp = stamp if before is None else max(stamp, before)
        return self._stamp, 0.0 if before is None else self._stamp - before
