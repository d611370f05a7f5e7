"""
One simulated robot on one line, in the time of this computer.

The robot's clock is the computer's, cut into slots with absolute deadlines, so that it does not
drift.  A slot that is late is made up for at once, up to `LONGEST_STALL`; what a longer
stall (a laptop that slept) has cost is left out, for robot and world alike.
"""

from __future__ import annotations

from collections.abc import Callable
import math
import select
import time

from create_oi_ros.sim.control import Control
from create_oi_ros.sim.faults import Faults, Kind
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.lines import Line
from create_oi_ros.sim.pacing import Pacer
from create_oi_ros.sim.server.control_port import ControlPort

LONGEST_STALL = 0.25
"""Seconds on the computer's clock."""
_EARLY = 1e-6


class Server:
    """One robot on one line, in real time or `speed` times as fast."""

    def __init__(self, create: Create, line: Line, faults: Faults | None = None, *,
                 speed: float = 1.0, wire_time: bool = False) -> None:
        self._create, self._line, self._speed = create, line, speed
        self._faults = faults or Faults([])
        self._to_host = Pacer() if wire_time else None
        self._to_robot = Pacer() if wire_time else None
        self.control = Control(create, line, self._faults, self.stop)
        self.control_port: ControlPort | None = None
        self.watchers: list[Callable[[], None]] = []
        """Called after every slot."""
        self._origin = 0.0
        self._slots = 0
        self._stopping = False

    def stop(self) -> None:
        """End `serve` soon; may be called from a signal's function."""
        self._stopping = True

    def serve(self) -> None:
        """Serve until `stop`; the robot's time begins now."""
        self._origin = time.monotonic()
        # The robot's slots are to begin with ours.
        self._create.step(0.0)
        while not self._stopping:
            now = self._now()
            if now >= (self._slots + 1) * self._create.period - _EARLY:
                # One at a time, however late, so that watchers see the end of every slot.
                self._slots += 1
                self._slot(self._slots * self._create.period)
            self._pass_on(now)
            wait = min((self._slots + 1) * self._create.period, self._due()) - self._now()
            ready, _, _ = select.select(self._watched(), [], [], max(0.0, wait / self._speed))
            if ready:
                self._hear(self._now())

    def _now(self) -> float:
        """Return seconds on the robot's clock; a long stall never happened."""
        now = (time.monotonic() - self._origin) * self._speed
        late = now - (self._slots + 1) * self._create.period
        if late > LONGEST_STALL * self._speed:
            self._origin += late / self._speed
            now -= late
        return now

    def _slot(self, now: float) -> None:
        self._go_wrong(now)
        self._create.host_baud(self._line.baud())
        self._create.step(now)
        self._say(now)
        for watch in self.watchers:
            watch()
        if self.control_port is not None and self.control_port.waited_on:
            self.control_port.serve(self._create.time)

    def _go_wrong(self, now: float) -> None:
        unplugged = self._faults.active(Kind.UNPLUG)
        begun = self._faults.step(now)
        if Kind.BROWNOUT in begun:
            self._create.lose_battery(now)
        if Kind.UNPLUG in begun:
            self._line.unplug()
        elif unplugged and not self._faults.active(Kind.UNPLUG):
            self._line.plug()

    def _hear(self, now: float) -> None:
        data = self._faults.to_robot(self._line.read(), now)
        if self._to_robot is not None:
            self._to_robot.put(data, now, self._line.baud() or self._create.baud)
        elif data:
            self._obey(data, now)
        if self.control_port is not None:
            self.control_port.serve(self._create.time)
            self._say(now)

    def _obey(self, data: bytes, now: float) -> None:
        self._create.receive(data, now, self._line.baud())
        self._say(now)

    def _say(self, now: float) -> None:
        data = self._faults.from_robot(self._create.data_to_send(), now)
        if self._to_host is not None:
            self._to_host.put(data, now, self._create.baud)
        else:
            self._line.write(data)

    def _pass_on(self, now: float) -> None:
        """Hand on what has arrived at either end of the wire."""
        if self._to_host is not None:
            self._line.write(self._to_host.take(now))
        if self._to_robot is not None:
            data = self._to_robot.take(now)
            if data:
                self._obey(data, now)

    def _due(self) -> float:
        pacers = (self._to_host, self._to_robot)
        return min((each.due() for each in pacers if each is not None), default=math.inf)

    def _watched(self) -> list[int]:
        watched = self._line.watched()
        return watched + self.control_port.watched() if self.control_port else watched
