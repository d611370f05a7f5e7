# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Goals for programs of a few lines: send one, wait, get its result.

Ctrl-C cancels the goal that runs, and ends the program with one line. So rclpy must not handle
signals: it would shut ROS down before the cancel is sent. Nor may one interrupt rclpy, which might
not receive anything afterwards: while a goal runs, the handler only notes it.
"""

from collections.abc import Mapping
from numbers import Integral, Real
import signal
import sys
from threading import current_thread, main_thread
from types import FrameType, TracebackType
from typing import Any

import rclpy
from rclpy.action.client import ActionClient
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from .actions import ACTIONS, malformed
from .process import end_in_time
from .programs import INTERRUPTED
from .waiting import waits_for

DISCOVERY_TIMEOUT = 10.0
"""Seconds in which a driver must be found."""
LOOK_FOR_DRIVER = 1.0
"""Seconds of waiting for it before a look at what to say."""
LOOK_EVERY = 0.1
"""Seconds after which a wait looks whether a signal has come."""
CANCEL_WAIT = 2.0
"""Seconds in which a driver must say that it has canceled a goal."""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Ctrl-C, and signals that do what it does."""
TYPES: dict[str, Any] = {action.name: action.type for action in ACTIONS}


class GoalFailed(SystemExit):
    """A goal that was not reached; unless it is caught, the program ends with its one line."""


def filled(message: Any, values: Mapping[str, Any], where: str) -> Any:
    """
    Set fields of a message, also those of messages in it, and return it.

    A whole number becomes a float where the field is one. GoalFailed: there is no such field, or
    the value does not fit; without its check fields, ROS would send something else, or abort.
    """
    types = message.get_fields_and_field_types()
    for field, value in values.items():
        if field not in types:
            raise GoalFailed(f'{where} has no field {field!r}; there are {", ".join(types)}')
        present = getattr(message, field)
        if hasattr(value, 'get_fields_and_field_types') and type(value) is type(present):
            parts = {part: getattr(value, part) for part in value.get_fields_and_field_types()}
            value = filled(type(value)(check_fields=True), parts, f'{where}: {field}')
        elif isinstance(value, Real) and not isinstance(value, bool):
            if isinstance(present, float):
                value = float(value)
            elif isinstance(value, Integral):  # such as one of numpy's
                value = int(value)
        try:
            setattr(message, field, value)
        except AssertionError:
            raise GoalFailed(f'{where}: {field} = {value!r}; allowed is a value of type '
                             f'{types[field]}') from None
    return message


class GoalClient:
    """
    A ROS node that sends goals to the driver, one after the other.

        with GoalClient() as robot:
            robot.do('drive_distance', distance=0.3)
    """

    def __init__(self, name: str = 'goal_client') -> None:
        """Take the name of the node."""
        self._name = name
        self._clients: dict[str, ActionClient] = {}
        self._handlers: dict[signal.Signals, Any] = {}
        """What handled signals before."""
        self._waiting = self._interrupted = False

    def __enter__(self) -> 'GoalClient':
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        if current_thread() is main_thread():
            self._handlers = {number: signal.signal(number, self._on_signal) for number in SIGNALS}
        self.node = rclpy.create_node(self._name)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        with end_in_time():
            for client in self._clients.values():
                client.destroy()
            self.node.destroy_node()
            rclpy.shutdown()
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        if kind is KeyboardInterrupt:
            raise SystemExit(INTERRUPTED) from None

    def do(self, name: str, **goal: Any) -> Any:
        """Pursue a goal of the action with this name; return the result, or raise GoalFailed."""
        if name not in TYPES:
            raise GoalFailed(f'no action {name!r}; there are {", ".join(TYPES)}')
        request = filled(TYPES[name].Goal(check_fields=True), goal, name)
        if name not in self._clients:
            self._clients[name] = ActionClient(self.node, TYPES[name], name)
        client = self._clients[name]
        self._find(name, client)
        result = self._pursue(name, client, request)
        if not result.success:
            raise GoalFailed(f'{name}: {result.message}')
        return result

    def _find(self, name: str, client: ActionClient) -> None:
        """Wait for the driver, and say so; GoalFailed: there is none."""
        waited, said = 0.0, False
        while not client.wait_for_server(LOOK_FOR_DRIVER):
            waited += LOOK_FOR_DRIVER
            why = waits_for(self.node, f'the action {name}', waited)
            if waited >= DISCOVERY_TIMEOUT:
                domain = self.node.context.get_domain_id()
                raise GoalFailed(f'{name}: no driver was found in ROS domain {domain}')
            if why is not None and not said:
                said = True
                print(f'{self._name}: {why}', file=sys.stderr, flush=True)

    def _pursue(self, name: str, client: ActionClient, request: Any) -> Any:
        """Send a goal and wait for its result; Ctrl-C cancels it."""
        sent = client.send_goal_async(request)
        try:
            handle = self._wait(sent)
            if not handle.accepted:
                why = malformed(name, request) or 'the log of the driver says why'
                raise GoalFailed(f'{name}: rejected as malformed; {why}')
            return self._wait(handle.get_result_async()).result
        except KeyboardInterrupt:
            return self._cancel(name, sent)

    def _cancel(self, name: str, sent: Future) -> Any:
        """Cancel a goal that was sent; return its result."""
        rclpy.spin_until_future_complete(self.node, sent, timeout_sec=CANCEL_WAIT)
        if sent.done() and sent.result().accepted:
            sent.result().cancel_goal_async()
            asked = sent.result().get_result_async()
            rclpy.spin_until_future_complete(self.node, asked, timeout_sec=CANCEL_WAIT)
            if asked.done() and asked.result().result.success:
                raise KeyboardInterrupt  # too late to cancel this one
            if asked.done():
                return asked.result().result
        raise GoalFailed(f'{name}: canceled, but the driver does not answer') from None

    def _wait(self, future: Future) -> Any:
        self._waiting = True
        try:
            while not future.done():
                rclpy.spin_once(self.node, timeout_sec=LOOK_EVERY)
                if self._interrupted:
                    self._interrupted = False
                    raise KeyboardInterrupt
        finally:
            self._waiting = False
        return future.result()

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        if not self._waiting:
            raise KeyboardInterrupt
        self._interrupted = True
