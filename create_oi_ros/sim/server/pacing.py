"""Bytes that take their time on the wire, as they do at a baud rate (`create_sim --wire-time`)."""

from __future__ import annotations

from ...oi import BITS_PER_BYTE

PIECE = 0.001
"""Seconds: bytes are handed on in pieces as long as this, as a USB adapter does."""
EARLY = 1e-6


class Pacer:
    """One direction of a wire; times in seconds."""

    __slots__ = ('_waiting', '_byte_time', '_next')

    def __init__(self) -> None:
        self._waiting = bytearray()
        self._byte_time = 0.0
        self._next = 0.0
        """When the first waiting byte has wholly arrived."""

    def put(self, data: bytes, now: float, baud: int) -> None:
        """Send bytes behind those that wait."""
        if not data:
            return
        self._byte_time = BITS_PER_BYTE / baud
        if not self._waiting:
            self._next = max(now, self._next - self._byte_time) + self._byte_time
        self._waiting += data

    def due(self) -> float:
        """Return when there is something worth taking; inf: nothing is on its way."""
        if not self._waiting:
            return float('inf')
        last = self._next + (len(self._waiting) - 1) * self._byte_time
        return min(last, self._next + PIECE)

    def take(self, now: float) -> bytes:
        """Return what has arrived."""
        if not self._waiting or now < self._next - EARLY:
            return b''
        count = 1 + int((now - self._next + EARLY) / self._byte_time)
        arrived = bytes(self._waiting[:count])
        del self._waiting[:count]
        self._next += len(arrived) * self._byte_time
        return arrived
