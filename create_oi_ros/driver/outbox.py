# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The queue of bytes to the robot, with the pauses that it needs between commands; what stops it.

Who asks for a command gets a `Pending`: its outcome is known at once, when the bytes are written,
or when the robot has answered.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from .. import oi

MODE_COMMANDS = {oi.Mode.PASSIVE: oi.Start, oi.Mode.SAFE: oi.Safe, oi.Mode.FULL: oi.Full}
HALT = oi.DriveDirect(right=0, left=0)
DRIVERS_OFF = oi.PwmLowSideDrivers(driver_0=0, driver_1=0, driver_2=0)
"""Low side drivers may turn motors: they are off whenever a robot was out of reach."""
DRAIN = bytes(2 * HALT.opcode)
"""Ends any command that was cut short after a `HALT` (manual: "waiting" state).

Zero is no opcode. The longest such command is a Song that takes the opcode for its count of
notes, of two bytes each.
"""
WAKE_UP = 2 * HALT.encode() + DRAIN + HALT.encode()
"""Stops a robot that may wait for the rest of a command, and has it listen again.

The first `HALT` may be taken as that rest, even as a speed; then the second one stops the wheels.
docs/reliability.md shows what becomes of each command.
"""
END_DEMO = oi.Demo(demo=oi.DemoNumber.ABORT)
REST = HALT.encode() + DRIVERS_OFF.encode() + oi.Start().encode()
DEAD_MAN_STOP = REST + DRAIN + REST
"""Stops a robot whose driver has died, even in the middle of a command."""


def farewell(mode: oi.Mode | None, mode_on_exit: oi.Mode) -> list[oi.Command]:
    """Return the last commands of a driver that ends, to a robot in this mode."""
    demo = [END_DEMO] if mode is oi.Mode.PASSIVE else []
    return [
        HALT, DRIVERS_OFF, *demo,
        oi.PauseResumeStream(state=oi.StreamState.PAUSE), MODE_COMMANDS[mode_on_exit]()]


class Outcome(NamedTuple):
    """How a request, a goal or a tune ended."""

    ok: bool
    text: str
    """For people: what was done; or why it was not done, and what to do."""


class Pending:
    """A request, a goal or a tune whose outcome may not be known yet; the first one counts."""

    def __init__(self, outcome: Outcome | None = None) -> None:
        self.outcome = outcome
        """None until it is known."""
        self._callbacks: list[Callable[[Outcome], None]] = []

    def end(self, ok: bool, text: str) -> None:
        """Say what the outcome is."""
        if self.outcome is None:
            self.outcome = Outcome(ok, text)
            for callback in self._callbacks:
                callback(self.outcome)
            self._callbacks.clear()

    def then(self, callback: Callable[[Outcome], None]) -> None:
        """Call back with the outcome: now if it is known, else as soon as it is."""
        if self.outcome is None:
            self._callbacks.append(callback)
        else:
            callback(self.outcome)


def done(text: str) -> Pending:
    return Pending(Outcome(True, text))


def refused(text: str) -> Pending:
    """Return a request that is refused; the text says why, and what to do."""
    return Pending(Outcome(False, text))


MODE_PAUSE = 0.02
"""Seconds to leave after a command that changes the mode, before the next one."""
MOTION = (oi.Demo, oi.Cover, oi.CoverAndDock, oi.Spot, oi.PlayScript)
CALLED_OFF = 'called off before it was sent: something else stopped the robot'
LOST = 'the robot was lost before the command was written: try again when it answers'


@dataclass(eq=False)
class _Queued:
    encoded: bytes
    request: Pending
    done: str = ''
    """How the request ends once it is written."""
    rest: float = 0.0
    """Seconds to leave before it, more than the command before it needs; others pass it."""
    pause: float = 0.0
    """Seconds to leave after it."""
    moves: bool = False
    """Whether it lets the robot move by itself."""
    due: float = inf
    """When its rest is over; infinite before the rest begins."""


class Outbox:
    """Releases commands when the robot can take them."""

    def __init__(self) -> None:
        self._queue: deque[_Queued] = deque()
        self._free_at = -inf
        self._ready = b''
        self._unconfirmed: list[_Queued] = []
        """What was made ready, and is not known to be written."""

    def send(self, command: oi.Command, done: str = '', *, rest: float = 0.0) -> Pending:
        """
        Queue a command; the request ends with `done` when it is written.

        ValueError, and nothing queued, where it is out of range.
        """
        queued = _Queued(
            command.encode(), Pending(), done, rest, 0.0 if command.enters is None else MODE_PAUSE,
            isinstance(command, MOTION) and command != END_DEMO)
        self._queue.append(queued)
        return queued.request

    def send_raw(self, encoded: bytes) -> None:
        """Queue bytes that are no command."""
        self._queue.append(_Queued(encoded, Pending()))

    def send_at_once(self, command: oi.Command, now: float) -> None:
        """Release a command ahead of the queue; for stopping."""
        self._ready += command.encode()
        self._free_at = max(self._free_at, now)

    @property
    def busy(self) -> bool:
        """Whether commands are queued, but for one that rests."""
        return any(not queued.rest for queued in self._queue)

    def clear(self, *instead: oi.Command) -> None:
        """Drop all that has not been written, and release commands instead; requests are lost."""
        lost = (*self._queue, *self._unconfirmed)
        self._queue.clear()
        self._ready, self._unconfirmed = b''.join(each.encode() for each in instead), []
        self._free_at = -inf
        for queued in lost:
            queued.request.end(False, LOST)

    def call_off_motion(self) -> bool:
        """Drop queued commands that let the robot move by itself; True when there were any."""
        dropped = [queued for queued in self._queue if queued.moves]
        for queued in dropped:
            self._queue.remove(queued)
            queued.request.end(False, CALLED_OFF)
        return bool(dropped)

    def release(self, now: float) -> None:
        """Make ready what is due; what follows a command that rests passes it."""
        for queued in tuple(self._queue):
            if now < self._free_at:
                return
            if queued.rest:
                queued.due = min(queued.due, self._free_at + queued.rest)
                if now < queued.due:
                    continue
            self._queue.remove(queued)
            self._ready += queued.encoded
            self._free_at = now + queued.pause
            self._unconfirmed.append(queued)

    def take_ready(self) -> bytes:
        """Return the bytes to write now, once."""
        ready, self._ready = self._ready, b''
        return ready

    def confirm(self) -> None:
        """End the requests whose bytes have been written."""
        written, self._unconfirmed = self._unconfirmed, []
        for queued in written:
            queued.request.end(True, queued.done)
