# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Who may open the page, how much a page may send, and who drives. Pure: the time is an argument.

One viewer at a time has the driver's seat. A command holds for a moment, and the page sends the
next one earlier. So the wheels stop soon after a page is closed, a phone sleeps, or the network
fails.
"""

from __future__ import annotations

from ipaddress import ip_address
from urllib.parse import urlsplit

from ...robot import TOP_SPEED, WHEEL_SEPARATION

MOST_VIEWERS = 8
"""Pages that are connected at once."""
LONGEST_MESSAGE = 4096
"""Bytes of one message from a page."""
RATE, BURST = 60.0, 120.0
"""Messages a second that a page may send for long, and at once."""
OLDEST_VIEW = 0.5
"""Seconds: a page whose picture is older than this may not drive. It includes the way there."""
TOP_TURN = TOP_SPEED / (WHEEL_SEPARATION / 2)
"""rad/s at which both wheels run at top speed, in opposite directions."""


def is_loopback(host: str) -> bool:
    """Return whether an address, or the name `localhost`, means this computer only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def names_this_computer(header: str) -> bool:
    """
    Return whether the Host header of a request is a name of this computer.

    Without a token no other name is answered: a page of another site can point a name of its own
    at 127.0.0.1, and would then count as the same site (DNS rebinding).
    """
    try:
        return is_loopback(urlsplit(f'//{header}').hostname or '')
    except ValueError:  # it cannot be read
        return False


class MessageBudget:
    """Limits how often a page sends messages: RATE a second, and BURST at once."""

    def __init__(self, now: float) -> None:
        """Begin with a full budget."""
        self._left, self._at = BURST, now

    def spend(self, now: float) -> bool:
        """Count a message; return whether it is within the limit."""
        self._left = min(BURST, self._left + (now - self._at) * RATE)
        self._at = now
        if self._left < 1:
            return False
        self._left -= 1
        return True


class Refused(Exception):
    """A viewer may not do this now; the message says why and what to do."""


class DriverSeat:
    """The seat of the only viewer that may drive; viewers are numbers."""

    def __init__(self) -> None:
        self.viewer: int | None = None
        """Who has the seat."""
        self.driving = False
        """Whether a command holds."""
        self.latched = False
        """Whether STOP was pressed, and the stick has not been let go since."""

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

    def drive(self, viewer: int, view_age: float) -> bool:
        """
        Take a command; return whether to obey it, False: it is too old, or STOP still holds.

        `view_age` is the age, s, of the newest picture that the page had when it sent this. After
        a gap in the network, old commands arrive all at once: their pictures are old, too.
        """
        self.sit(viewer)
        if self.latched or not -OLDEST_VIEW < view_age <= OLDEST_VIEW:
            return False
        self.driving = True
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

    def expire(self) -> bool:
        """End the command: no other one came in time; return whether one held."""
        was_driving, self.driving = self.driving, False
        return was_driving

    def _end(self) -> bool:
        self.latched = False
        return self.expire()
