"""
Robots, drivers and listeners as processes, for the programs that measure them.

All of it runs in one ROS domain, which other programs should leave alone.
"""

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
from tempfile import TemporaryDirectory
import threading
from typing import Any

from create_oi_ros import oi
from create_oi_ros.driver.stream_plan import ESSENTIAL
from create_oi_ros.ros.programs import PROGRAMS

PROGRAM_FOLDER = Path(__file__).parent / 'programs'
DOMAIN = os.environ.get('ROS_DOMAIN_ID', '83')
PATIENCE = 60.0
"""Seconds after which what should happen is taken not to."""
SPEEDS = ('requested_right_velocity', 'requested_left_velocity')
FLOOR_LIST = oi.PacketList.named(*(name for name in ESSENTIAL if name not in SPEEDS), *SPEEDS)
"""What the floor streams: as little as a driver needs in every frame."""
FLOOR_CALL = b''.join(command.encode() for command in (
    oi.Start(), oi.Safe(), oi.Stream(packets=FLOOR_LIST.ids)))
FLOOR_LAYOUT = '>xx' + ''.join(
    f'x{"h" if name in SPEEDS else "x" * oi.size_of(oi.NUMBERS[name])}'
    for name in FLOOR_LIST.names) + 'x'


class Actor:
    """A Python program as a process; what it prints comes line by line."""

    def __init__(self, *arguments: str) -> None:
        """Start it."""
        self.process = subprocess.Popen(
            [sys.executable, *arguments], stdout=subprocess.PIPE, text=True,
            stderr=subprocess.PIPE,
            env={**os.environ, 'ROS_DOMAIN_ID': DOMAIN, 'PYTHONUNBUFFERED': '1'})
        self.complaints: list[str] = []
        self._listener = threading.Thread(target=self._hear_complaints)
        self._listener.start()

    def _hear_complaints(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.complaints.append(line)

    @property
    def pid(self) -> int:
        """The process's number."""
        return self.process.pid

    def line(self) -> str:
        """Wait for a line; RuntimeError says what the program complained of instead."""
        assert self.process.stdout is not None
        impatience = threading.Timer(PATIENCE, self.process.kill)
        impatience.start()
        line = self.process.stdout.readline()
        impatience.cancel()
        if not line:
            complaints = ''.join(self.complaints)
            raise RuntimeError(f'{self.process.args} said nothing more: {complaints}')
        return line

    def told(self) -> Any:
        """End it, and return what it has to tell, which is its last line."""
        self.process.send_signal(signal.SIGTERM)
        line = self.line()
        while not line.startswith('{'):
            line = self.line()
        return json.loads(line)

    def close(self) -> None:
        """End it, whatever it does."""
        self.process.terminate()
        try:
            self.process.communicate(timeout=PATIENCE)
        except (subprocess.TimeoutExpired, ValueError):
            self.process.kill()
        self.process.wait()
        self._listener.join()


class Scene:
    """All that runs at one time; it ends with the scene."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        """Begin with an empty stage."""
        self.folder = folder
        self._stack = stack

    def start(self, *arguments: str) -> Actor:
        """Start a program."""
        actor = Actor(*arguments)
        self._stack.callback(actor.close)
        return actor

    def program(self, name: str, *arguments: str) -> Actor:
        """Start one of the programs of the bench."""
        return self.start(str(PROGRAM_FOLDER / f'{name}.py'), *arguments)

    def robot(self) -> Actor:
        """Switch on a robot that keeps a diary."""
        robot = self.program('robot', str(self.port), str(self.control))
        robot.line()
        return robot

    @property
    def port(self) -> Path:
        """The robot's port."""
        return self.folder / 'create'

    @property
    def control(self) -> Path:
        """Where the robot's world is set."""
        return self.folder / 'control'

    def driver(self, *, floor: bool = False, imports: tuple[str, ...] = ()) -> Actor:
        """Start the node, or the floor."""
        if floor:
            return self.program('floor', str(self.port), FLOOR_CALL.hex(), FLOOR_LAYOUT,
                                str(oi.DriveDirect.opcode), *imports)
        return self.start('-c', PROGRAMS['create_node'], '--ros-args', '-p', f'port:={self.port}')

    def variant(self, which: str) -> Actor:
        """Start the floor with one thing done otherwise."""
        return self.program('variant', which, str(self.port), FLOOR_CALL.hex(), FLOOR_LAYOUT)

    def listener(self, *topics: str) -> Actor:
        """Start one that subscribes to topics."""
        listener = self.program('listener', *topics)
        listener.line()
        return listener


@contextmanager
def scene() -> Iterator[Scene]:
    """Set a scene."""
    with TemporaryDirectory() as folder, ExitStack() as stack:
        yield Scene(Path(folder), stack)
