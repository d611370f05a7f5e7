# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_sim --replay`: the robot's side of a capture, sent again to a host that is connected now.

A replayed robot ignores what the host sends: it sends what it sent then. The replay starts when
the host sends its first byte, at the moment of the capture at which the captured host did. After
each loss of the port it waits for the host again. So a host misses nothing at the start, and gets
the captured answers if it sends what the captured host sent.
"""

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import chain
from math import inf
from pathlib import Path
import select
import time

from ...oi.tools.capture_format import (
    CaptureError,
    CaptureReader,
    MICROSECONDS,
    Record,
    RecordKind,
    records_of,
)
from ...robot import SLOT
from .lines import Line

BEFORE_THE_HOST = (RecordKind.FROM_ROBOT, RecordKind.OPENED, RecordKind.BAUD, RecordKind.NOTE)
LINGER = 1.0
"""Seconds for which the port stays open at the end: closing it would drop unread bytes."""
READ_SIZE = 4096
"""Bytes that are read from the file at once."""


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


class Player:
    """One replay on one line, in real time or `speed` times as fast."""

    def __init__(self, replay: Replay, line: Line, speed: float) -> None:
        self._replay, self._line, self._speed = replay, line, speed
        self._unsent = b''
        self._stopping = False

    def stop(self) -> None:
        """End `serve` soon; may be called from a signal handler."""
        self._stopping = True

    def serve(self) -> None:
        """Serve to the end of the capture or until `stop`; CaptureError if it is cut short."""
        try:
            while not self._stopping and not self._replay.over:
                self._replay.poll(self._now())
                self._exchange()
        finally:
            until = time.monotonic() + LINGER
            while not self._stopping and time.monotonic() < until:
                self._exchange()

    def _exchange(self) -> None:
        """Write what is due, and wait for the host's bytes or the next record."""
        replay = self._replay
        # What the host has no room for waits.
        self._unsent += replay.data_to_send()
        self._unsent = self._unsent[self._line.write(self._unsent):]
        if replay.plugged:
            self._line.plug()
        else:
            self._line.unplug()
        wait = SLOT if self._unsent else min(SLOT, replay.due() - self._now())
        ready, _, _ = select.select(self._line.watched(), [], [], max(0.0, wait / self._speed))
        if ready:
            replay.receive(self._line.read(), self._now())

    def _now(self) -> float:
        return time.monotonic() * self._speed


def _read(path: Path) -> tuple[dict[str, str], Iterator[Record]]:
    """Return facts and records of a file, read on demand; CaptureError names the file."""
    reader = CaptureReader()

    def records() -> Iterator[Record]:
        with path.open('rb') as file:
            try:
                yield from records_of(iter(lambda: file.read(READ_SIZE), b''), reader)
            except CaptureError as error:
                raise CaptureError(f'{path}: {error}') from error
    found = records()
    first = next(found)
    return reader.facts or {}, chain([first], found)


def play(
    path: Path, open_line: Callable[[], Line], speed: float,
    end_on_signals: Callable[[Player], None],
) -> None:
    """Replay a capture to its end; OSError or CaptureError say what is wrong with it."""
    facts, records = _read(path)
    replay = Replay(records)
    with closing(open_line()) as line:
        player = Player(replay, line, speed)
        end_on_signals(player)
        print(f'The robot of {path} ({facts.get("port")}, {facts.get("started")}) is on '
              f'{line.name}; it starts when a host sends a byte. Ctrl-C ends it.')
        print(f'  create_node --ros-args -p port:={line.name}', flush=True)
        try:
            player.serve()
        finally:
            print(f'Played {replay.time:.1f} s: {replay.sent} bytes to the host, '
                  f'{replay.received} bytes from it '
                  f'({replay.received_then} when it was captured).', flush=True)
