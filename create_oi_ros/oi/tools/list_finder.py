# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Finds out from a stream itself which packets its frames carry.

A frame names its packets, and each has a known size. So a frame can be recognized without the
request: its packets fill exactly the length that it states, and its checksum is correct. A reader
that knows the request is safer: one damaged frame in some thousands looks like another list.
"""

from ..packets import FRAME_LIMIT, HEADER, PACKET_IDS, PacketList, size_of
from ..stream import BY_TOTAL


def lists_in(data: bytes) -> list[PacketList]:
    """Return the lists of packets whose frames are in these bytes, in order of appearance."""
    finder = ListFinder()
    finder.feed(data)
    finder.finish()
    return list(finder.lists)


class ListFinder:
    """Finds lists in bytes as they arrive."""

    def __init__(self) -> None:
        self.lists: dict[PacketList, None] = {}
        """The lists that were found, in order of appearance."""
        self._held = b''

    def feed(self, data: bytes) -> bytes:
        """Append received bytes; return those, in order, whose lists are all in `lists`."""
        held, at = self._held + data, 0
        while (start := held.find(HEADER, at)) >= 0:
            ids = _ids(held[start:start + FRAME_LIMIT])
            if ids is None:
                break
            at = start + 1
            if ids:
                packets = PacketList(ids)
                self.lists[packets] = None
                at = start + packets.frame_size
        done = len(held) if start < 0 else start
        self._held = held[done:]
        return held[:done]

    def finish(self) -> bytes:
        """Return the bytes that were held back: call this when no more bytes will come."""
        rest = b''
        while self._held:
            first, others, self._held = self._held[:1], self._held[1:], b''
            rest += first + self.feed(others)
        return rest


def _ids(frame: bytes) -> tuple[int, ...] | None:
    """Return the packets of a frame; () if it is none, None if more bytes are needed."""
    if len(frame) < 2:
        return None
    end = 2 + frame[1]
    ids, at = [], 2
    while at < end:
        if at >= len(frame):
            return None
        if frame[at] not in PACKET_IDS:
            return ()
        ids.append(frame[at])
        at += 1 + size_of(frame[at])
    if at > end:
        return ()
    if len(frame) <= end:
        return None
    return tuple(ids) if sum(frame[:end + 1]) & 0xff in BY_TOTAL else ()
