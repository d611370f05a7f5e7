# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bytes delayed by the time they take on the wire."""

from collections import deque
from math import inf

from ...oi import BITS_PER_BYTE
from ..timing import TOLERANCE

PIECE = 128
"""Bytes that are passed on at once: more than a frame of the stream has."""


class Pacer:
    """One direction of a wire, in seconds; bytes put together arrive in PIECEs, with its last."""

    __slots__ = ('_waiting', '_free')

    def __init__(self) -> None:
        self._waiting: deque[tuple[float, bytes, int]] = deque()
        """When bytes have arrived, they, and their rate in bits per second."""
        self._free = 0.0
        """When the wire has carried all bytes."""

    def put(self, data: bytes, now: float, baud: int) -> None:
        """Queue bytes behind those that wait."""
        for start in range(0, len(data), PIECE):
            piece = data[start:start + PIECE]
            self._free = max(now, self._free) + len(piece) * BITS_PER_BYTE / baud
            self._waiting.append((self._free, piece, baud))

    def due(self) -> float:
        """Return when to call `take` next; inf if no byte is on the wire."""
        return self._waiting[0][0] if self._waiting else inf

    def take(self, now: float) -> tuple[bytes, int] | None:
        """Return the next bytes that have arrived, and the rate at which they were sent."""
        if not self._waiting or now < self._waiting[0][0] - TOLERANCE:
            return None
        _, data, baud = self._waiting.popleft()
        return data, baud
