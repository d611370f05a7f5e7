# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Frames that say what the one before said, kept until there is a reason to look at them.

Most of what a frame costs is that it wakes the process: caches are cold, and each line of code is
dear. A host that wants the robot's place only a few times a second lets such frames wait, and
takes several at once. Each is still taken, in order, with the time at which it came. A frame that
says anything new, such as a bump, never waits, nor does what waits before it.
"""

from math import inf

from .. import oi

NOISY = (
    'wall_signal', 'cliff_left_signal', 'cliff_front_left_signal', 'cliff_front_right_signal',
    'cliff_right_signal', 'analog_signal',
)
"""Packets that differ from frame to frame of a robot for which nothing changes."""


class WaitingFrames:
    """Decides which bytes wait, and keeps them: whole frames, and the beginning of one."""

    def __init__(self) -> None:
        self._kept: list[tuple[bytes, float]] = []
        self._room = 0
        """Frames that may still wait, if they come by this moment, s."""
        self._until = -inf
        self._part = b''
        """The beginning of a frame."""
        self._packets = oi.PacketList(())
        self._news = self._said = self._total = 0
        """Bits of a frame that hold news, what they were in the last one, and its sum."""

    def let(self, frame: oi.Frame, begun: bytes, room: int, until: float) -> None:
        """
        Let frames wait that say what this one says: so many, if they come by a moment, s.

        `begun`: the bytes of the next frame that have come already.
        """
        if frame.packets is not self._packets:
            self._packets = frame.packets
            self._news = frame.packets.bits_without(*NOISY)
        self._said = int.from_bytes(frame.data) & self._news
        self._total = sum(frame.data) & 0xff
        self._part, self._room, self._until = begun, room, until

    def forbid(self) -> None:
        """Let nothing more wait."""
        self._until = -inf

    def keep(self, data: bytes, now: float) -> bool:
        """Keep bytes that say nothing new; False: they, and what waits, must be looked at now."""
        if now > self._until:
            return False
        room, part, size = self._room, self._part + data, self._packets.frame_size
        while len(part) >= size:
            if not room or sum(part[:size]) & 0xff != self._total or self._is_news(part[:size]):
                return False
            room, part = room - 1, part[size:]
        if part and self._is_news(part):
            return False
        self._room, self._part = room, part
        self._kept.append((data, now))
        return True

    def _is_news(self, part: bytes) -> bool:
        """Tell whether a frame, or the beginning of one, says what the last one did not."""
        missing = 8 * (self._packets.frame_size - len(part))
        return int.from_bytes(part) & (self._news >> missing) != self._said >> missing

    def take(self) -> list[tuple[bytes, float]]:
        """Remove and return what waits, oldest first, with the time at which each came."""
        kept, self._kept, self._until = self._kept, [], -inf
        return kept
