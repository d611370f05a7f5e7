"""Bytes on their way to the robot, with the pauses that it needs between commands."""

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from .. import oi

MODE_PAUSE = 0.02
"""Seconds to leave after a command that changes the mode, before the next one."""


class _Outgoing(NamedTuple):
    encoded: bytes
    pause: float
    told: Callable[[bool], None] | None


class Outbox:
    """A queue that lets a command out when the robot can take it."""

    def __init__(self) -> None:
        self._queue: deque[_Outgoing] = deque()
        self._free_at = -float('inf')
        self._ready = bytearray()
        self._unconfirmed: list[Callable[[bool], None]] = []

    def send(
        self, command: oi.Command, *, pause: float = 0.0,
        told: Callable[[bool], None] | None = None,
    ) -> None:
        """
        Queue a command; ValueError, and nothing queued, where it is out of range.

        `told` is called once, with whether the command was written.
        """
        if command.enters is not None:
            pause = max(pause, MODE_PAUSE)
        self._queue.append(_Outgoing(command.encode(), pause, told))

    def send_raw(self, encoded: bytes) -> None:
        """Queue bytes that are no command."""
        self._queue.append(_Outgoing(encoded, 0.0, None))

    def send_at_once(self, command: oi.Command, now: float) -> None:
        """Let a command out before all that is queued; for stopping."""
        self._ready += command.encode()
        self._free_at = max(self._free_at, now)

    @property
    def busy(self) -> bool:
        """Whether commands are waiting for their turn."""
        return bool(self._queue)

    def clear(self) -> None:
        """Drop all that has not been let out."""
        waiting = [told for *_, told in self._queue if told is not None] + self._unconfirmed
        self._queue.clear()
        self._ready.clear()
        self._unconfirmed = []
        self._free_at = -float('inf')
        for told in waiting:
            told(False)

    def release(self, now: float) -> None:
        """Let out what is due."""
        while self._queue and now >= self._free_at:
            outgoing = self._queue.popleft()
            self._ready += outgoing.encoded
            self._free_at = now + outgoing.pause
            if outgoing.told is not None:
                self._unconfirmed.append(outgoing.told)

    def take(self) -> bytes:
        """Return what was let out."""
        ready = bytes(self._ready)
        self._ready.clear()
        return ready

    def confirm(self) -> None:
        """Tell those who wait that the bytes taken have been written."""
        confirmed, self._unconfirmed = self._unconfirmed, []
        for told in confirmed:
            told(True)
