# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whether the robot takes the commands that it is sent.

The line to the robot has no checksum and no acknowledgement, and a Wait (a damaged byte may
become one) makes the robot ignore commands while its stream goes on. Two things show that it took
them: it streams another list of packets when asked to, and it reports the speeds that it was sent.
"""

from enum import auto, Enum

from ..robot import SLOT

MISSES_SUSPECTED, MISSES_REPORTED = 4, 14
"""Speeds in a row that the robot did not take: after 0.6 s and after 2 s."""
UNSEEN_SUSPECTED, UNSEEN_REPORTED = 0.6, 1.5
"""Seconds without frames of the list that was asked for."""
IGNORES = ('the robot ignores commands, even a stop: damaged bytes may have told it to wait; '
           'lift it, switch it off and on')


class CommandNews(Enum):
    """News about whether the robot takes commands."""

    SUSPECT = auto()
    """It may be in the middle of a command."""
    IGNORES = auto()
    OBEYS_AGAIN = auto()


class CommandWatch:
    """Compares what the robot does with what it was asked for."""

    def __init__(self) -> None:
        self._list: tuple[int, ...] | None = None
        """The packets of the newest frame."""
        self._unseen_since: float | None = None
        self._last: CommandNews | None = None

    @property
    def ignores(self) -> bool:
        """Whether the robot ignores commands, and the user was told."""
        return self._last is CommandNews.IGNORES

    def restart(self) -> None:
        """Start again: the robot was away, or cannot take commands now."""
        self._list = self._unseen_since = self._last = None

    def asked(self, packets: tuple[int, ...], now: float) -> None:
        """Note that the robot was asked for frames with these packets."""
        if self._unseen_since is None and self._list not in (None, packets):
            self._unseen_since = now

    def seen(self, packets: tuple[int, ...]) -> None:
        """Note the packets of a frame; where they change, the robot took a command."""
        if packets != self._list:
            self._list, self._unseen_since = packets, None

    def check(self, missed: int, now: float) -> CommandNews | None:
        """Return what is new; `missed` is how many speeds in a row the robot did not take."""
        if not missed and self._unseen_since is None and self._last is None:
            return None  # as in most frames
        unseen = 0.0 if self._unseen_since is None else now - self._unseen_since
        before = self._last
        if missed >= MISSES_REPORTED or unseen > UNSEEN_REPORTED:
            self._last = CommandNews.IGNORES
        elif before is not CommandNews.IGNORES and (
                missed >= MISSES_SUSPECTED or unseen > UNSEEN_SUSPECTED):
            self._last = CommandNews.SUSPECT
        elif not missed and unseen <= 2 * SLOT:
            self._last = None
        if self._last is before:
            return None
        return self._last or CommandNews.OBEYS_AGAIN
