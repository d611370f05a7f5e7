# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Node processes, robots on simulated serial ports, and a ROS node in the test's own process."""

import codecs
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager, suppress
import fcntl
from functools import partial
from itertools import count, cycle
import os
from pathlib import Path
import signal
import subprocess
import sys
import termios
import threading
import time
from typing import Any

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import SetMode
import domain_coordinator
from geometry_msgs.msg import Twist, Vector3
from rcl_interfaces.srv import GetParameters, SetParameters
import rclpy
from rclpy.action.client import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from create_oi_ros.driver.state import Activity, REFUSALS
from create_oi_ros.robot import Rounding
from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.ros.topics import LATCHED
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig, DEFAULT_BODY
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.server import Server
from create_oi_ros.sim.server.control import ControlPort
from create_oi_ros.sim.server.faults import Faults
from create_oi_ros.sim.server.lines import PtyLine
from create_oi_ros.sim.world import Pose, shipped, World
from support.processes import kill_marked, MARK, marked

TIMEOUT = 30.0
"""Seconds to wait for an event before a test fails."""
_numbers = count()


class Robot:
    """A simulated Create on a pseudo terminal, served by a thread of the test's process."""

    def __init__(self, link: Path, world: World, rounding: Rounding, config: BodyConfig) -> None:
        self.body = Body(world, rounding=rounding, config=config)
        self.create = Create(self.body)
        self.link = link
        self._line = PtyLine(link)
        self._server = Server(self.create, self._line, Faults([]))
        self._thread = threading.Thread(target=self._server.serve)
        self._thread.start()

    def soon(self, action: Callable[[], object]) -> None:
        """Run an action on the robot's thread, as soon as it can."""
        def once() -> None:
            self._server.watchers.remove(once)
            action()
        self._server.watchers.append(once)

    @property
    def standing(self) -> bool:
        """Whether it was told to stand."""
        return self.create.actuators.wheels == (0, 0)

    def open_control(self) -> Path:
        """Open the control socket; return its path."""
        path = self.link.with_suffix('.control')
        self._server.control_port = ControlPort(path, self._server.control)
        return path

    def watch(self, watcher: Callable[[], object]) -> None:
        """Call a function after every slot, on the robot's thread."""
        self._server.watchers.append(watcher)

    def unplug(self) -> None:
        """Pull the cable."""
        self.soon(self._line.unplug)

    def plug(self) -> None:
        """Plug it in."""
        self.soon(self._line.plug)

    def close(self) -> None:
        """Stop the thread and close the terminal."""
        self._server.stop()
        self._thread.join(TIMEOUT)
        assert not self._thread.is_alive(), 'the simulated robot does not end'
        if self._server.control_port is not None:
            self._server.control_port.close()
        self._line.close()


class Program:
    """A Python program as a process; its output is read line by line."""

    def __init__(self, *arguments: str, domain: int | None, terminal: bool = False) -> None:
        """Start it in a ROS domain (None: it chooses one), and on a terminal of its own or not."""
        self.mark = f'{os.getpid()}.{next(_numbers)}'
        """Value of the variable MARK that it and all its children have."""
        environment = {**os.environ, 'PYTHONUNBUFFERED': '1', MARK: self.mark}
        if domain is not None:
            environment['ROS_DOMAIN_ID'] = str(domain)
        self._terminal, ends = -1, {'stdout': subprocess.PIPE, 'stderr': subprocess.STDOUT}
        if terminal:
            self._terminal, theirs = os.openpty()
            ends = dict.fromkeys(('stdin', 'stdout', 'stderr'), theirs)
        self._process = subprocess.Popen(
            [sys.executable, *arguments], text=True, bufsize=1, env=environment, **ends,
            # Whose terminal it is, the keys send signals to.
            start_new_session=terminal,
            preexec_fn=partial(fcntl.ioctl, 0, termios.TIOCSCTTY, 0) if terminal else None)
        if terminal:
            os.close(theirs)
        self.printed: list[str] = []
        """What it has printed, in lines; of a terminal, in the pieces that came."""
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        for line in self._process.stdout or self._pieces():
            self.printed.append(line)

    def _pieces(self) -> Iterator[str]:
        decoder = codecs.getincrementaldecoder('utf-8')()  # reads may cut characters
        with suppress(OSError):  # everybody has closed the other end
            while data := os.read(self._terminal, 65536):
                yield decoder.decode(data)

    def type(self, keys: str) -> None:
        """Press keys of its terminal."""
        os.write(self._terminal, keys.encode())

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    @property
    def output(self) -> str:
        """Everything that it has printed so far."""
        return ''.join(self.printed)

    def running(self) -> bool:
        """Whether the process still runs."""
        return self._process.poll() is None

    def send(self, number: signal.Signals) -> None:
        """Send the process a signal."""
        self._process.send_signal(number)

    def ended(self) -> int:
        """Wait for the end of the process; return its exit code."""
        code = self._process.wait(TIMEOUT)
        self._read_all()
        return code

    def outlived(self) -> list[str]:
        """Return the commands of its children that do not end after it; kill them."""
        deadline = time.monotonic() + TIMEOUT
        while marked(self.mark) and time.monotonic() < deadline:
            time.sleep(0.1)
        return kill_marked(self.mark)

    def close(self) -> None:
        """Kill it and what it has left; print its output, for pytest to show if the test fails."""
        self._process.kill()
        self._process.wait()
        kill_marked(self.mark)
        try:
            self._read_all()
        finally:
            print(self.output)
            if self._terminal >= 0:
                os.close(self._terminal)

    def _read_all(self) -> None:
        """Wait for the end of the output; kill what still can write to it, and fail."""
        self._reader.join(TIMEOUT)
        if self._reader.is_alive():
            left = kill_marked(self.mark)
            self._reader.join(TIMEOUT)
            raise AssertionError(f'these outlived the program that started them: {left}')


def children_of(pid: int) -> list[int]:
    """Return the processes that a process has started."""
    listed = Path(f'/proc/{pid}/task/{pid}/children').read_text()
    return [int(child) for child in listed.split()]


class Sent:
    """A goal that was accepted."""

    def __init__(self, ros: 'Listener', handle: Any, feedback: list[Any]) -> None:
        self._ros, self._handle = ros, handle
        self._result = handle.get_result_async()
        self.feedback = feedback
        self.status = 0

    def result(self) -> Any:
        """Wait for the result; its status is in `status` then."""
        self._ros.until(self._result.done, 'a result')
        wrapped = self._result.result()
        self.status = wrapped.status
        return wrapped.result

    def cancel(self) -> bool:
        """Cancel the goal; return whether that was accepted."""
        answer = self._handle.cancel_goal_async()
        self._ros.until(answer.done, 'the answer to a cancel')
        return bool(answer.result().goals_canceling)


class Listener:
    """A ROS node in the test's process, with a context of its own."""

    def __init__(self, domain: int, name: str = 'listener', *rules: str) -> None:
        """Create the node; remap rules are such as `__ns:=/robot1`."""
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        arguments = [part for rule in rules for part in ('-r', rule)]
        # Without services that nobody calls: rarely, the middleware hangs as it destroys one.
        self.node = rclpy.create_node(
            name, context=self._context, cli_args=['--ros-args', *arguments],
            start_parameter_services=False, enable_rosout=False,
            parameter_overrides=[Parameter('start_type_description_service', value=False)])
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self._action_clients: dict[str, ActionClient] = {}

    def listen(self, type_: type, name: str, qos: QoSProfile | int = 10) -> list[Any]:
        """Return a list that fills with the messages of a topic."""
        received: list[Any] = []
        self.node.create_subscription(type_, name, received.append, qos)
        return received

    def until(
        self, happened: Callable[[], Any], what: str = '', within: float = TIMEOUT,
    ) -> Any:
        """Spin until a condition is true and return its value; fail after so many seconds."""
        deadline = time.monotonic() + within
        while not (result := happened()):
            assert time.monotonic() < deadline, f'{what or happened} did not happen'
            self._executor.spin_once(timeout_sec=0.1)
        return result

    def drive(self, linear: float, angular: float, until: Callable[[], Any],
              topic: str = 'cmd_vel') -> None:
        """Publish a velocity again and again until a condition is true."""
        velocity = self.node.create_publisher(Twist, topic, 1)
        command = Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))
        self.until(lambda: velocity.publish(command) or until(), f'driving {linear}, {angular}')
        self.node.destroy_publisher(velocity)

    def call(self, type_: type, name: str, **fields: Any) -> Any:
        """
        Call a service and return its reply.

        A new client can call before the service knows where to send the reply, and then the
        reply is lost. So clients are kept, and a call without a reply is repeated once.
        """
        if name not in self._clients:
            self._clients[name] = self.node.create_client(type_, name)
        client = self._clients[name]
        self.until(client.service_is_ready, f'service {name}')
        futures = [client.call_async(type_.Request(**fields))]
        repeat_at = time.monotonic() + TIMEOUT / 3

        def answered() -> bool:
            if time.monotonic() > repeat_at and len(futures) == 1:
                futures.append(client.call_async(type_.Request(**fields)))
            return any(future.done() for future in futures)
        self.until(answered, f'reply of {name}')
        return next(future.result() for future in futures if future.done())

    def parameters(self, node: str, *names: str) -> list[Any]:
        """Return parameters of a node."""
        reply = self.call(GetParameters, f'{node}/get_parameters', names=names)
        return [*map(parameter_value_to_python, reply.values)]

    def send(self, type_: Any, name: str, **fields: Any) -> Sent | None:
        """Send a goal of an action; return it, None where it was rejected."""
        if name not in self._action_clients:
            self._action_clients[name] = ActionClient(self.node, type_, name)
        client = self._action_clients[name]
        self.until(client.server_is_ready, f'action {name}')
        feedback: list[Any] = []
        answer = client.send_goal_async(
            type_.Goal(**fields),
            feedback_callback=lambda message: feedback.append(message.feedback))
        self.until(answer.done, f'the answer of {name}')
        handle = answer.result()
        return Sent(self, handle, feedback) if handle.accepted else None

    def close(self) -> None:
        """Destroy the node, after its clients of actions, and its context."""
        self._executor.shutdown()
        for client in self._action_clients.values():
            client.destroy()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)


class Scene:
    """The processes and robots of one test; all of them end with the test."""

    def __init__(self, folder: Path, domain: int) -> None:
        self.folder = folder
        self.domain = domain
        self.ros = Listener(domain)
        self._closing: list[Callable[[], None]] = []

    def robot(
        self, name: str = 'create', *, world: World | None = None,
        rounding: Rounding = Rounding.CARRY, config: BodyConfig = DEFAULT_BODY,
    ) -> Robot:
        """Start a simulated robot; its port is `folder / name`."""
        made = Robot(self.folder / name, world or shipped('empty'), rounding, config)
        self._closing.append(made.close)
        return made

    def listener(self, name: str) -> Listener:
        """Add another node to the graph, in a context of its own."""
        made = Listener(self.domain, name)
        self._closing.append(made.close)
        return made

    def program(self, name: str, *arguments: str, terminal: bool = False) -> Program:
        """Start one of the package's executables."""
        return self.python('-c', PROGRAMS[name], *arguments, terminal=terminal)

    def example(self, name: str, *arguments: str) -> Program:
        """Start one of the programs in examples/."""
        return self.python(str(Path(__file__).parents[2] / 'examples' / name), *arguments)

    def python(self, *arguments: str, terminal: bool = False) -> Program:
        """Start Python with these arguments."""
        made = Program(*arguments, domain=self.domain, terminal=terminal)
        self._closing.append(made.close)
        return made

    def node(self, port: Path, *remaps: str, **parameters: object) -> Program:
        """Start the driver, with remaps and parameters."""
        arguments = ['--ros-args', '-p', f'port:={port}']
        for name, value in parameters.items():
            written = str(value).lower() if isinstance(value, bool) else value
            arguments += ['-p', f'{name}:={written}']
        for remap in remaps:
            arguments += ['-r', remap]
        return self.program('create_node', *arguments)

    def close(self) -> None:
        """
        End the listener, then everything else, newest first.

        The other order can crash the middleware: it may not learn that other nodes are gone while
        it destroys its own.
        """
        self.ros.close()
        for close in reversed(self._closing):
            close()


class Ready:
    """A robot and its node in Safe mode, which tests share: `renew` puts everything back."""

    def __init__(self, stage: Scene, world: World | None = None, **parameters: object) -> None:
        self.stage, self.ros = stage, stage.ros
        self.robot = stage.robot(world=world)
        self.node = stage.node(self.robot.link, **parameters)
        self.modes = self.ros.listen(Mode, 'mode', LATCHED)
        self.until_mode(Mode.SAFE)
        node = self.ros.node
        self._kept = {*node.subscriptions, *node.publishers, *node.timers}

    def until_mode(self, mode: int) -> None:
        """Wait until the newest `mode` message has this mode."""
        self.ros.until(lambda: self.modes and self.modes[-1].mode == mode, f'mode {mode}')

    def reply(self, type_: type, name: str, **fields: object) -> Any:
        """Return the reply; a computer that stood still may have lost the robot for a moment."""
        def answered() -> Any:
            reply = self.ros.call(type_, name, **fields)
            return None if reply.message == REFUSALS[Activity.CALLING] else reply
        return self.ros.until(answered, f'an answer to {name}')

    def ask(self, type_: type, name: str, **fields: object) -> str:
        """Call a service that must succeed; return its message."""
        reply = self.reply(type_, name, **fields)
        assert reply.success, reply.message
        return str(reply.message)

    def refused(self, type_: type, name: str, **fields: object) -> str:
        """Call a service that must fail; return its message."""
        reply = self.reply(type_, name, **fields)
        assert not reply.success
        assert reply.message
        return str(reply.message)

    def set(self, name: str, value: float) -> bool:
        """Set a parameter of the node that is a number; return whether that was accepted."""
        wanted = Parameter(name, value=value).to_parameter_msg()
        result, = self.ros.call(
            SetParameters, 'create/set_parameters', parameters=[wanted]).results
        assert result.successful or result.reason
        return bool(result.successful)

    def renew(self) -> None:
        """Put the robot back where it began, in Safe mode, and forget what a test listened to."""
        node, body = self.ros.node, self.robot.body
        for each in {*node.subscriptions} - self._kept:
            node.destroy_subscription(each)
        for each in {*node.publishers} - self._kept:
            node.destroy_publisher(each)
        for each in {*node.timers} - self._kept:
            node.destroy_timer(each)
        body.unforce()
        body.plug_charger(False)
        body.lift(False)
        body.hold()
        body.drop()
        self.ros.call(Trigger, 'stop')
        self.ros.until(lambda: self.ros.call(SetMode, 'set_mode', mode=Mode.SAFE).success)
        self.until_mode(Mode.SAFE)
        self.ros.until(lambda: not any(body.truth()[1:3]), 'the robot stands')
        body.place(Pose())
        self.ask(Trigger, 'reset_odometry')


_next_domains = cycle(range(1, 101))


def own_domain() -> AbstractContextManager[int]:
    """
    Reserve a ROS domain that no other process uses; yield its number.

    Domains are taken in turn, so a test does not get that of the test before it.
    """
    return domain_coordinator.domain_id(lambda: next(_next_domains))


@contextmanager
def scene(folder: Path) -> Iterator[Scene]:
    """Yield a scene in a ROS domain of its own; end it afterwards."""
    with own_domain() as domain, closing(Scene(folder, domain)) as made:
        yield made
