# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
When to ask the robot for distance and angle.

Each reading may cost what is below a whole unit, and one that falls into a change of speed tells
least. So the robot is asked about once a window, when its wheels have had time to follow, and less
often while nothing changes. A robot that loses fractions is best asked when its whole degrees are
about to change: then the answer tells on which side of the prediction it is. As long as its
rounding is unknown, it is also asked in some frames in a row, or at even intervals, at moments at
which the roundings would answer differently.
"""

from ..robot import Rounding
from .states import DEGREE, MM
from .tracks import Tracks

ANSWER = 6
"""Frames within which a reading that was asked for arrives, or is asked for again."""
WAITS = 0.7, 2.0, 7.0
"""Windows between readings while the requests stay the same: at least, at most while a robot is
new, and at most when it is known."""
GROWTH = 0.8
"""Part of the seconds since the last change of request to wait between readings."""
VARIED = 0.8, 0.4
"""Least factor by which waits vary, and how much they vary by."""
STANDING = 1.0
"""Windows between readings at rest."""
UNSETTLED = 2.0
"""Windows between readings while the requests change."""
STRETCH = 2.0
"""How much longer waits become, in part, while the robot becomes known."""
BLURRED, SOON = (1.6, 2.0), 0.4
"""Doubt of what the accumulators hold, degrees or twice as many mm, of a new and of a known robot,
from which on to ask after this part of a window, the least there is. A new robot's wheels are less
sure than they seem."""
TELLING, SPARE = 1.0, 3.0
"""Windows after a reading from which on to ask when the answer tells much; windows to wait longer
for such a moment once the robot is known."""
FORESEEN = 0.5
"""How well a robot must be known for such moments to be foreseen."""
SPARING = 3.0
"""Windows between readings at least, where each costs and somebody wants few."""
FREE = 0.5
"""Windows between readings while the wheels do not do what was requested."""
SETTLED = 0.45
"""Seconds after a request in which most wheels have followed it."""
GOLDEN = 0.618
"""The step that fills a range of waits evenly."""
PROBE = 8
"""Frames of a probe."""
SPACED, LONGEST, FEW = 5, 6, 3.0
"""Readings of a probe with some frames from one to the next, and these at most; units between
them at most."""
PROBE_EVERY = 1.5
"""Seconds from one probe to the next."""
PROBE_STEADY = 0.6
"""Seconds without a change of request before a probe."""


class ReadingPlan:
    """Decides after each frame whether the next one should carry a reading."""

    def __init__(self, window: float) -> None:
        self.window = window
        self.due = True
        self.sparing = False
        """Whether to ask seldom while the rounding is not known, for what a reading takes away is
        not known then either; and to probe slow motion, too, where readings are some frames apart.
        """
        self._age = self._steady = self._probed = 0.0
        self._probe = self._readings = self._since = 0
        self._spacing = 1
        """Frames from one reading of a probe to the next."""
        self._asked_spacing: tuple[tuple[float, float], float, set[Rounding], int] | None = None
        self._told_spacing = 0
        """The last question for a spacing, and its answer."""
        self._asked = ANSWER + 1
        self._alone, self._latency = False, 1
        """Whether the last question was no part of a probe; frames from such a one to its answer.
        """

    @property
    def pending(self) -> bool:
        """Whether a reading that was asked for may be under way."""
        return self._asked <= ANSWER

    def came(self) -> None:
        """Note that a reading has come."""
        self._age = 0.0
        self._readings += 1
        if self._alone and self.pending:
            self._latency = max(1, self._asked)
        self._asked = ANSWER + 1

    def hurry(self) -> None:
        """Ask soon: what the robot did is not sure, and somebody needs to know."""
        self._age = max(self._age, (UNSETTLED + SPARE) * self.window)

    def step(self, dt: float, *, steady: bool, tracks: Tracks) -> bool:
        """
        Let a frame pass; `steady`: with the same requests as the one before.

        Return whether it was the last one in which the answer to a question could have come.
        """
        if not steady:
            self._steady = -dt
        self.rest(dt)
        in_vain = self._asked == ANSWER
        if self._probe:
            self.due = self._since >= self._spacing
            self._probe -= int(self.due)
        elif self.pending:
            self.due = False
        elif spacing := self._probe_spacing(dt, tracks):
            self._probe = PROBE if spacing == 1 else SPACED
            self._probed, self._alone, self._spacing = 0.0, False, spacing
            self.due = True
        else:
            self.due = self._alone = (
                self._age >= SOON * self.window and self._left(dt, tracks) <= 0)
        if self.due:
            self._asked = self._since = 0
        return in_vain

    def rest(self, dt: float) -> None:
        """Let a frame pass in which nothing is to be asked."""
        self._age += dt
        self._probed += dt
        self._steady += dt
        self._asked += 1
        self._since += 1

    def quiet(self, dt: float, tracks: Tracks) -> float:
        """
        Return the seconds for which nothing will be asked of a robot that rests, or moves, on.

        Its wheels are at their goals; frames take dt seconds.
        """
        if self.due or self.pending or self._probe or self._steady < SETTLED:
            return 0.0
        wait = self._left(dt, tracks)
        if len(tracks.roundings) > 1 and not tracks.rests and self._spacing_of(dt, tracks):
            wait = min(wait, max(PROBE_STEADY - self._steady, PROBE_EVERY - self._probed))
        return wait

    def _left(self, dt: float, tracks: Tracks) -> float:
        """Return the seconds until it is time to ask: the answer tells much, or patience ends."""
        patience = self._patience(tracks)
        if (tracks.is_free or tracks.rests or _is_blurred(tracks)
                or tracks.known < FORESEEN or tracks.roundings == {Rounding.CARRY}):
            return patience - self._age
        left = patience + SPARE * self.window * tracks.known - self._age
        soonest = TELLING * self.window - self._age
        return min(left, max(soonest, tracks.tells_in(self._latency * dt)))

    def _patience(self, tracks: Tracks) -> float:
        """Return the seconds to wait after the last reading."""
        if tracks.is_free:
            return FREE * self.window
        least = SPARING * self.window if self.sparing and len(tracks.roundings) > 1 else 0.0
        return max(least, self._wait(tracks))

    def _wait(self, tracks: Tracks) -> float:
        """
        Return the same for somebody who does not mind readings.

        They vary: steady motion read at even intervals would be rounded alike each time.
        """
        if _is_blurred(tracks):
            return SOON * self.window
        patience = 1 + STRETCH * tracks.known
        if self._steady < SETTLED:
            return UNSETTLED * self.window * patience
        shortest, new, known = WAITS
        longest = new + (known - new) * tracks.known
        wait = STANDING if tracks.rests else min(
            longest, max(patience * shortest, GROWTH * self._steady))
        return self.window * wait * (VARIED[0] + VARIED[1] * (self._readings * GOLDEN % 1))

    def _probe_spacing(self, dt: float, tracks: Tracks) -> int:
        """
        Return after how many frames each readings would now tell the roundings left apart.

        0: they would not.
        """
        if (self._steady < PROBE_STEADY or self._probed < PROBE_EVERY or tracks.rests
                or not tracks.settled or tracks.is_free):
            return 0
        return 0 if len(tracks.roundings) == 1 else self._spacing_of(dt, tracks)

    def _spacing_of(self, dt: float, tracks: Tracks) -> int:
        """Return the same for wheels that have run steadily for long enough."""
        # Most frames ask the same as the one before.
        asked = tracks.rates, dt, tracks.roundings, self._latency if self.sparing else 0
        if asked != self._asked_spacing:
            self._asked_spacing, self._told_spacing = asked, _telling_spacing(*asked)
        return self._told_spacing


def _is_blurred(tracks: Tracks) -> bool:
    """Tell whether nobody knows well enough what the accumulators hold."""
    new, known = BLURRED
    return tracks.blur > new + (known - new) * tracks.known


def _telling_spacing(rates: tuple[float, float], dt: float, roundings: set[Rounding],
                     latency: int) -> int:
    """
    Return after how many frames of dt seconds each readings tell these roundings apart; 0: none.

    Readings come in each frame, or also later than their latency where that is not 0.
    """
    amounts = [abs(rate) * dt / unit for rate, unit in zip(rates, (MM, DEGREE))]
    spacings = [1, *range(latency + 1, LONGEST + 1)] if latency else [1]
    # Above a half, rounding gains what truncation loses; below it both lose the same.
    for frames in spacings:
        if any(0.62 < amount * frames % 1 < 0.88 for amount in amounts
               if frames == 1 or amount * frames < FEW):
            return frames
    if Rounding.CARRY in roundings and any(0.15 < amount % 1 < 0.38 for amount in amounts):
        return 1
    return 0
