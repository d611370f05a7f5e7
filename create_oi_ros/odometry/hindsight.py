# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The past of a robot that nobody knew, followed again once it is known.

Most of the error of a drive comes from its first minute, in which any wheels are plausible, and
nothing of it would ever be put right. So all that the filter was told is kept. When some readings
have taught what the wheels are like, a filter that starts with this follows the past, some frames
with each new one, and takes the place of the first when it has come to the present. It also tries
again what else the robot may be, with wheels that are known better by then.
"""

from collections.abc import Callable

from .dead_band import DeadBand
from .estimate import Geometry, Increment
from .filter import Filter

AFTER = 40.0, 120.0
"""Seconds of driving after which to look back."""
CONFUSED = 6.0
"""Doubt of the best track from which on what was learned is not worth it."""
HASTE = 3
"""Entries of the past that are followed with each frame."""
LONGEST = 20_000
"""Entries that are kept at most: five minutes in which no two frames are alike."""
Told = Increment | Callable[[Filter], None]
"""A frame, or another event: what the filter does then."""


class Hindsight:
    """What a filter was told, and one that follows it again."""

    def __init__(self, geometry: Geometry) -> None:
        self._geometry = geometry
        self._past: list[tuple[Told, int]] = []
        """What the filter was told, and how many times in a row."""
        self._left = list(AFTER)
        self._other: Filter | None = None
        """The filter that follows again, and how far it is: the entry, and the times in it."""
        self._entry = self._times = 0
        self._driven = 0.0
        """Seconds of driving since the filter began to try all that is plausible."""
        self._readings = 0
        """Readings that it had when last looked at."""

    @property
    def over(self) -> bool:
        """Whether nobody will look back any more."""
        return not self._left or len(self._past) > LONGEST

    def note(self, told: Told) -> None:
        """Keep what the filter is told."""
        if isinstance(told, Increment) and told.driven and (told.right or told.left):
            self._driven += told.dt
        if self._past and self._past[-1][0] == told:
            self._past[-1] = told, self._past[-1][1] + 1
        else:
            self._past.append((told, 1))

    def step(self, now: Filter) -> Filter | None:
        """Follow the past some way; return a filter that has come to the present."""
        rows = now.tracks.rows
        if rows.readings < self._readings:
            self._left, self._driven = list(AFTER), 0.0  # it tries all again
        self._readings = rows.readings
        if self._other is None:
            if self._driven < self._left[0] or rows.doubt[0] > CONFUSED:
                return None
            band = now.tracks.band
            self._other = Filter(self._geometry, rows.afresh(), DeadBand(band.stands, band.moves))
            self._entry = self._times = 0
        for _ in range(HASTE):
            copies = self._other.tracks.wheels.steps
            if self._follow(self._other) is None:
                other, self._other = self._other, None
                self._left.pop(0)
                self._readings = 0  # it may have had some fewer
                return other
            if self._other.tracks.wheels.steps is not copies:
                break  # copies of the wheels that are made anew are dear, as with each reading
        return None

    def _follow(self, other: Filter) -> Told | None:
        """Tell a filter what is next in the past, and return it; None: there is nothing."""
        told, times = self._past[self._entry]
        if self._times == times:
            if self._entry == len(self._past) - 1:
                return None
            self._entry, self._times = self._entry + 1, 0
            told, times = self._past[self._entry]
        if not isinstance(told, Increment):
            told(other)
        elif other.tracks.rests and other.is_steady(told):
            # It rests in all of these frames.
            other.move(told._replace(dt=told.dt * (times - self._times)))
            other.read(told)
            self._times = times - 1
        else:
            other.move(told)
            other.read(told)
        self._times += 1
        return told
