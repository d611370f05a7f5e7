"""
A simulated Create that other programs open like a serial port: `create_sim`.

The robot's clock is the computer's, cut into slots of 15 ms with absolute deadlines, so that it
does not drift.  A slot that is late is made up for at once, up to `LONGEST_STALL`; what a longer
stall (a laptop that slept) has cost is left out, for robot and world alike.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import select
import signal
import sys
import time

from create_oi_ros.oi import Checksum, SLOT
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.encoders import Rounding
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.guesses import Guesses
from create_oi_ros.sim.lines import Line, PtyLine
from create_oi_ros.sim.world import World

LONGEST_STALL = 0.25
"""Seconds."""


class Server:
    """One robot on one line, in real time."""

    def __init__(self, create: Create, line: Line, speed: float = 1.0) -> None:
        self._create, self._line, self._speed = create, line, speed
        self._origin = 0.0
        self._slots = 0
        self.stopping = False

    def stop(self) -> None:
        """End `serve` soon; may be called from a signal's function."""
        self.stopping = True

    def serve(self) -> None:
        """Serve until `stop`."""
        self._origin = time.monotonic()
        while not self.stopping:
            now = self._now()
            wait = (self._slots + 1) * SLOT - now
            if wait <= 0:
                self._slots = int(now / SLOT + 1e-6)
                self._create.host_baud(self._line.baud())
                self._create.step(now)
                self._line.write(self._create.data_to_send())
                continue
            ready, _, _ = select.select(self._line.watched(), [], [], wait / self._speed)
            if ready:
                self._hear()

    def _now(self) -> float:
        """Seconds on the robot's clock; a long stall never happened."""
        now = (time.monotonic() - self._origin) * self._speed
        late = now - (self._slots + 1) * SLOT
        if late > LONGEST_STALL * self._speed:
            self._origin += late / self._speed
            now -= late
        return now

    def _hear(self) -> None:
        data = self._line.read()
        if data:
            self._create.receive(data, self._now(), self._line.baud())
            self._line.write(self._create.data_to_send())


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='create_sim', description='Serve a simulated iRobot Create on a pseudo terminal.')
    parser.add_argument('--link', type=Path, help='symbolic link to the terminal')
    parser.add_argument('--odometry', choices=[each.value for each in Rounding],
                        default=Rounding.TRUNCATE.value)
    parser.add_argument('--checksum', choices=[each.value for each in Checksum],
                        default=Checksum.HARDWARE.value)
    parser.add_argument('--seed', type=int, default=0)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_sim`."""
    options = _arguments().parse_args(arguments)
    body = Body(World(), rounding=Rounding(options.odometry), seed=options.seed)
    create = Create(body, checksum=Checksum(options.checksum), guesses=Guesses(),
                    seed=options.seed)
    line = PtyLine(options.link)
    server = Server(create, line)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: server.stop())
    print(f'A simulated Create is on {line.name}. Ctrl-C ends it.', flush=True)
    try:
        server.serve()
    finally:
        line.close()
    return 0


if __name__ == '__main__':
    sys.exit(main())
