# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The robot's side of a capture, sent again to a host that is connected now.

A replayed robot ignores what the host sends: it sends what it sent then. The replay starts when
the host sends its first byte, at the moment of the capture at which the captured host did. After
each loss of the port it waits for the host again. So a host misses nothing at the start, and gets
the captured answers if it sends what the captured host sent.
"""

from collections import deque
from collections.abc import Iterator
from math import inf

from ...oi.tools.capture_format import MICROSECONDS, Record, RecordKind

BEFORE_THE_HOST = (RecordKind.FROM_ROBOT, RecordKind.OPENED, RecordKind.BAUD, RecordKind.NOTE)


class Replay:
    """A captured robot, with the verbs of `Create`. Times are in seconds."""

    def __init__(self, records: Iterator[Record]) -> None:
        """Replay these records; each is fetched when its time comes."""
        self._records = records
        self._ahead: deque[Record] = deque()
        self._origin: float | None = None
        """When the capture started, on the host's clock; None until the host sends a byte."""
        self._unsent = bytearray()
        self.plugged = True
        """Whether the port is present."""
        self.over = False
        """Whether all records were replayed."""
        self.time = 0.0
        """Time of the capture up to which it was replayed."""
        self.sent = self.received = self.received_then = 0
        """Bytes sent to the host, received from it, and received then from the captured host."""

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes from the host; the first ones start the replay."""
        self.received += len(data)
        if data and self._origin is None:
            self._origin = now - self._host_started_at()

    def _host_started_at(self) -> float:
        """Return when the captured host sent its first byte since the port was opened."""
        for record in self._records:
            self._ahead.append(record)
            if record.kind not in BEFORE_THE_HOST:
                break
        return self._ahead[-1].time / MICROSECONDS if self._ahead else 0.0

    def poll(self, now: float) -> None:
        """Advance to `now`; CaptureError if the capture is cut short."""
        while now >= self.due():
            record = self._ahead.popleft()
            self.time = record.time / MICROSECONDS
            match record.kind:
                case RecordKind.FROM_ROBOT:
                    self._unsent += record.data
                    self.sent += len(record.data)
                case RecordKind.TO_ROBOT:
                    self.received_then += len(record.data)
                case RecordKind.LOST:
                    self.plugged = False
                case RecordKind.OPENED if not self.plugged:
                    self.plugged = True
                    self._origin = None

    def due(self) -> float:
        """Return when the next record is due; inf while it waits for the host, or at the end."""
        if self._origin is None or self.over:
            return inf
        if not self._ahead:
            record = next(self._records, None)
            if record is None:
                self.over = True
                return inf
            self._ahead.append(record)
        return self._origin + self._ahead[0].time / MICROSECONDS

    def data_to_send(self) -> bytes:
        """Return the bytes sent since the last call."""
        sent = bytes(self._unsent)
        self._unsent.clear()
        return sent
