"""
When a frame left the robot, estimated from when frames arrived.

The robot sends a frame in every slot of its own clock; the line adds a delay that is never
negative. So the earliest arrivals, not their average, show where the slots are: stamps follow
the lower envelope of the arrivals over the last second or so.
"""

from collections import deque
from itertools import islice

from .. import oi

WINDOW = 64
"""Frames over which the earliest arrival counts: about a second."""
RECENT = 16
"""Frames in a row that must all be late before a slot is taken to have been lost."""
SILENT = 3.5 * oi.SLOT
"""Seconds without a frame after which some may have been lost unseen; no delay is that long."""
LEAST_STEP = 1e-4
"""Seconds by which stamps rise at least."""


class FrameClock:
    """Turns arrivals into rising stamps, free of most of the line's jitter."""

    def __init__(self) -> None:
        self._lateness: deque[float] = deque(maxlen=WINDOW)
        self._slot = 0
        self._stamp = -float('inf')
        self._arrival: float | None = None
        self._suspicious = 0

    def restart(self) -> None:
        """Forget where the robot's slots lie: it was away."""
        self._lateness.clear()
        self._arrival = None
        self._suspicious = 0

    def suspect(self) -> None:
        """Note that bytes came which may have been a frame."""
        self._suspicious = WINDOW

    @property
    def gap(self) -> bool:
        """Whether a frame may have been lost just before the newest one."""
        return self._suspicious == WINDOW - 1

    def stamp(self, arrival: float, wire_time: float) -> tuple[float, float]:
        """
        Return when a frame left, and the robot's seconds since the one before.

        `arrival` is when its last byte was received, `wire_time` how long its bytes took.
        """
        if self._arrival is not None and arrival - self._arrival > SILENT:
            self.suspect()
        self._arrival = arrival
        self._slot += 1
        self._lateness.append(arrival - wire_time - self._slot * oi.SLOT)
        lost = self._lost_slots()
        if lost:
            self._slot += lost
            recent = list(islice(self._lateness, len(self._lateness) - RECENT, None))
            self._lateness.clear()
            self._lateness.extend(late - lost * oi.SLOT for late in recent)
        stamp = self._slot * oi.SLOT + min(self._lateness)
        self._stamp = max(stamp, self._stamp + LEAST_STEP)
        return self._stamp, (1 + max(lost, 0)) * oi.SLOT

    def _lost_slots(self) -> int:
        """
        Return by how many slots all recent frames are late.

        One late frame is the line's delay; when none comes in time any more, and there was a
        sign of it, frames are missing. Without a sign a line may just have become slower.
        """
        self._suspicious -= 1
        older = len(self._lateness) - RECENT
        if older <= 0 or self._suspicious < 0:
            return 0
        before = min(islice(self._lateness, older))
        return round((min(islice(self._lateness, older, None)) - before) / oi.SLOT)
