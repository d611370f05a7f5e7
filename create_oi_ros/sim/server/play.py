# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_sim --replay`: a captured robot on a line, in real time."""

from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import chain
from pathlib import Path
import select
import time

from ...oi.tools.capture_format import CaptureError, CaptureReader, Record, records_of
from ...robot import SLOT
from .lines import Line
from .replay import Replay

LINGER = 1.0
"""Seconds for which the port stays open at the end: closing it would drop unread bytes."""
AT_ONCE = 4096
"""Bytes that are read from the file at once."""


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
                self._turn(self._replay.poll)
        finally:
            until = time.monotonic() + LINGER
            while not self._stopping and time.monotonic() < until:
                self._turn(lambda now: None)

    def _turn(self, poll: Callable[[float], None]) -> None:
        replay = self._replay
        poll(self._now())
        self._write()
        if replay.plugged:
            self._line.plug()
        else:
            self._line.unplug()
        wait = SLOT if self._unsent else min(SLOT, replay.due() - self._now())
        ready, _, _ = select.select(self._line.watched(), [], [], max(0.0, wait / self._speed))
        if ready:
            replay.receive(self._line.read(), self._now())

    def _write(self) -> None:
        """Write what is due; what the host has no room for waits."""
        self._unsent += self._replay.data_to_send()
        self._unsent = self._unsent[self._line.write(self._unsent):]

    def _now(self) -> float:
        return time.monotonic() * self._speed


def _read(path: Path) -> tuple[dict[str, str], Iterator[Record]]:
    """Return facts and records of a file, read on demand; CaptureError names the file."""
    reader = CaptureReader()

    def records() -> Iterator[Record]:
        with path.open('rb') as file:
            try:
                yield from records_of(iter(lambda: file.read(AT_ONCE), b''), reader)
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
