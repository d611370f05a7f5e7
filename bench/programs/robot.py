# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A simulated Create that logs what happens on its line: `robot.py LINK CONTROL`.

It logs when it sent bytes, what it received and when, and when its bumper was pressed. On SIGTERM
it prints the log as JSON. Times are seconds of the monotonic clock, which all processes share.
"""

import json
from pathlib import Path
import signal
import sys
from time import monotonic

from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.server import Server
from create_oi_ros.sim.server.control import ControlPort
from create_oi_ros.sim.server.lines import PtyLine
from create_oi_ros.sim.world import shipped


class LoggingLine(PtyLine):
    """A pseudo terminal that logs what goes through it."""

    def __init__(self, link: Path) -> None:
        self.sent: list[float] = []
        self.received: list[tuple[float, str]] = []
        super().__init__(link)

    def write(self, data: bytes) -> None:
        """Log when the last byte was written."""
        super().write(data)
        if data:
            self.sent.append(monotonic())

    def read(self) -> bytes:
        """Log what came, and when."""
        data = super().read()
        if data:
            self.received.append((monotonic(), data.hex()))
        return data


class LoggingBody(Body):
    """A body that logs when its bumper is pressed by the control socket."""

    presses: list[float] = []

    def force(self, **sensors: float) -> None:
        super().force(**sensors)
        if sensors.get('bump_left'):
            self.presses.append(monotonic())


def main(link: Path, control: Path) -> None:
    """Serve until SIGTERM, then print the log."""
    line = LoggingLine(link)
    create = Create(LoggingBody(shipped('empty')), guesses=Guesses(boot_seconds=0.0))
    server = Server(create, line)
    server.control_port = ControlPort(control, server.control)
    signal.signal(signal.SIGTERM, lambda *_: server.stop())
    print('ready', flush=True)
    server.serve()
    line.close()
    print(json.dumps(
        {'sent': line.sent, 'received': line.received, 'presses': LoggingBody.presses}))


main(Path(sys.argv[1]), Path(sys.argv[2]))
