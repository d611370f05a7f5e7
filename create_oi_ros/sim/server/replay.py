"""
The robot's side of a capture, for a host that is there now.

A robot that was captured is deaf: it says what it said then, whatever the host says. Its time
begins when the host speaks, as it did when the host of the capture first spoke, and begins so
again each time the port was lost and opened: so no host misses the beginning, and one that asks
as the captured one did is answered as that one was.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from math import inf

from ...oi.tools.capture_format import Kind, MICROSECONDS, Record

BEFORE_THE_HOST = (Kind.FROM_ROBOT, Kind.OPENED, Kind.BAUD, Kind.NOTE)


class Replay:
    """Has the verbs of a robot, and no ears; times in seconds."""

    def __init__(self, records: Iterator[Record]) -> None:
        """Take the records one by one, when their time comes."""
        self._records = records
        self._ahead: deque[Record] = deque()
        self._origin: float | None = None
        """When the capture was started, on the host's clock; None until the host speaks."""
        self._said = bytearray()
        self.plugged = True
        """Whether the port is there."""
        self.over = False
        """Whether nothing follows."""
        self.time = 0.0
        """Of the capture, up to which it has been played."""
        self.said = self.heard = self.heard_then = 0
        """Bytes: to the host, from the host, and from the host of the capture."""

    def receive(self, data: bytes, now: float) -> None:
        """Notice that the host speaks."""
        self.heard += len(data)
        if data and self._origin is None:
            self._origin = now - self._host_spoke_at()

    def _host_spoke_at(self) -> float:
        """Return when the host of the capture spoke first, since the port was opened."""
        for record in self._records:
            self._ahead.append(record)
            if record.kind not in BEFORE_THE_HOST:
                break
        return self._ahead[-1].time / MICROSECONDS if self._ahead else 0.0

    def poll(self, now: float) -> None:
        """Say what it is time to say; CaptureError where the capture is cut short."""
        while now >= self.due():
            record = self._ahead.popleft()
            self.time = record.time / MICROSECONDS
            match record.kind:
                case Kind.FROM_ROBOT:
                    self._said += record.data
                    self.said += len(record.data)
                case Kind.TO_ROBOT:
                    self.heard_then += len(record.data)
                case Kind.LOST:
                    self.plugged = False
                case Kind.OPENED if not self.plugged:
                    self.plugged = True
                    self._origin = None

    def due(self) -> float:
        """Return when there is something to say; inf where it waits for the host, or is over."""
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
        """Return what was said since the last time."""
        said = bytes(self._said)
        self._said.clear()
        return said
