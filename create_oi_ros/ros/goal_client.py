# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Goals and services for programs of a few lines: send one, wait or look after it, get its result.

What fails is a GoalFailed. Ctrl-C cancels the goal that runs, and ends the program with one line.
So rclpy must not handle signals: it would shut ROS down before the cancel is sent. Nor may one
interrupt rclpy, which might not receive anything afterwards: while rclpy runs, the handler only
notes it.
"""

from collections.abc import Callable, Mapping
from math import inf
import signal
import sys
from threading import current_thread, main_thread
import time
from types import FrameType, TracebackType
from typing import Any

import rclpy
from rclpy.action.client import ActionClient
from rclpy.client import Client
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import ok

from .actions import ALL_ACTIONS, malformed
from .messages import filled
from .process import end_in_time, STOP_SIGNALS
from .programs import INTERRUPTED
from .services import SERVICES
from .waiting import DISCOVERY_TIMEOUT, say_if_waiting

ANSWER_TIMEOUT = 10.0
"""Seconds in which it must answer a call of a service."""
LOOK_EVERY = 0.1
"""Seconds after which a wait looks whether a signal has come."""
CANCEL_WAIT = 2.0
"""Seconds in which a driver must say that it has canceled a goal."""
TYPES: dict[str, Any] = {action.name: action.type for action in ALL_ACTIONS}
SERVICE_TYPES: dict[str, Any] = {service.name: service.type for service in SERVICES}


class GoalFailed(Exception):
    """A goal or a call that failed; the message is a sentence for people."""


def _request(type_: Any, fields: Mapping[str, Any], where: str) -> Any:
    """Return a message with these fields; GoalFailed: one does not exist, or does not fit."""
    try:
        return filled(type_(check_fields=True), fields, where)
    except ValueError as error:
        raise GoalFailed(str(error)) from None


class _Interrupts:
    """Ctrl-C and its like: noted while rclpy runs, a KeyboardInterrupt at all other times."""

    def __init__(self) -> None:
        self.spinning = self.noted = False
        self._before: dict[signal.Signals, Any] = {}

    def handle(self) -> None:
        """Handle the signals from now on, in the main thread."""
        if current_thread() is main_thread():
            self._before = {each: signal.signal(each, self._on_signal) for each in STOP_SIGNALS}

    def restore(self) -> None:
        """Leave the signals to what handled them before."""
        for each, handler in self._before.items():
            signal.signal(each, handler)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        if not self.spinning:
            raise KeyboardInterrupt
        self.noted = True

    def spin_once(self, node: Node, timeout: float) -> None:
        """Run callbacks of a node for a while, seconds; KeyboardInterrupt: a signal came."""
        self.spinning = True
        try:
            rclpy.spin_once(node, timeout_sec=timeout)
        finally:
            self.spinning = False
        if self.noted:
            self.noted = False
            raise KeyboardInterrupt


_interrupts = _Interrupts()


class GoalClient:
    """
    A ROS node that sends goals to the driver, one after the other, and calls its services.

        with GoalClient() as robot:
            robot.do('drive_distance', distance=0.3)
            robot.call('set_leds', play=True)

            robot.start('rotate_angle', angle=6.28)
            while not robot.is_complete():
                print(robot.feedback)

    The first client of a program starts rclpy and handles signals, unless the program did so: then
    it is a further node beside the program's own. Ctrl-C cancels the goals that run.
    """

    def __init__(self, name: str = 'goal_client', namespace: str = '') -> None:
        self._name, self._namespace = name, namespace
        self._clients: dict[str, ActionClient] = {}
        self._services: dict[str, Client] = {}
        self._owner = False
        self._goal = ''
        self._sent: Future | None = None
        self._awaited: Future | None = None
        self.feedback: Any = None
        """The newest feedback of the goal; None: none has come."""

    def __enter__(self) -> 'GoalClient':
        if not ok():
            self._owner = True
            rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
            _interrupts.handle()
        self.node = rclpy.create_node(self._name, namespace=self._namespace)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        with end_in_time():
            self._cancel_running()
            for client in self._clients.values():
                client.destroy()
            self.node.destroy_node()
            if self._owner:
                rclpy.shutdown()
        if self._owner:
            _interrupts.restore()
            if kind is KeyboardInterrupt:
                raise SystemExit(INTERRUPTED) from None

    def do(self, name: str, **goal: Any) -> Any:
        """Pursue a goal of the action with this name; return the result, or raise GoalFailed."""
        self.start(name, **goal)
        try:
            while not self.is_complete():
                pass
        except KeyboardInterrupt:
            self.cancel()
        return self.result()

    def start(self, name: str, **goal: Any) -> None:
        """Send a goal; GoalFailed: it is malformed, or no driver was found. One runs at a time."""
        if name not in TYPES:
            raise GoalFailed(f'no action {name!r}; there are {", ".join(TYPES)}')
        if self._sent is not None and not self.is_complete():
            raise GoalFailed(f'{self._goal} still runs: wait until is_complete(), or cancel()')
        request = _request(TYPES[name].Goal, goal, name)
        if name not in self._clients:
            self._clients[name] = ActionClient(self.node, TYPES[name], name)
        self._find(name, f'the action {name}', self._clients[name].server_is_ready)
        self._goal, self.feedback, self._awaited = name, None, None
        self._sent = self._clients[name].send_goal_async(
            request, lambda message: setattr(self, 'feedback', message.feedback))
        try:
            self._wait(self._sent.done)
        except KeyboardInterrupt:
            self._cancel_running()
            raise
        handle = self._sent.result()
        if not handle.accepted:
            self._sent = None
            why = malformed(name, request) or 'the log of the driver says why'
            raise GoalFailed(f'{name}: rejected as malformed; {why}')
        self._awaited = handle.get_result_async()

    def is_complete(self) -> bool:
        """Receive for a tenth of a second; return whether the goal has ended."""
        if self._awaited is not None and not self._awaited.done():
            self._spin()
        return self._awaited is None or self._awaited.done()

    def result(self) -> Any:
        """Return the result of the goal that has ended; GoalFailed: it was not reached."""
        if self._awaited is None or not self._awaited.done():
            raise GoalFailed(f'{self._goal or "a goal"} has not ended: wait until is_complete()')
        result = self._awaited.result().result
        if not result.success:
            raise GoalFailed(f'{self._goal}: {result.message}')
        return result

    def cancel(self) -> None:
        """Cancel the goal that runs, and wait for its end; GoalFailed: the driver is silent."""
        if not self._cancel_running():
            raise GoalFailed(f'{self._goal}: canceled, but the driver does not answer') from None
        if self._awaited is not None and self._awaited.result().result.success:
            raise KeyboardInterrupt  # too late to cancel this one

    def call(self, name: str, **fields: Any) -> Any:
        """Call the service with this name; return its reply, or raise GoalFailed."""
        if name not in SERVICE_TYPES:
            raise GoalFailed(f'no service {name!r}; there are {", ".join(SERVICE_TYPES)}')
        request = _request(SERVICE_TYPES[name].Request, fields, name)
        if name not in self._services:
            self._services[name] = self.node.create_client(SERVICE_TYPES[name], name)
        self._find(name, f'the service {name}', self._services[name].service_is_ready)
        answer = self._services[name].call_async(request)
        try:
            if not self._wait(answer.done, ANSWER_TIMEOUT):
                raise GoalFailed(f'{name}: the driver does not answer')
        finally:
            self._services[name].remove_pending_request(answer)
        if not answer.result().success:
            raise GoalFailed(f'{name}: {answer.result().message}')
        return answer.result()

    def _spin(self) -> None:
        """Receive for a while; KeyboardInterrupt: a signal came."""
        _interrupts.spin_once(self.node, LOOK_EVERY)

    def _wait(self, done: Callable[[], bool], seconds: float = inf) -> bool:
        """Receive until something is done; return whether it is, after so many seconds at most."""
        until = time.monotonic() + seconds
        while not done() and time.monotonic() < until:
            self._spin()
        return done()

    def _find(self, name: str, what: str, ready: Callable[[], bool]) -> None:
        """Wait for the driver, and say so; GoalFailed: there is none."""
        if not ready():
            say_if_waiting(self.node, what, lambda: not ready(), lambda why: print(
                f'{self._name}: {why}', file=sys.stderr, flush=True))
        if not self._wait(ready, DISCOVERY_TIMEOUT):
            domain = self.node.context.get_domain_id()
            raise GoalFailed(f'{name}: no driver was found in ROS domain {domain}')

    def _cancel_running(self) -> bool:
        """Cancel a goal that was sent and has not ended; return whether it has ended now."""
        if self._sent is None or (self._awaited is not None and self._awaited.done()):
            return True
        if not self._wait(self._sent.done, CANCEL_WAIT) or not self._sent.result().accepted:
            return bool(self._sent.done())
        self._sent.result().cancel_goal_async()
        self._awaited = self._awaited or self._sent.result().get_result_async()
        return self._wait(self._awaited.done, CANCEL_WAIT)
