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
from math import inf

from .. import oi
from ..odometry.knowledge import Known, PERIOD

WINDOW = 64
"""Frames over which the earliest arrival counts: about a second."""
RECENT = 16
"""Frames in a row that must all be late, or early, before slots are counted anew."""
SILENT = 3.5 * oi.SLOT
"""Seconds without a frame after which some are missing: lost, or late."""
TOGETHER_WITHIN = 0.5
"""Part of a slot within which late frames follow each other, and frames in time never do."""
MIN_STEP = 1e-4
"""Seconds by which stamps rise at least."""
MIN_PERIOD, MAX_PERIOD = 0.0147, 0.0160
"""Seconds between which a slot's length is believed; 15 and 15.625 ms were seen."""
BLOCK = 32
"""Frames of which the earliest is kept to learn the slot's length."""
BLOCKS = 400
"""How many of them are kept: three minutes."""
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
        self._stamp = -inf
        self._begin(known)

    def _begin(self, known: Known) -> None:
        self.period = known.value
        """Seconds of a slot, as far as it is known."""
        self._first = known
        self._part: float = 0.0
        """Share of what was seen in the period."""
        self._sent: deque[tuple[int, float]] = deque(maxlen=WINDOW)
        """Slot and earliest possible moment of each frame."""
        self._late: deque[float] = deque(maxlen=WINDOW)
        """How late each of them was by its slot, up to a constant."""
        self._least = inf
        """The least of these."""
        self._earliest: deque[tuple[int, float]] = deque(maxlen=BLOCKS)
        """The frame of each block that was sent earliest for its slot."""
        self._frames = 0
        self._arrival: float | None = None
        self._suspicious = 0
        """Frames from now on in which a sign of missing ones counts."""
        self._missing = 0.0
        """Frames that garbage stands for."""
        self._absent = 0
        """Frames that did not come before the last one: the next one tells what became of them."""
        self.found_lost = 0.0
        """Seconds of frames that are known now to have been lost before the last one."""
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

    @property
    def gap(self) -> bool:
        """Whether a frame may have been lost just before the newest one."""
        return self._suspicious == WINDOW - 1

    @property
    def undecided(self) -> bool:
        """Whether frames are missing before the newest one that may only be late."""
        return self._absent > 0 and self.gap

    @property
    def absent(self) -> float:
        """Seconds of frames that are late or lost."""
        return self._absent * self.period

    def suspect(self, frames: float = 0.0) -> None:
        """Note that bytes came which may have been so many frames."""
        self._suspicious = WINDOW
        self._missing += frames

    def stamp(self, arrival: float, wire_time: float) -> tuple[float, float]:
        """
        Return when a frame left, and the robot's seconds since the one before.

        `arrival` is when its last byte was received, `wire_time` how long its bytes took.
        """
        sent = arrival - wire_time
        lost = 0
        if self._absent and self._arrival is not None:
            lost = self._decide(arrival - self._arrival, sent)
        self.found_lost = lost * self.period
        passed = 1
        if self._missing or self._arrival is None or arrival - self._arrival > SILENT:
            passed += self._frames_missing(arrival)
        self._arrival = arrival
        slot = self._slot + lost + passed
        wrong = 0
        if self._suspicious > 0 and self._late:
            # Counted too far where the frame seems early: no line is faster than ever.
            wrong = min(0, round((sent - slot * self.period - self._least) / self.period))
        self._note(slot + wrong, sent)
        self._suspicious -= 1
        late = self._slots_late() if self._suspicious >= 0 else 0
        if late:
            self._recount(slot + wrong, late)
        self._slot = slot + wrong + late
        self._frames += 1
        if self._frames % BLOCK == 0 and len(self._sent) >= BLOCK:
            self._learn_period()
        self._stamp = max(self._slot * self.period + self._least, self._stamp + MIN_STEP)
        # What is below the least duration is taken from later frames.
        self._owed += (passed + wrong + late) * self.period
        duration = max(self._owed, MIN_STEP)
        self._owed -= duration
        return self._stamp, duration

    def _note(self, slot: int, sent: float) -> None:
        """Keep when the newest frame left, as far as it alone tells."""
        oldest = self._late[0] if len(self._late) == WINDOW else inf
        late = sent - slot * self.period
        self._sent.append((slot, sent))
        self._late.append(late)
        # All of them are compared only when the least has just left the window.
        self._least = min(late, self._least) if oldest > self._least else min(self._late)

    def _decide(self, since: float, sent: float) -> int:
        """
        Tell by the next frame what became of absent ones; return how many were lost.

        `since`: seconds between the arrivals of that frame and of the one before. Late frames
        come together. After lost ones frames come in time.
        """
        if since < TOGETHER_WITHIN * self.period:
            self._absent -= 1
            return 0
        late = sent - (self._slot + 1) * self.period - self._least
        lost = max(0, min(self._absent, round(late / self.period)))
        self._absent = 0
        return lost

    def _frames_missing(self, arrival: float) -> int:
        """Return how many frames garbage before this one stands for."""
        missing, self._missing = round(self._missing), 0.0
        if self._arrival is None:
            return 0
        slots = (arrival - self._arrival) / self.period
        if arrival - self._arrival > SILENT:
            self.suspect()
            self._missing = 0.0
            self._absent = round(slots) - 1
            return 0
        return min(missing, int(slots) + 1)

    def _count_late(self) -> None:
        """Work out again how late frames were, by other slots or a slot of another length."""
        self._late = deque((sent - slot * self.period for slot, sent in self._sent), WINDOW)
        self._least = min(self._late)

    def _slots_late(self) -> int:
        """
        Return by how many slots all recent frames are late; counted too far they are negative.

        One late frame is the line's delay; when none comes in time any more, and there was a
        sign of it, frames are missing. Without a sign a line may just have become slower.
        """
        older = len(self._sent) - RECENT
        if older < RECENT or self._absent:
            return 0  # the earliest of a few frames may be a late one
        recent = min(islice(self._late, older, None))
        return round((recent - min(islice(self._late, older))) / self.period)

    def _recount(self, newest: int, slots: int) -> None:
        """Put the recent frames, up to this slot, into other slots."""
        older = len(self._sent) - RECENT
        recent = [(slot + slots, sent) for slot, sent in islice(self._sent, older, None)]
        self._sent.clear()
        self._sent.extend(recent)
        self._count_late()
        while self._earliest and self._earliest[-1][0] > newest - 2 * RECENT:
            self._earliest.pop()

    def _learn_period(self) -> None:
        """Take the slope of the lower envelope, little of it while it is short."""
        period = self.period
        block = islice(self._sent, len(self._sent) - BLOCK, None)
        self._earliest.append(min(block, key=lambda frame: frame[1] - frame[0] * period))
        (first, began), (last, ended) = self._earliest[0], self._earliest[-1]
        slots = last - first
        if slots > 0:
            slope = (ended - began) / slots
            known, deviation = self._first
            self._part = slots ** 2 / (slots ** 2 + (UNEVEN / deviation) ** 2)
            period = known + self._part * (slope - known)
            self.period = min(MAX_PERIOD, max(MIN_PERIOD, period))
            self._count_late()
