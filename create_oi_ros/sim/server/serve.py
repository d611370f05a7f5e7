# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
One simulated robot on one line, in real time.

The robot's clock is the computer's, in slots of about 15 ms with absolute deadlines, so it does
not drift. Late slots are run at once. A delay longer than `LONGEST_STALL` (a laptop that slept) is
skipped: it never happened for the robot and its world.
"""

from collections import deque
from collections.abc import Callable
from math import inf
import select
import time

from ...oi import Baud, BaudCode, BITS_PER_BYTE
from .. import TOLERANCE
from ..firmware import Create
from .control import ControlPort, Interpreter
from .faults import FaultKind, Faults
from .lines import Line

RATES = {code.rate: code for code in BaudCode}
LONGEST_STALL = 0.25
"""Seconds on the computer's clock."""


class Server:
    """One robot on one line, in real time or `speed` times as fast."""

    def __init__(self, create: Create, line: Line, faults: Faults | None = None, *,
                 speed: float = 1.0, linger: float = 0.0,
                 clock: Callable[[], float] = time.monotonic) -> None:
        """Prepare to serve; `clock` is the computer's, in seconds."""
        self._create, self._line, self._speed, self._clock = create, line, speed, clock
        self._faults = faults or Faults([])
        self._to_host, self._to_robot = Pacer(), Pacer()
        """Bytes on the wire."""
        self._bauds = line.baud(), line.baud()
        """The rates that the host had set in the last two slots."""
        self._last_byte = b''
        self.control = Interpreter(create, line, self._faults, self.stop)
        self.control_port: ControlPort | None = None
        self.watchers: list[Callable[[], None]] = [self.control.step]
        """Called after every slot."""
        self._origin = 0.0
        self._slots = 0
        self._linger = linger
        self._end: float | None = None
        """When to end at the latest, on the computer's clock."""

    def stop(self) -> None:
        """
        End `serve` soon; may be called from a signal handler.

        The first call gives the host `linger` seconds to close the port, the second none.
        """
        self._end = self._clock() + (self._linger if self._end is None else 0.0)

    def _ended(self) -> bool:
        return self._end is not None and (
            not self._line.connected() or self._clock() >= self._end)

    def serve(self) -> None:
        """Serve until `stop`; the robot's clock starts now."""
        self._origin = self._clock()
        # Start the robot's slots together with ours.
        self._create.poll(0.0)
        while not self._ended():
            now = self._now()
            if now >= (self._slots + 1) * self._create.period - TOLERANCE:
                # One at a time, even if late, so that watchers see the end of every slot.
                self._slots += 1
                self._slot(self._slots * self._create.period)
            self._pass_on(now)
            wait = (self._due() - self._now()) / self._speed
            ready, _, _ = select.select(self._watched(), [], [], wait if wait > 0 else 0.0)
            if ready:
                self._read(self._now())

    def _now(self) -> float:
        """Return seconds on the robot's clock, without long stalls."""
        now = (self._clock() - self._origin) * self._speed
        late = now - (self._slots + 1) * self._create.period
        if late > LONGEST_STALL * self._speed:
            self._origin += late / self._speed
            now -= late
        return now

    def _slot(self, now: float) -> None:
        self._cause_faults(now)
        baud = self._line.baud()
        self._bauds = self._bauds[1], baud
        self._create.host_baud(baud)
        self._create.poll(now)
        self._send(now)
        for watch in self.watchers:
            watch()
        if self.control_port is not None:
            self.control_port.serve(self._create.time)

    def _cause_faults(self, now: float) -> None:
        unplugged = self._faults.active(FaultKind.UNPLUG)
        begun = self._faults.step(now)
        if FaultKind.BROWNOUT in begun:
            self._create.lose_battery(now)
        if FaultKind.UNPLUG in begun:
            self._line.unplug()
        elif unplugged and not self._faults.active(FaultKind.UNPLUG):
            self._line.plug()

    def _read(self, now: float) -> None:
        data = self._faults.to_robot(self._line.read(), now)
        own = self._create.baud
        baud = self._line.baud() or own
        if self._bauds[0] == own != baud and baud in RATES:
            old = self._sent_before(data, baud)
            self._to_robot.put(data[:old], now, own)
            data = data[old:]
        self._to_robot.put(data, now, baud)
        self._last_byte = data[-1:]
        if self.control_port is not None:
            self.control_port.serve(self._create.time)
            self._send(now)

    def _sent_before(self, data: bytes, baud: int) -> int:
        """
        Return how many of these bytes a host at the robot's rate sent before it set a new one.

        A pseudo terminal does not tell, and its tcdrain returns at once: they are those up to
        the Baud command for that rate, if there is one.
        """
        command = Baud(code=RATES[baud]).encode()
        place = (self._last_byte + data).rfind(command)
        return 0 if place < 0 else place + len(command) - len(self._last_byte)

    def _send(self, now: float) -> None:
        data = self._faults.from_robot(self._create.data_to_send(), now)
        self._to_host.put(data, now, self._line.baud() or self._create.baud)

    def _due(self) -> float:
        """Return when the next slot ends, or bytes arrive."""
        slot = (self._slots + 1) * self._create.period
        return min(slot, self._to_host.due(), self._to_robot.due())

    def _pass_on(self, now: float) -> None:
        """Pass on the bytes that have arrived at either end of the wire."""
        while (arrived := self._to_robot.take(now)) is not None:
            data, baud = arrived
            self._create.receive(data, now, None if self._line.baud() is None else baud)
            self._send(now)
        while (arrived := self._to_host.take(now)) is not None:
            self._line.write(arrived[0])

    def _watched(self) -> list[int]:
        watched = self._line.watched()
        return watched + self.control_port.watched() if self.control_port else watched


PIECE = 128
"""Bytes that are passed on at once: more than a frame of the stream has."""


class Pacer:
    """One direction of a wire, in seconds; bytes put together arrive in PIECEs, with its last."""

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
