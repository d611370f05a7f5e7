# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Who drives, and until when the last command holds. Pure: the time is an argument.

One viewer at a time has the seat. A command holds for HOLD seconds, and the page sends the next
one earlier. So the wheels stop soon after a page is closed, a telephone sleeps, or the network
fails.
"""

from __future__ import annotations

from math import inf

from ...driver.motion import Velocity
from ...robot import TOP_SPEED, WHEEL_SEPARATION

HOLD = 0.15
"""Seconds that a command holds."""
OLDEST_VIEW = 0.5
"""Seconds: a page whose picture is older than this may not drive. It includes the way there."""
TOP_TURN = TOP_SPEED / (WHEEL_SEPARATION / 2)
"""rad/s at which both wheels run at top speed, in opposite directions."""


class Refused(Exception):
    """A viewer may not do this now; the message says why and what to do."""


class DriverSeat:
    """The seat of the only viewer that may drive; viewers are numbers."""

    def __init__(self) -> None:
        self.viewer: int | None = None
        """Who has the seat."""
        self.velocity = Velocity()
        """The command that holds now."""
        self.deadline = inf
        """When the command ends; inf while none holds."""
        self.latched = False
        """Whether STOP was pressed, and the stick has not been let go since."""

    @property
    def driving(self) -> bool:
        """Whether a command holds."""
        return self.deadline < inf

    def sit(self, viewer: int) -> None:
        """Take the seat if it is free; Refused: another viewer has it."""
        if self.viewer is None:
            self.viewer, self.latched = viewer, False
        if self.viewer != viewer:
            raise Refused('another page drives: press "Take over" first')

    def take_over(self, viewer: int) -> bool:
        """Take the seat, whoever has it; return whether the wheels must stop now."""
        if viewer == self.viewer:
            return False
        self.viewer = viewer
        return self._end()

    def leave(self, viewer: int) -> bool:
        """Free the seat if this viewer has it; return whether the wheels must stop now."""
        if viewer != self.viewer:
            return False
        self.viewer = None
        return self._end()

    def drive(self, viewer: int, velocity: Velocity, view_age: float, now: float) -> bool:
        """
        Take a command; return whether to obey it, False: it is too old, or STOP still holds.

        `view_age` is the age, s, of the newest picture that the page had when it sent this. After
        a gap in the network, old commands arrive all at once: their pictures are old, too.
        """
        self.sit(viewer)
        if self.latched or not -OLDEST_VIEW < view_age <= OLDEST_VIEW:
            return False
        self.velocity, self.deadline = velocity, now + HOLD
        return True

    def release(self, viewer: int) -> bool:
        """Let the stick go; return whether the wheels must stop now."""
        if viewer != self.viewer:
            return False
        return self._end()

    def stop(self) -> None:
        """Stop, whoever asks; the stick must be let go before it drives again."""
        self._end()
        self.latched = True

    def expire(self, now: float) -> bool:
        """Return whether the command has just ended because no other one came in time."""
        if now < self.deadline:
            return False
        self.velocity, self.deadline = Velocity(), inf
        return True

    def _end(self) -> bool:
        was_driving = self.driving
        self.velocity, self.deadline, self.latched = Velocity(), inf, False
        return was_driving
