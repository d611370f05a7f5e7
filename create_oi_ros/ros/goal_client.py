# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Goals and services for programs of a few lines: send one, wait or look after it, get its result.

What fails is a GoalFailed. Ctrl-C cancels the goal that runs, and ends the program with one line.
So rclpy must not handle signals: it would shut ROS down before the cancel is sent.
"""

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from contextlib import suppress
import sys
from types import TracebackType
from typing import Any, TypeVar

import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import ok

from .actions import ACTION_TYPES
from .driver_client import DriverClient, Goal, GoalState, Reply
from .messages import filled
from .process import end_in_time, stop_signals_as_ctrl_c
from .programs import INTERRUPTED
from .services import SERVICE_TYPES
from .waiting import say_if_waiting

Result = TypeVar('Result')
SPIN_INTERVAL = 0.02
"""Seconds for which rclpy waits at most before coroutines run again."""
COMPLETE_INTERVAL = 0.1
"""Seconds that `is_complete` takes at most."""
CANCEL_TIMEOUT = 2.0
"""Seconds in which a driver must say that it has canceled a goal."""


class GoalFailed(Exception):
    """A goal or a call that failed; the message is a sentence for people."""


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
        self._restore_signals: Callable[[], None] | None = None
        self._goal: Goal | None = None
        self._pursued: asyncio.Task[Reply] | None = None

    def __enter__(self) -> 'GoalClient':
        if not ok():
            rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
            self._restore_signals = stop_signals_as_ctrl_c()
        self.node = rclpy.create_node(self._name, namespace=self._namespace)
        self._driver = DriverClient(self.node)
        self._runner = asyncio.Runner()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        with end_in_time():
            with suppress(GoalFailed):  # the driver may have gone
                self.cancel()
            self._runner.close()
            self._driver.destroy()
            self.node.destroy_node()
            if self._restore_signals is not None:
                rclpy.shutdown()
        if self._restore_signals is not None:
            self._restore_signals()
            if kind is KeyboardInterrupt:
                raise SystemExit(INTERRUPTED) from None

    @property
    def feedback(self) -> Any:
        """The newest feedback of the goal; None: none has come."""
        return None if self._goal is None else self._goal.feedback

    def do(self, name: str, **goal: Any) -> Any:
        """Pursue a goal of the action with this name; return the result, or raise GoalFailed."""
        self.start(name, **goal)
        try:
            while not self.is_complete():
                pass
        except KeyboardInterrupt:
            self.cancel()
            if self._goal is not None and self._goal.state is GoalState.REACHED:
                raise  # too late to cancel this one
        return self.result()

    def start(self, name: str, **goal: Any) -> None:
        """Send a goal; GoalFailed: it is malformed, or no driver was found. One runs at a time."""
        request = _message(ACTION_TYPES, 'action', name, goal, 'Goal')
        if self._goal is not None and not self.is_complete():
            raise GoalFailed(f'{self._goal.name} still runs: wait until is_complete(), or '
                             'cancel()')
        accepted = asyncio.Event()
        self._goal = Goal(self._driver, name, request, lambda _: accepted.set())
        self._pursued = self._runner.get_loop().create_task(self._goal.pursue())
        self._run(self._answered(f'the action {name}', accepted.wait()))
        if self._goal.state is GoalState.FAILED:
            self.result()

    def is_complete(self, timeout: float = COMPLETE_INTERVAL) -> bool:
        """Receive for so many seconds at most; return whether the goal has ended."""
        if self._pursued is None:
            return True
        if not self._pursued.done():
            self._run(asyncio.wait([self._pursued], timeout=timeout))
        return self._pursued.done()

    def result(self) -> Any:
        """Return the result of the goal that has ended; GoalFailed: it was not reached."""
        name = 'a goal' if self._goal is None else self._goal.name
        if self._goal is None or self._goal.reply is None:
            raise GoalFailed(f'{name} has not ended: wait until is_complete()')
        return _checked(name, self._goal.reply)

    def cancel(self) -> None:
        """Cancel the goal that runs, and wait for its end; GoalFailed: the driver is silent."""
        if self._goal is not None:
            self._goal.cancel()
            if not self.is_complete(CANCEL_TIMEOUT):
                raise GoalFailed(f'{self._goal.name}: canceled, but the driver does not answer')

    def call(self, name: str, **fields: Any) -> Any:
        """Call the service with this name; return its reply, or raise GoalFailed."""
        request = _message(SERVICE_TYPES, 'service', name, fields, 'Request')
        return _checked(name, self._run(self._answered(
            f'the service {name}', self._driver.call(name, request))))

    def _run(self, work: Coroutine[Any, Any, Result]) -> Result:
        """Let a coroutine run to its end while rclpy runs; KeyboardInterrupt: Ctrl-C."""
        async def beside_rclpy() -> Result:
            spinning = asyncio.create_task(self._spin())
            try:
                return await work
            finally:
                spinning.cancel()
        return self._runner.run(beside_rclpy())

    async def _spin(self) -> None:
        while True:
            rclpy.spin_once(self.node, timeout_sec=SPIN_INTERVAL)
            await asyncio.sleep(0)

    async def _answered(self, what: str, work: Coroutine[Any, Any, Result]) -> Result:
        """Wait for an answer of the driver; say once why it may not come."""
        answer = asyncio.create_task(work)
        say_if_waiting(self.node, what, lambda: not answer.done(), lambda why: print(
            f'{self._name}: {why}', file=sys.stderr, flush=True))
        return await answer


def _message(types: Mapping[str, Any], what: str, name: str, fields: Mapping[str, Any],
             part: str) -> Any:
    """Return a goal or request with these fields; GoalFailed: one of the names is wrong."""
    if name not in types:
        raise GoalFailed(f'no {what} {name!r}; there are {", ".join(types)}')
    try:
        return filled(getattr(types[name], part)(check_fields=True), fields, name)
    except ValueError as error:
        raise GoalFailed(str(error)) from None


def _checked(name: str, reply: Reply) -> Any:
    """Return what the driver has answered; GoalFailed: it could not do it."""
    if not reply.ok:
        raise GoalFailed(f'{name}: {reply.text}')
    return reply.message
