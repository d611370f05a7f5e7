# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `create_view`: see a robot, and drive it, in a terminal."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import suppress
from math import inf
import select
import signal
import socket
import sys
import time

from rclpy.executors import SingleThreadedExecutor
from rclpy.utilities import remove_ros_args

from ...ros.process import call_on_signal, ros_executor, spin_ready, stop_job
from .keys import (
    action_of,
    Confirmation,
    DriveKey,
    GoalCall,
    KeyDecoder,
    ServiceCall,
    STOP,
    ViewCommand,
)
from .picture import picture
from .robot_state import CallStatus, RobotState
from .teleop import Teleop
from .terminal import check, opened, simple, Terminal, TerminalClosed, TerminalError
from .view_node import ViewNode

REDRAW = 0.1
"""Seconds between two pictures."""
KEYS_HELP = 'Arrows drive, space stops, h shows all keys, q ends.'


class RobotView:
    """The main loop: reads keys, drives and calls services, and redraws the picture."""

    def __init__(self, node: ViewNode, terminal: Terminal, *, plain: bool) -> None:
        self._node, self._terminal, self._plain = node, terminal, plain
        self._state = node.state
        self._decoder, self._teleop, self._confirmation = KeyDecoder(), Teleop(), Confirmation()
        self._ended = self._suspended = False

    def run(self, executor: SingleThreadedExecutor, end: socket.socket) -> None:
        """Run until q is typed, `end` becomes readable, or the terminal closes."""
        next_picture = -inf
        try:
            while not self._ended:
                now = time.monotonic()
                wait = min(max(0.0, next_picture - now), self._teleop.wait(now))
                ready, _, _ = select.select(
                    [self._terminal.descriptor, end.fileno()], [], [], wait)
                if end.fileno() in ready:
                    return
                if self._suspended:
                    self._suspend()
                    continue  # the keys that were ready are dropped
                if self._terminal.descriptor in ready:
                    self._read_keys(time.monotonic())
                self._drive(time.monotonic())
                if time.monotonic() >= next_picture:
                    next_picture = time.monotonic() + REDRAW
                    self._redraw(executor)
        except TerminalClosed:
            return
        finally:
            if self._teleop.driving:
                self._node.stop_robot()

    def _read_keys(self, now: float) -> None:
        for key in self._decoder.decode(self._terminal.read()):
            if self._suspended:
                return
            action = action_of(key)
            if action is not None and not self._confirmation.confirmed(action, now):
                self._state.call_status = CallStatus(
                    f'the robot will move by itself: press {key} again within a second',
                    highlighted=True)
                continue
            match action:
                case DriveKey() as drive:
                    # Without a driver the key is dropped: one that starts later must not obey it.
                    if self._state.driver_listens:
                        self._teleop.press(drive, now)
                case ServiceCall() as call:
                    self._node.call_service(call, now)
                case GoalCall() as goal:
                    self._node.send_goal(goal, now)
                case ViewCommand() as command:
                    self._do(command, now)

    def _do(self, command: ViewCommand, now: float) -> None:
        match command:
            case ViewCommand.STOP:
                self._teleop.release()
                self._drive(now)
                self._node.call_service(STOP, now)
            case ViewCommand.FASTER:
                self._teleop.change_speed(1)
            case ViewCommand.SLOWER:
                self._teleop.change_speed(-1)
            case ViewCommand.CLEAR:
                self._state.trail.clear()
            case ViewCommand.REDRAW:
                self._terminal.redraw()
            case ViewCommand.HELP:
                self._state.help_shown = not self._state.help_shown
            case ViewCommand.SUSPEND:
                self.suspend()
            case ViewCommand.QUIT:
                self._ended = True

    def suspend(self) -> None:
        """Let the main loop suspend the program, as Ctrl-Z does elsewhere."""
        self._suspended = True

    def _suspend(self) -> None:
        """Stop the robot, restore the terminal, and stop this process until `fg`."""
        if self._teleop.driving:
            self._teleop = Teleop(*self._teleop.speeds)
            self._node.stop_robot()
        self._terminal.drop_typed()
        self._terminal.leave()
        stop_job()
        # Going on in the background stops it again here, until it owns the terminal.
        self._terminal.enter()
        self._suspended, self._decoder = False, KeyDecoder()

    def _drive(self, now: float) -> None:
        velocity = self._teleop.due(now)
        if velocity is not None:
            self._node.drive(velocity)

    def _redraw(self, executor: SingleThreadedExecutor) -> None:
        self._node.find_driver(time.monotonic())
        spin_ready(executor)
        self._state.speeds, self._state.driving = self._teleop.speeds, self._teleop.driving
        columns, rows = self._terminal.size
        drawn = picture(self._state, time.monotonic(), columns, rows, plain=self._plain)
        self._terminal.show(drawn.runs())


def _view(ros_arguments: list[str], *, plain: bool) -> None:
    end, writer = socket.socketpair()

    def request_end() -> None:
        with suppress(OSError):  # the view may have ended already
            writer.send(b'.')
    call_on_signal(request_end)
    with ros_executor(ros_arguments) as executor:
        node = ViewNode(RobotState())
        executor.add_node(node)
        with opened() as terminal:
            view = RobotView(node, terminal, plain=plain)
            signal.signal(signal.SIGTSTP, lambda *_: view.suspend())
            view.run(executor, end)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_view`; 2 when this is no usable terminal."""
    given = sys.argv if arguments is None else ['create_view', *arguments]
    parser = argparse.ArgumentParser(
        prog='create_view', description=__doc__, epilog=KEYS_HELP)
    parser.add_argument('--ascii', action='store_true', help='draw with ASCII characters only')
    options = parser.parse_args(remove_ros_args(given)[1:])
    try:
        check()
        _view(given, plain=options.ascii or simple())
    except TerminalError as error:
        print(f'create_view: {error}', file=sys.stderr)
        return 2
    return 0
