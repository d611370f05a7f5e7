"""
A simulated Create that keeps a diary: `robot.py LINK CONTROL`.

It notes when it spoke, what it heard, and when its bumper was pressed. On SIGTERM it prints all
that, times in seconds of the monotonic clock, which all processes share.
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
from create_oi_ros.sim.server.control_port import ControlPort
from create_oi_ros.sim.server.lines import PtyLine
from create_oi_ros.sim.world import shipped


class NotingLine(PtyLine):
    """A pseudo terminal that keeps a diary."""

    def __init__(self, link: Path) -> None:
        """Lead the link to a new terminal."""
        self.said: list[float] = []
        self.heard: list[tuple[float, str]] = []
        super().__init__(link)

    def write(self, data: bytes) -> None:
        """Note when the last byte was written."""
        super().write(data)
        if data:
            self.said.append(monotonic())

    def read(self) -> bytes:
        """Note what came, and when."""
        data = super().read()
        if data:
            self.heard.append((monotonic(), data.hex()))
        return data


class NotingBody(Body):
    """A body that notes when its bumper is pressed from outside."""

    pressed: list[float] = []

    def force(self, **sensors: float) -> None:
        """Hold sensors at values."""
        super().force(**sensors)
        if sensors.get('bump_left'):
            self.pressed.append(monotonic())


def main(link: Path, control: Path) -> None:
    """Serve until SIGTERM."""
    line = NotingLine(link)
    create = Create(NotingBody(shipped('empty')), guesses=Guesses(boot_seconds=0.0))
    server = Server(create, line)
    server.control_port = ControlPort(control, server.control)
    signal.signal(signal.SIGTERM, lambda *_: server.stop())
    print('serves', flush=True)
    server.serve()
    line.close()
    print(json.dumps({'said': line.said, 'heard': line.heard, 'pressed': NotingBody.pressed}))


main(Path(sys.argv[1]), Path(sys.argv[2]))
