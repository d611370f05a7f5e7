# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Processes for the bench programs: a simulated robot, the node or the floor, and listeners.

All of them run in one ROS domain. Run nothing else in that domain meanwhile.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, ExitStack
import json
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
from tempfile import TemporaryDirectory
import threading
from time import monotonic, sleep
from typing import Any

from create_oi_ros import oi
from create_oi_ros.driver.stream import ESSENTIAL
from create_oi_ros.ros.programs import PROGRAMS

PROGRAM_FOLDER = Path(__file__).parent / 'programs'
DOMAIN = os.environ.get('ROS_DOMAIN_ID', '83')
TIMEOUT = 60.0
"""Seconds to wait for a line of output, and for a process to end."""
MEGA = 1 << 20
SPEEDS = ('requested_right_velocity', 'requested_left_velocity')
FLOOR_LIST = oi.PacketList([*(name for name in ESSENTIAL if name not in SPEEDS), *SPEEDS])
"""Packets that the floor streams: those that the driver needs in every frame, no more."""
FLOOR_CALL = b''.join(command.encode() for command in (
    oi.Start(), oi.Safe(), oi.Stream(packets=FLOOR_LIST.ids)))
FLOOR_LAYOUT = '>xx' + ''.join(
    f'x{"h" if name in SPEEDS else "x" * oi.size_of(oi.NUMBERS[name])}'
    for name in FLOOR_LIST.names) + 'x'


class Process:
    """A Python program as a child process; its standard output is read line by line."""

    def __init__(self, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, *arguments], stdout=subprocess.PIPE, text=True,
            stderr=subprocess.PIPE,
            env={**os.environ, 'ROS_DOMAIN_ID': DOMAIN, 'PYTHONUNBUFFERED': '1'})
        self.errors: list[str] = []
        self._error_reader = threading.Thread(target=self._read_errors)
        self._error_reader.start()

    def _read_errors(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.errors.append(line)

    def line(self) -> str:
        """Wait for a line of output; RuntimeError has the error output if none comes."""
        assert self.process.stdout is not None
        timer = threading.Timer(TIMEOUT, self.process.kill)
        timer.start()
        line = self.process.stdout.readline()
        timer.cancel()
        if not line:
            errors = ''.join(self.errors)
            raise RuntimeError(f'{self.process.args} ended or hung without output: {errors}')
        return line

    def result(self) -> Any:
        """End the process with SIGTERM; return the JSON object that it prints last."""
        self.process.send_signal(signal.SIGTERM)
        line = self.line()
        while not line.startswith('{'):
            line = self.line()
        return json.loads(line)

    def processor_share(self, seconds: float) -> float:
        """Wait; return the processor share of it and its descendants, % of one core."""
        used, begun = processor_seconds(self.process.pid), monotonic()
        sleep(seconds)
        return 100 * (processor_seconds(self.process.pid) - used) / (monotonic() - begun)

    def resident(self) -> float:
        """Return its resident memory, without its children, MB."""
        pages = Path(f'/proc/{self.process.pid}/statm').read_text('ascii').split()[1]
        return int(pages) * os.sysconf('SC_PAGE_SIZE') / MEGA

    def close(self) -> None:
        """End the process; kill it if it does not end."""
        self.process.terminate()
        try:
            self.process.communicate(timeout=TIMEOUT)
        except (subprocess.TimeoutExpired, ValueError):
            self.process.kill()
        self.process.wait()
        self._error_reader.join()


def processor_seconds(number: int) -> float:
    """Return the processor time that a process and its descendants have used so far, seconds."""
    used = 0.0
    for task in Path(f'/proc/{number}/task').iterdir():
        used += int((task / 'schedstat').read_text('ascii').split()[0]) / 1e9
        used += sum(map(processor_seconds, map(int, (task / 'children').read_text().split())))
    return used


def drives(received: Sequence[tuple[float, str]]) -> Iterator[tuple[float, oi.DriveDirect]]:
    """Yield each Drive Direct that a robot received, and when all of it had arrived."""
    reader = oi.CommandReader()
    for when, data in received:
        reader.feed(bytes.fromhex(data))
        yield from ((when, event) for event in reader if isinstance(event, oi.DriveDirect))


class Scene:
    """The processes of one measurement; all of them end with it."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.folder = folder
        self._stack = stack

    def start(self, *arguments: str) -> Process:
        process = Process(*arguments)
        self._stack.callback(process.close)
        return process

    def program(self, name: str, *arguments: str) -> Process:
        return self.start(str(PROGRAM_FOLDER / f'{name}.py'), *arguments)

    def robot(self) -> Process:
        """Start a simulated robot that logs what it sends and receives; wait until it runs."""
        robot = self.program('robot', str(self.port), str(self.control))
        robot.line()
        return robot

    @property
    def port(self) -> Path:
        return self.folder / 'create'

    @property
    def control(self) -> Path:
        return self.folder / 'control'

    @contextmanager
    def control_socket(self) -> Iterator[Callable[[str], str]]:
        """Connect to the control socket; yield a function that sends a line; its answer."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(str(self.control))
            with connection.makefile('r') as answers:
                def send(line: str) -> str:
                    connection.sendall(line.encode() + b'\n')
                    answer = answers.readline()
                    if not answer.startswith('ok'):
                        raise RuntimeError(f'{line}: {answer}')
                    return answer.removeprefix('ok ')
                yield send

    def driver(self, *, floor: bool = False) -> Process:
        """Start the node, or the floor (programs/floor.py)."""
        if floor:
            return self.program('floor', str(self.port), FLOOR_CALL.hex(), FLOOR_LAYOUT,
                                str(oi.DriveDirect.opcode))
        return self.start('-c', PROGRAMS['create_node'], '--ros-args', '-p', f'port:={self.port}')

    def listener(self, *topics: str) -> Process:
        """Start a subscriber to these topics; wait until it has subscribed."""
        listener = self.program('listener', *topics)
        listener.line()
        return listener


@contextmanager
def scene() -> Iterator[Scene]:
    """Yield a scene in a temporary folder; end its processes afterwards."""
    with TemporaryDirectory() as folder, ExitStack() as stack:
        yield Scene(Path(folder), stack)
