"""A real node process on a simulated serial port, and a listener in this process."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import signal
import subprocess
import sys
import threading
import time
from typing import Any

import domain_coordinator
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile

from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.encoders import Rounding
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.server import Server
from create_oi_ros.sim.server.faults import Faults
from create_oi_ros.sim.server.lines import PtyLine
from create_oi_ros.sim.world import shipped, World

PATIENCE = 30.0
"""Seconds after which an event that a test waits for is taken not to come."""


class Robot:
    """A simulated Create, served on a pseudo terminal by a thread of this process."""

    def __init__(self, link: Path, world: World, rounding: Rounding) -> None:
        self.body = Body(world, rounding=rounding)
        self.create = Create(self.body)
        self.link = link
        self._line = PtyLine(link)
        self._server = Server(self.create, self._line, Faults([]))
        self._thread = threading.Thread(target=self._server.serve)
        self._thread.start()

    def soon(self, action: Callable[[], object]) -> None:
        """Do something to the robot on its own thread."""
        def once() -> None:
            self._server.watchers.remove(once)
            action()
        self._server.watchers.append(once)

    def close(self) -> None:
        """Pull the cable out."""
        self._server.stop()
        self._thread.join()
        self._line.close()


class Program:
    """A Python program as a process; what it prints can be waited for."""

    def __init__(self, *arguments: str, domain: int) -> None:
        environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain), 'PYTHONUNBUFFERED': '1'}
        self._process = subprocess.Popen(
            [sys.executable, *arguments], text=True, bufsize=1,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment)
        self.printed: list[str] = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.printed.append(line)

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    @property
    def output(self) -> str:
        """All it has printed."""
        return ''.join(self.printed)

    def running(self) -> bool:
        """Tell whether it has not ended yet."""
        return self._process.poll() is None

    def send(self, number: signal.Signals) -> None:
        """Send it a signal."""
        self._process.send_signal(number)

    def ended(self) -> int:
        """Wait for its end; return its exit code."""
        code = self._process.wait(PATIENCE)
        self._reader.join()
        return code

    def close(self) -> None:
        """End it, whatever it is doing; what it printed is shown where the test fails."""
        if self.running():
            self._process.kill()
        self._process.wait()
        self._reader.join()
        print(self.output)


class Listener:
    """A node of the test's own, in its own context."""

    def __init__(self, domain: int, name: str = 'listener') -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = rclpy.create_node(name, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}

    def listen(self, type_: type, name: str, qos: QoSProfile | int = 10) -> list[Any]:
        """Return a list that fills with the messages of a topic."""
        heard: list[Any] = []
        self.node.create_subscription(type_, name, heard.append, qos)
        return heard

    def until(self, happened: Callable[[], Any], what: str = '') -> Any:
        """Spin until something has happened; fail when it does not."""
        deadline = time.monotonic() + PATIENCE
        while not (result := happened()):
            assert time.monotonic() < deadline, f'{what or happened} did not happen'
            self._executor.spin_once(timeout_sec=0.1)
        return result

    def call(self, type_: type, name: str, **fields: Any) -> Any:
        """
        Call a service and return its reply.

        A client that has just come may be asked before the service knows where to reply to; such
        a reply is lost. So a client is kept, and asks again when it has heard nothing for long.
        """
        if name not in self._clients:
            self._clients[name] = self.node.create_client(type_, name)
        client = self._clients[name]
        self.until(client.service_is_ready, f'service {name}')
        futures = [client.call_async(type_.Request(**fields))]
        again = time.monotonic() + PATIENCE / 3

        def answered() -> bool:
            if time.monotonic() > again and len(futures) == 1:
                futures.append(client.call_async(type_.Request(**fields)))
            return any(future.done() for future in futures)
        self.until(answered, f'reply of {name}')
        return next(future.result() for future in futures if future.done())

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)


class Scene:
    """What a test with real processes works with; all of it ends with the test."""

    def __init__(self, folder: Path, domain: int) -> None:
        self.folder = folder
        self.domain = domain
        self.ros = Listener(domain)
        self._closing: list[Callable[[], None]] = []

    def robot(
        self, name: str = 'create', *, world: World | None = None,
        rounding: Rounding = Rounding.CARRY,
    ) -> Robot:
        """Switch a robot on."""
        made = Robot(self.folder / name, world or shipped('empty'), rounding)
        self._closing.append(made.close)
        return made

    def listener(self, name: str) -> Listener:
        """Add another node to the graph, in a context of its own."""
        made = Listener(self.domain, name)
        self._closing.append(made.close)
        return made

    def program(self, name: str, *arguments: str) -> Program:
        """Start one of our executables."""
        return self._start('-c', PROGRAMS[name], *arguments)

    def example(self, name: str) -> Program:
        """Start one of the examples."""
        return self.script(Path(__file__).parents[2] / 'examples' / name)

    def script(self, path: Path, *arguments: str) -> Program:
        """Start a Python file."""
        return self._start(str(path), *arguments)

    def _start(self, *arguments: str) -> Program:
        made = Program(*arguments, domain=self.domain)
        self._closing.append(made.close)
        return made

    def node(self, port: Path, *remaps: str, **parameters: object) -> Program:
        """Start the driver."""
        arguments = ['--ros-args', '-p', f'port:={port}']
        for name, value in parameters.items():
            written = str(value).lower() if isinstance(value, bool) else value
            arguments += ['-p', f'{name}:={written}']
        for remap in remaps:
            arguments += ['-r', remap]
        return self.program('create_node', *arguments)

    def close(self) -> None:
        """
        End everything: the listener, then the newest first.

        The middleware may crash where its own things are destroyed while it learns that others
        are gone.
        """
        self.ros.close()
        for close in reversed(self._closing):
            close()


_used = 0


def _next_domain() -> int:
    """Go through the domains in turn, so that a test never meets the one before it."""
    global _used
    _used += 1
    return (_used - 1) % 100 + 1


@contextmanager
def scene(folder: Path) -> Iterator[Scene]:
    """Set a scene in a ROS domain of its own."""
    with domain_coordinator.domain_id(_next_domain) as domain:
        made = Scene(folder, domain)
        try:
            yield made
        finally:
            made.close()
