# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the frames tell of the robot: the tracks, and whether the wheels obey at all.

It knows which readings spanned an unknown time or were lost on the line, and keeps them from the
tracks. When to ask for a reading is not decided here, nor how the estimate follows.
"""

from .accumulators import UNITS
from .assumptions import Assumptions
from .dead_band import DeadBand
from .estimate import Geometry, Increment
from .knowledge import Knowledge, learned
from .obedience import ExpectedTravel
from .tracks import Held, Tracks


class Filter:
    """Follows the robot, frame by frame."""

    def __init__(self, geometry: Geometry, rows: Assumptions | None = None,
                 band: DeadBand | None = None) -> None:
        """Start with these assumptions and this dead band; else with nothing known."""
        self.tracks = Tracks(geometry, rows, band)
        self.driven: bool | None = None
        """Whether the wheels obeyed their requests in the last frame; None before the first."""
        self.fell_short = False
        """Whether the last reading was between nothing and what the accumulators were believed to
        hold, give or take a unit."""
        self._obedience = ExpectedTravel()
        self._lifted = False
        """Whether a wheel hangs down."""
        self._discard = True
        self._gap = self._doubt = False
        self._missed: list[tuple[Held, Held]] = []
        """For each reading that may have been lost: what the accumulators were believed to hold
        when it was asked for, and after the last frame that could have carried it."""
        self._asked = self.tracks.held
        """What they were believed to hold when a reading was last asked for."""
        self._lost = False
        """Whether frames were lost since then."""
        self._knowledge: Knowledge | None = None
        """What was learned, once somebody has asked for it since the last reading."""

    @property
    def knowledge(self) -> Knowledge | None:
        """What was learned of the robot; None before anything was."""
        if self._knowledge is None and self.tracks.rows.readings:
            self._knowledge = learned(self.tracks.rows, self.tracks.band)
        return self._knowledge

    def recounted(self) -> None:
        """Learn nothing from the next reading: the robot has set its accumulators to zero."""
        self._discard = True

    def interrupted(self) -> None:
        """Go on from here after frames were missed: the next reading spans an unknown time."""
        self._gap = self._doubt = True

    def reset(self) -> None:
        """Put the origin where the robot is."""
        self.tracks.reset()

    def asked(self) -> None:
        """Note that the next frame should carry a reading."""
        self._asked, self._lost = self.tracks.held, False

    def unanswered(self) -> None:
        """Note that none has come by the last frame that could have carried it."""
        if self._lost:
            self._missed.append((self._asked, self.tracks.held))

    def is_steady(self, increment: Increment) -> bool:
        """Tell whether a frame has the requests of the one before."""
        return _requests(increment) == self.tracks.requests

    def move(self, increment: Increment) -> bool:
        """Let the time of a frame pass; return whether nothing has moved."""
        dt, driven, tracks = increment.dt, increment.driven, self.tracks
        right, left = _requests(increment)
        steady = (right, left) == tracks.requests
        if increment.lifted != self._lifted:
            tracks.lift(increment.lifted)
        if driven != self.driven:
            tracks.free(not driven)
        if self._gap:
            tracks.resume(right, left)
        rested = steady and tracks.rests
        if driven or self.driven is not None:  # else it is the time before the origin
            tracks.advance(dt, right, left, to_read=increment.distance is not None)
            self._obedience.step(dt, right, left, tracks)
        self._gap, self.driven, self._lifted = False, driven, increment.lifted
        self._lost = self._lost or increment.lost
        return rested

    def rest(self, increment: Increment) -> None:
        """Do the same where this frame says what the one before did, and wheels are at goals."""
        dt, right, left, *_ = increment
        self.tracks.advance(dt, right, left)
        self._obedience.step(dt, right, left, self.tracks)

    def read(self, increment: Increment) -> bool:
        """Learn from the reading in a frame; return whether there is one."""
        distance, angle = increment.distance, increment.angle
        if distance is None or angle is None:
            return False
        tracks, obedience = self.tracks, self._obedience
        self.fell_short = all(
            min(held, 0.0) - unit <= whole * unit <= max(held, 0.0) + unit
            for (_, unit), whole, held in zip(UNITS, (distance, angle), tracks.held))
        missed, self._missed = self._missed, []
        if self._lost:
            missed.append((self._asked, tracks.held))
        if self._discard or any(came_since(*held, distance, angle, tracks) for held in missed):
            # The first reading may hold travel from before; one that was lost on the line has
            # taken away what this one lacks.
            tracks.discard()
        else:
            if self.driven:
                obedience.judge(distance, angle, tracks)
            tracks.read(distance, angle, doubted=self._doubt, driven=bool(self.driven))
        obedience.restart()
        self._discard = self._doubt = False
        self._knowledge = None
        return True


def _requests(increment: Increment) -> tuple[float, float]:
    """Return what the wheels are asked that obey."""
    return (increment.right, increment.left) if increment.driven else (0.0, 0.0)


def came_since(began: Held, ended: Held, distance: int, angle: int, tracks: Tracks) -> bool:
    """
    Tell whether a surprising reading is only what came since a moment.

    A reading was lost on the line while the accumulators held something between these.
    """
    if tracks.is_free or tracks.explains(distance, angle):
        return False
    for (_, unit), whole, now, first, last in zip(
            UNITS, (distance, angle), tracks.held, began, ended):
        low, high = sorted((now - first, now - last))
        if not low - 2 * unit <= whole * unit <= high + 2 * unit:
            return False
    return True
