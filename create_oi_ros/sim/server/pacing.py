# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bytes delayed by the time they take on the wire (`create_sim --wire-time`)."""

from ...oi import BITS_PER_BYTE
from ..timing import TOLERANCE

PIECE = 0.001
"""Seconds of bytes that are passed on at once, as a USB adapter does."""


class Pacer:
    """One direction of a wire; times in seconds."""

    __slots__ = ('_waiting', '_byte_time', '_next')

    def __init__(self) -> None:
        self._waiting = bytearray()
        self._byte_time = 0.0
        self._next = 0.0
        """When the first waiting byte has arrived completely."""

    def put(self, data: bytes, now: float, baud: int) -> None:
        """Queue bytes behind those that wait."""
        if not data:
            return
        self._byte_time = BITS_PER_BYTE / baud
        if not self._waiting:
            self._next = max(now, self._next - self._byte_time) + self._byte_time
        self._waiting += data

    def due(self) -> float:
        """Return when to call `take` next; inf if no byte is on the wire."""
        if not self._waiting:
            return float('inf')
        last = self._next + (len(self._waiting) - 1) * self._byte_time
        return min(last, self._next + PIECE)

    def take(self, now: float) -> bytes:
        """Return the bytes that have arrived."""
        if not self._waiting or now < self._next - TOLERANCE:
            return b''
        count = 1 + int((now - self._next + TOLERANCE) / self._byte_time)
        arrived = bytes(self._waiting[:count])
        del self._waiting[:count]
        self._next += len(arrived) * self._byte_time
        return arrived
