# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Processes for the bench programs: a simulated robot, the node or the floor, and listeners.

All of a scene run in one ROS domain. Run nothing else in that domain meanwhile.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
from tempfile import TemporaryDirectory
import threading
from time import monotonic, sleep
from typing import Any

from create_oi_ros import oi
from create_oi_ros.ros.programs import PROGRAMS

PROGRAM_FOLDER = Path(__file__).parent / 'programs'
DOMAIN = int(os.environ.get('ROS_DOMAIN_ID', '83'))
TIMEOUT = 60.0
"""Seconds to wait for a line of output, and for a process to end."""
MEGA = 1 << 20


class Process:
    """A child process; its standard output is read line by line, its errors are shown."""

    def __init__(self, *command: str, domain: int) -> None:
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True,
            env={**os.environ, 'ROS_DOMAIN_ID': str(domain), 'PYTHONUNBUFFERED': '1'})

    def line(self) -> str:
        """Wait for a line of output; RuntimeError: none comes."""
        assert self.process.stdout is not None
        timer = threading.Timer(TIMEOUT, self.process.kill)
        timer.start()
        line = self.process.stdout.readline()
        timer.cancel()
        if not line:
            raise RuntimeError(f'{self.process.args} ended or hung without output')
        return line

    def result(self) -> Any:
        """End the process with SIGTERM; return the JSON object that it prints last."""
        self.process.send_signal(signal.SIGTERM)
        line = self.line()
        while not line.startswith('{'):
            line = self.line()
        return json.loads(line)

    def close(self) -> None:
        """End the process; kill it if it does not end."""
        self.process.terminate()
        try:
            self.process.communicate(timeout=TIMEOUT)
        except (subprocess.TimeoutExpired, ValueError):
            self.process.kill()
        self.process.wait()


def family(number: int) -> Iterator[int]:
    """Yield the numbers of a process and its descendants."""
    yield number
    for task in Path(f'/proc/{number}/task').iterdir():
        for child in (task / 'children').read_text('ascii').split():
            yield from family(int(child))


def processor_seconds(process: Process) -> float:
    """Return the processor time that a process and its descendants have used so far, seconds."""
    return sum(int((task / 'schedstat').read_text('ascii').split()[0]) / 1e9
               for number in family(process.process.pid)
               for task in Path(f'/proc/{number}/task').iterdir())


def shares(seconds: float, *processes: Process) -> list[float]:
    """
    Wait; return the processor share of each with its descendants meanwhile, % of one core.

    RuntimeError: one of them has ended.
    """
    for process in processes:
        if process.process.poll() is not None:
            raise RuntimeError(f'{process.process.args} has ended')
    used, begun = list(map(processor_seconds, processes)), monotonic()
    sleep(seconds)
    return [100 * (processor_seconds(process) - before) / (monotonic() - begun)
            for process, before in zip(processes, used)]


def resident(number: int) -> float:
    """Return the resident memory of a process, MB."""
    pages = Path(f'/proc/{number}/statm').read_text('ascii').split()[1]
    return int(pages) * os.sysconf('SC_PAGE_SIZE') / MEGA


def drives(received: Sequence[tuple[float, str]]) -> Iterator[tuple[float, oi.DriveDirect]]:
    """Yield each Drive Direct that a robot received, and when all of it had arrived."""
    reader = oi.CommandReader()
    for when, data in received:
        reader.feed(bytes.fromhex(data))
        yield from ((when, event) for event in reader if isinstance(event, oi.DriveDirect))


class Scene(ExitStack):
    """The processes of one measurement, and a temporary folder; all end with it."""

    def __init__(self, domain: int = DOMAIN) -> None:
        super().__init__()
        folder = Path(self.enter_context(TemporaryDirectory()))
        self.port, self.control = folder / 'create', folder / 'control'
        self.domain = domain

    def start(self, *command: str) -> Process:
        process = Process(*command, domain=self.domain)
        self.callback(process.close)
        return process

    def python(self, *arguments: str) -> Process:
        return self.start(sys.executable, *arguments)

    def program(self, name: str, *arguments: str) -> Process:
        return self.python(str(PROGRAM_FOLDER / f'{name}.py'), *arguments)

    def robot(self) -> Process:
        """Start a simulated robot that logs what it sends and receives; wait until it runs."""
        robot = self.program('robot', str(self.port), str(self.control))
        robot.line()
        return robot

    def driver(self, *, floor: bool = False) -> Process:
        """Start the node, or the floor (programs/floor.py)."""
        if floor:
            return self.program('floor', str(self.port))
        return self.python('-c', PROGRAMS['create_node'], '--ros-args', '-p', f'port:={self.port}')
