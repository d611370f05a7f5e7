# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
When a frame left the robot, estimated from when frames arrived.

The robot sends a frame in each slot of about 15 ms of its own clock; the line adds a delay that is
never negative. So the earliest arrivals, not their average, show where the slots are: stamps
follow the lower envelope of the arrivals over the last second or so, and the slope of that
envelope over minutes is the length of a slot.
"""

from collections import deque
from itertools import islice
from math import floor, inf

from .. import oi
from ..odometry.estimate import Known, PERIOD

WINDOW = 64
"""Frames over which the earliest arrival counts, and up to `BLOCK` more: about a second."""
SILENT = 3.5 * oi.SLOT
"""Seconds without a frame after which some are missing: lost, or late."""
TOGETHER = 0.5
"""Part of a slot within which late frames follow each other, and frames in time never do."""
EARLY = 0.25
"""Part of a slot by which a frame may seem to have come too early."""
MIN_STEP = 1e-4
"""Seconds by which stamps rise at least."""
MIN_PERIOD, MAX_PERIOD = 0.0147, 0.0160
"""Seconds between which a slot's length is believed; 15 and 15.625 ms were seen."""
BLOCK = 32
"""Frames of which the earliest is taken to learn the slot's length."""
MIN_DEVIATION = 1e-6
"""Seconds by which the clocks of robot and computer drift apart, with the temperature."""
UNEVEN = 40 * PERIOD.deviation
"""Seconds by which the two ends of the envelope may be wrong together: after 40 slots what was
seen of the length counts as much as the manual's 15 ms."""


class FrameClock:
    """Turns arrivals into rising stamps, free of most of the line's jitter."""

    def __init__(self, known: Known = PERIOD) -> None:
        """Start with what is known of a slot's length."""
        self._slot = 0
        """Where the newest frame is."""
        self.newest = -inf
        """Its stamp, s; -inf before the first."""
        self._begin(known)

    def _begin(self, known: Known) -> None:
        self.period = known.value
        """Seconds of a slot, as far as it is known."""
        self._first = known
        self._part: float = 0.0
        """Share of what was seen in the period."""
        self._sent: deque[tuple[int, float]] = deque(maxlen=WINDOW)
        """Slot and earliest possible moment of each frame."""
        self._least = inf
        """How late the earliest of them was by its slot, up to a constant."""
        self._anchor: tuple[int, float] | None = None
        """The earliest frame of the first block."""
        self._frames = 0
        self._arrival = inf
        self.gap = False
        """Whether a frame may have been lost just before the newest one."""
        self._unsure = 0
        """Frames from now on that may have been counted too far."""
        self._missing = False
        """Whether frames did not come, and may still come late."""
        self._owed = 0.0
        """Seconds of counted slots that no frame has been given yet; negative: given too early."""

    def restart(self) -> None:
        """Forget where the robot's slots lie: it was away. How long they are stays."""
        self._begin(self.known_period)

    @property
    def known_period(self) -> Known:
        """Seconds of a slot, and their standard deviation."""
        deviation = self._first.deviation * (1 - self._part) ** 0.5
        return Known(self.period, max(deviation, MIN_DEVIATION))

    def stamp(self, arrival: float, wire_time: float, *,
              lost: bool = False) -> tuple[float, float]:
        """
        Return when a frame left, and the robot's seconds since the one before.

        `arrival` is when its last byte was received, `wire_time` how long its bytes took; `lost`:
        bytes came before it that may have been frames.
        """
        sent = arrival - wire_time
        since, self._arrival = arrival - self._arrival, arrival
        silent = since > SILENT
        # Late frames come together. One that comes alone is in time: what is missing was lost.
        in_time = lost or self._missing and TOGETHER * self.period < since <= SILENT
        self._missing = silent or self._missing and not in_time
        if silent or in_time:
            self._unsure = WINDOW
        slot = self._slot + 1
        if self._unsure and self._sent:
            self._unsure -= 1
            newest = floor((sent - self._least) / self.period + EARLY)
            slot = newest if in_time else min(slot, newest)
        self.gap = silent or slot > self._slot + 1
        self._sent.append((slot, sent))
        self._frames += 1
        self._least = min(self._least, sent - slot * self.period)
        if self._frames % BLOCK == 0:
            self._learn_period()
            self._least = min(at - each * self.period for each, at in self._sent)
        # What is below the least duration is taken from later frames.
        self._owed += (slot - self._slot) * self.period
        self._slot = slot
        self.newest = max(slot * self.period + self._least, self.newest + MIN_STEP)
        duration = max(self._owed, MIN_STEP)
        self._owed -= duration
        return self.newest, duration

    def _learn_period(self) -> None:
        """Take the slope of the lower envelope, little of it while it is short."""
        block = islice(self._sent, len(self._sent) - BLOCK, None)
        earliest = min(block, key=lambda frame: frame[1] - frame[0] * self.period)
        if self._anchor is None:
            self._anchor = earliest
            return
        slots = max(1, earliest[0] - self._anchor[0])
        slope = (earliest[1] - self._anchor[1]) / slots
        known, deviation = self._first
        self._part = slots ** 2 / (slots ** 2 + (UNEVEN / deviation) ** 2)
        period = known + self._part * (slope - known)
        self.period = min(MAX_PERIOD, max(MIN_PERIOD, period))
