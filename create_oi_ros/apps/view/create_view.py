"""The command `create_view`: see a robot, and drive it, in a terminal."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import suppress
from math import inf
import select
import socket
import sys
import time

from rclpy.executors import SingleThreadedExecutor
from rclpy.utilities import remove_ros_args

from ...ros.process import call_on_signal, ros_executor
from .graph import Graph, take_in
from .keys import action_of, Ask, Drive, Keyboard, Own, STOP
from .picture import picture
from .robot_state import State
from .teleop import Teleop
from .terminal import check, HungUp, opened, simple, Terminal, TerminalError

REDRAW = 0.1
"""Seconds between two pictures."""
KEYS_HELP = 'Arrows drive, space stops, h shows all keys, q ends.'


class View:
    """One who sits at the terminal: what is typed becomes action, what is heard a picture."""

    def __init__(self, graph: Graph, terminal: Terminal, *, plain: bool) -> None:
        self._graph, self._terminal, self._plain = graph, terminal, plain
        self._state = graph.state
        self._keyboard, self._teleop = Keyboard(), Teleop()
        self._ended = False

    def run(self, executor: SingleThreadedExecutor, ending: socket.socket) -> None:
        """Go on until somebody types q, `ending` can be read, or the terminal has gone."""
        next_picture = -inf
        try:
            while not self._ended:
                now = time.monotonic()
                wait = min(max(0.0, next_picture - now), self._teleop.wait(now))
                ready, _, _ = select.select(
                    [self._terminal.descriptor, ending.fileno()], [], [], wait)
                if ending.fileno() in ready:
                    return
                if self._terminal.descriptor in ready:
                    self._typed(time.monotonic())
                self._steer(time.monotonic())
                if time.monotonic() >= next_picture:
                    next_picture = time.monotonic() + REDRAW
                    self._look(executor)
        except HungUp:
            return
        finally:
            if self._teleop.driving:
                self._graph.say_goodbye()

    def _typed(self, now: float) -> None:
        for key in self._keyboard.keys(self._terminal.read()):
            match action_of(key):
                case Drive() as drive:
                    # Who comes later must not drive by a key of before.
                    if self._state.listened:
                        self._teleop.press(drive, now)
                case Ask() as ask:
                    self._graph.ask(ask, now)
                case Own() as own:
                    self._do(own, now)

    def _do(self, own: Own, now: float) -> None:
        match own:
            case Own.STOP:
                self._teleop.release()
                self._steer(now)
                self._graph.ask(STOP, now)
            case Own.FASTER:
                self._teleop.faster(1)
            case Own.SLOWER:
                self._teleop.faster(-1)
            case Own.CLEAR:
                self._state.track.clear()
            case Own.REDRAW:
                self._terminal.redraw()
            case Own.HELP:
                self._state.helping = not self._state.helping
            case Own.QUIT:
                self._ended = True

    def _steer(self, now: float) -> None:
        velocity = self._teleop.due(now)
        if velocity is not None:
            self._graph.drive(velocity)

    def _look(self, executor: SingleThreadedExecutor) -> None:
        self._graph.look_around(time.monotonic())
        take_in(executor)
        self._state.speeds, self._state.driving = self._teleop.speeds, self._teleop.driving
        columns, rows = self._terminal.size
        drawn = picture(self._state, time.monotonic(), columns, rows, plain=self._plain)
        self._terminal.show(drawn.runs())


def _view(ros_arguments: list[str], *, plain: bool) -> None:
    ending, end = socket.socketpair()

    def ended() -> None:
        with suppress(OSError):  # it may be over already
            end.send(b'.')
    call_on_signal(ended)
    with ros_executor(ros_arguments) as executor:
        graph = Graph(State())
        executor.add_node(graph)
        with opened() as terminal:
            View(graph, terminal, plain=plain).run(executor, ending)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_view`; 2 where there is no terminal to be seen on."""
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
